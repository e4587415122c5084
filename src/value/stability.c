#include "value/stability.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "value/evaluation/score_tables.h"
#include "base/memory.h"
#include "base/statistics.h"

static uint32_t count_train_photos(const struct vw_value_input *input) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < input->image_count; i++) count += strcmp(input->images[i].split, "train") == 0;
    return count;
}

// Keeps the values of train photos; returns their count, that of photos with a value.
static uint32_t keep_train_photos(const struct vw_value_input *input, double *values) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < input->image_count; i++)
        if (strcmp(input->images[i].split, "train") == 0 && !isnan(values[i])) values[count++] = values[i];
    return count;
}

// Spearman's correlation of the scores after `epochs` that count with those after half of them; NaN where there are
// none.
static enum vw_status correlate_with_half(const struct vw_value_input *input, const char *method, uint32_t photos,
                                          uint32_t epochs, double *correlation) {
    const struct vw_value_input now = vw_value_input_truncate(input, input->burn_in_epochs + epochs);
    const struct vw_value_input earlier = vw_value_input_truncate(input, input->burn_in_epochs + epochs / 2);
    double *values = vw_allocate(input->image_count, 2 * sizeof *values), *before = values + input->image_count;
    enum vw_status status = values ? vw_value_of_method(&now, method, values) : VW_ERROR_MEMORY;
    if (!status) status = vw_value_of_method(&earlier, method, before);
    *correlation = NAN;
    if (!status && keep_train_photos(input, values) == photos && keep_train_photos(input, before) == photos)
        status = vw_spearman(values, before, photos, correlation);
    free(values);
    return status;
}

enum vw_status vw_value_stability(const struct vw_value_input *input, const char *method,
                                  struct vw_stability *stability) {
    uint32_t photos = count_train_photos(input), burn_in = input->burn_in_epochs;
    uint64_t complete = photos && input->record_count ? (input->record_count - 1) / photos : 0;
    *stability =
        (struct vw_stability){.epochs = complete > burn_in ? (uint32_t)complete - burn_in : 0, .correlation = NAN};
    stability->earlier_epochs = stability->epochs / 2;
    if (stability->epochs < VW_STABILITY_EPOCHS_MIN) return VW_OK;
    enum vw_status status = VW_OK;
    for (uint32_t back = 0; !status && back < VW_STABILITY_ENDS; back++) {
        double correlation;
        status = correlate_with_half(input, method, photos, stability->epochs - back, &correlation);
        if (back == 0 || isnan(correlation) || correlation < stability->correlation)
            stability->correlation = correlation;
    }
    return status;
}

bool vw_stability_reaches(const struct vw_stability *stability, double wanted) {
    return stability->correlation >= wanted;
}
