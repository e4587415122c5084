#include "viewworth/stability.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "viewworth/memory.h"
#include "viewworth/statistics.h"

static uint32_t count_train_photos(const struct vw_value_input *input) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < input->image_count; i++) count += strcmp(input->images[i].split, "train") == 0;
    return count;
}

// The records of step 0 and of the first `epochs` epochs.
static uint64_t count_records(uint32_t photos, uint32_t epochs) { return 1 + (uint64_t)photos * epochs; }

static struct vw_value_input first_epochs(const struct vw_value_input *input, uint32_t photos, uint32_t epochs) {
    struct vw_value_input part = *input;
    part.record_count = count_records(photos, epochs);
    return part;
}

// The method's scores, in image order: `count` of them, one per train photo.
static enum vw_status list_values(const struct vw_value_input *input, const char *method, double *values, uint32_t *count) {
    struct vw_ledger_score *scores = NULL;
    uint32_t score_count = 0;
    enum vw_status status = vw_value_score(input, &scores, &score_count);
    *count = 0;
    for (uint32_t i = 0; !status && i < score_count; i++)
        if (strcmp(scores[i].method, method) == 0) values[(*count)++] = scores[i].value;
    free(scores);
    return status;
}

// Spearman's correlation of the scores after `epochs` that count with those after half of them; NaN where there are none.
static enum vw_status correlate_with_half(const struct vw_value_input *input, const char *method, uint32_t photos, uint32_t epochs,
                                          double *correlation) {
    const struct vw_value_input now = first_epochs(input, photos, input->burn_in_epochs + epochs);
    const struct vw_value_input earlier = first_epochs(input, photos, input->burn_in_epochs + epochs / 2);
    uint32_t now_count = 0, earlier_count = 0;
    double *values = vw_allocate(photos, 2 * sizeof *values);
    enum vw_status status = values ? list_values(&now, method, values, &now_count) : VW_ERROR_MEMORY;
    if (!status) status = list_values(&earlier, method, values + photos, &earlier_count);
    *correlation = NAN;
    if (!status && now_count == photos && earlier_count == photos) status = vw_spearman(values, values + photos, photos, correlation);
    free(values);
    return status;
}

enum vw_status vw_value_stability(const struct vw_value_input *input, const char *method, struct vw_stability *stability) {
    uint32_t photos = count_train_photos(input), burn_in = input->burn_in_epochs;
    uint64_t complete = photos && input->record_count ? (input->record_count - 1) / photos : 0;
    *stability = (struct vw_stability){.epochs = complete > burn_in ? (uint32_t)complete - burn_in : 0, .correlation = NAN};
    stability->earlier_epochs = stability->epochs / 2;
    if (stability->epochs < VW_STABILITY_EPOCHS_MIN) return VW_OK;
    enum vw_status status = VW_OK;
    for (uint32_t back = 0; !status && back < VW_STABILITY_ENDS; back++) {
        double correlation;
        status = correlate_with_half(input, method, photos, stability->epochs - back, &correlation);
        if (back == 0 || isnan(correlation) || correlation < stability->correlation) stability->correlation = correlation;
    }
    return status;
}

bool vw_stability_reaches(const struct vw_stability *stability, double wanted) { return stability->correlation >= wanted; }
