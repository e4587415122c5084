#include "value/series.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

#include "ledger/find_image.h"
#include "value/momentum.h"
#include "viewworth/memory.h"

static enum vw_status find_image(const struct vw_value_input *input, const struct vw_step_record *record, uint32_t *image) {
    const struct vw_ledger_image *found = vw_ledger_find_image(input->images, input->image_count, record->view);
    if (!found)
        return vw_fail(VW_ERROR_INPUT, "step %" PRIu64 ": trained on image %u, which the image table lacks; verify the ledger",
                       record->step, record->view);
    *image = (uint32_t)(found - input->images);
    return VW_OK;
}

// Epochs are counted by where they change, so that there are never more of them than visits, whatever their numbers are.
static void append(struct vw_series *series, const struct vw_visit *visit, uint32_t epoch, uint32_t *last_epoch) {
    if (series->count == 0 || epoch != *last_epoch) series->epoch_count++;
    *last_epoch = epoch;
    series->visits[series->count] = *visit;
    series->visits[series->count++].epoch = series->epoch_count - 1;
}

// `before` has the value that the next delta starts from: one entry for all photos in the step form, one for each in the revisit form.
static enum vw_status take_visits(const struct vw_value_input *input, const struct vw_measure *measure, double sign, bool revisit,
                                  double *before, struct vw_series *series) {
    uint64_t taken = 0;
    uint32_t last_epoch = 0;
    for (uint64_t i = 0; i < input->record_count; i++) {
        const struct vw_step_record *record = &input->records[i];
        struct vw_step_probes probes = vw_step_probes_take(input, record->step, &taken);
        bool trained = record->view != VW_RECORD_UNTRAINED;
        struct vw_visit visit = {0};
        enum vw_status status = trained ? find_image(input, record, &visit.image) : VW_OK;
        if (status) return status;
        double after = vw_measure_of_record(measure, record);
        double *from = &before[revisit ? visit.image : 0];
        visit.delta = sign * (after - *from);
        if (!isfinite(visit.delta)) visit.delta = NAN;
        if (isfinite(after) && (trained || !revisit)) *from = after;
        if (!trained || record->epoch < input->burn_in_epochs) continue;
        visit.sampling_variance = vw_step_sampling_variance(measure, record, probes);
        append(series, &visit, record->epoch, &last_epoch);
    }
    return VW_OK;
}

enum vw_status vw_series_make(const struct vw_value_input *input, const struct vw_measure *measure, double sign, enum vw_form form,
                              struct vw_series *series) {
    *series = (struct vw_series){.visits = vw_allocate(input->record_count, sizeof *series->visits)};
    double *before = vw_allocate((size_t)input->image_count + 1, sizeof *before);
    enum vw_status status = series->visits && before ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t i = 0; !status && i <= input->image_count; i++) before[i] = NAN;
    if (!status) status = take_visits(input, measure, sign, form == VW_FORM_REVISIT, before, series);
    free(before);
    if (!status && form == VW_FORM_DECONVOLVED) status = vw_momentum_deconvolve(input->beta1, input->image_count, series);
    return status;
}

void vw_series_free(struct vw_series *series) {
    free(series->visits);
    *series = (struct vw_series){0};
}

enum vw_status vw_series_sort_by_photo(struct vw_series *series, uint32_t image_count, uint64_t *starts) {
    struct vw_visit *sorted = vw_allocate(series->count, sizeof *sorted);
    uint64_t *next = vw_allocate(image_count, sizeof *next);
    enum vw_status status = sorted && next ? VW_OK : VW_ERROR_MEMORY;
    for (uint64_t i = 0; !status && i < series->count; i++) next[series->visits[i].image]++;
    uint64_t start = 0;
    for (uint32_t i = 0; !status && i < image_count; i++) {
        starts[i] = start;
        start += next[i];
        next[i] = starts[i];
    }
    starts[image_count] = start;
    for (uint64_t i = 0; !status && i < series->count; i++) sorted[next[series->visits[i].image]++] = series->visits[i];
    free(next);
    if (status) {
        free(sorted);
        return status;
    }
    free(series->visits);
    series->visits = sorted;
    return VW_OK;
}
