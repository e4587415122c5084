#include "value/series.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "ledger/find_image.h"

static enum vw_status find_image(const struct vw_value_input *input, const struct vw_step_record *record,
                                 uint32_t *image) {
    const struct vw_ledger_image *found = NULL;
    enum vw_status status = vw_ledger_require_image(input->images, input->image_count, record->view, &found);
    if (status) return vw_fail_context(status, "step %" PRIu64, record->step);
    *image = (uint32_t)(found - input->images);
    return VW_OK;
}

// Counts epochs by where their number changes, so that there are never more epochs than visits.
static void append(struct vw_series *series, const struct vw_visit *visit, uint32_t epoch, uint32_t *last_epoch) {
    if (series->count == 0 || epoch != *last_epoch) series->epoch_count++;
    *last_epoch = epoch;
    series->visits[series->count] = *visit;
    series->visits[series->count++].epoch = series->epoch_count - 1;
}

// State for computing the deltas of successive steps.
struct reader {
    enum vw_measure measure;
    double beta1;
    enum vw_form form;
    double
        *before; // the measure that a delta starts from: one per image in the revisit form, otherwise the first entry
    double last_delta; // delta of the step before; NaN: unknown
    bool bridges;      // whether the next delta spans steps that were trained but not validated
};

// Inverts Adam's momentum b, by which the delta of a step is a mix of the credits of this and earlier steps: d(t) = (1
// - b) c(t) + b d(t - 1). A step flagged as non-finite was skipped: it leaves the first moment unchanged and counts as
// not taken. A step that was trained but not validated has changed the moment; only the sum of its delta and the next
// one is known, so that these two steps and the step after them have no credit.
static double undo_momentum(struct reader *reader, const struct vw_step_record *record, double delta) {
    if (record->view == VW_RECORD_UNTRAINED || record->nonfinite) return NAN;
    if (reader->bridges) delta = NAN;
    reader->bridges = !record->validated;
    double credit = (delta - reader->beta1 * reader->last_delta) / (1 - reader->beta1);
    reader->last_delta = delta;
    return credit;
}

static double take_delta(struct reader *reader, const struct vw_step_record *record, uint32_t image) {
    bool psnr = reader->measure == VW_MEASURE_PSNR, revisit = reader->form == VW_FORM_REVISIT,
         trained = record->view != VW_RECORD_UNTRAINED;
    double after = psnr ? record->val_psnr : record->val_l1, *before = &reader->before[revisit ? image : 0];
    double delta = psnr ? after - *before : -(after - *before);
    if (isfinite(after) && (trained || !revisit)) *before = after;
    if (!isfinite(delta)) delta = NAN;
    return reader->form == VW_FORM_DECONVOLVED ? undo_momentum(reader, record, delta) : delta;
}

static enum vw_status take_visits(const struct vw_value_input *input, struct reader *reader, struct vw_series *series) {
    uint32_t last_epoch = 0;
    for (uint64_t i = 0; i < input->record_count; i++) {
        const struct vw_step_record *record = &input->records[i];
        bool trained = record->view != VW_RECORD_UNTRAINED;
        struct vw_visit visit = {0};
        enum vw_status status = trained ? find_image(input, record, &visit.image) : VW_OK;
        if (status) return status;
        visit.delta = take_delta(reader, record, visit.image);
        if (!trained || record->epoch < input->burn_in_epochs) continue;
        visit.train_loss = record->nonfinite ? NAN : record->train_loss;
        append(series, &visit, record->epoch, &last_epoch);
    }
    return VW_OK;
}

enum vw_status vw_series_make(const struct vw_value_input *input, enum vw_measure measure, enum vw_form form,
                              struct vw_series *series) {
    *series = (struct vw_series){.visits = vw_allocate(input->record_count, sizeof *series->visits)};
    struct reader reader = {.measure = measure, .beta1 = input->beta1, .form = form};
    reader.before = vw_allocate((size_t)input->image_count + 1, sizeof *reader.before);
    enum vw_status status = series->visits && reader.before ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t i = 0; !status && i <= input->image_count; i++) reader.before[i] = NAN;
    if (!status) status = take_visits(input, &reader, series);
    free(reader.before);
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

// ---- Statistics of steps --------------------------------------------------------------------------------------------

enum { NONFINITE_BY_CHANCE = 20 };
const double vw_step_statistics_nonfinite_max = 0.1;

struct vw_step_statistics vw_step_statistics_begin(void) {
    return (struct vw_step_statistics){.first_val_psnr_db = NAN, .last_val_psnr_db = NAN};
}

void vw_step_statistics_add(struct vw_step_statistics *statistics, const struct vw_step_record *record) {
    if (record->step == 0) statistics->first_val_psnr_db = record->val_psnr;
    statistics->steps = record->step;
    statistics->nonfinite += record->nonfinite;
    statistics->finite += record->step > 0 && !record->nonfinite;
    statistics->floored += record->floored_views > 0;
    statistics->clamped += record->clamped_count;
    if (isfinite(record->val_psnr)) statistics->last_val_psnr_db = record->val_psnr;
}

bool vw_step_statistics_are_void(const struct vw_step_statistics *statistics) {
    return statistics->steps > 0 && !statistics->finite;
}

bool vw_step_statistics_should_abort(const struct vw_step_statistics *statistics) {
    return statistics->nonfinite > NONFINITE_BY_CHANCE &&
           (double)statistics->nonfinite > vw_step_statistics_nonfinite_max * (double)statistics->steps;
}
