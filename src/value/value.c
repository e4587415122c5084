#include "viewworth/value.h"

#include <inttypes.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "value/lasting_scores.h"
#include "value/methods.h"
#include "value/quality.h"
#include "value/uncertainty.h"

struct statistics {
    double sum;
    uint32_t visits;
};

struct scoring {
    const struct vw_method *method;
    const struct vw_value_input *input;
    struct vw_series series; // photo by photo
    uint64_t *starts;        // index of each photo's first visit
    double *weights;         // per epoch
    double *by_epoch;        // contribution of each photo's visits in each epoch, photo by photo; NaN without a visit
    struct statistics *statistics; // per photo
    struct vw_interval *intervals;
    double *values; // per photo: scratch
};

// Sums contributions in the order of the steps, so that equal ledgers give equal bits.
static struct statistics count_visits(const struct scoring *scoring, uint32_t image) {
    struct statistics statistics = {0};
    double *by_epoch = &scoring->by_epoch[(size_t)image * scoring->series.epoch_count];
    for (uint32_t e = 0; e < scoring->series.epoch_count; e++) by_epoch[e] = NAN;
    for (uint64_t i = scoring->starts[image]; i < scoring->starts[image + 1]; i++) {
        const struct vw_visit *visit = &scoring->series.visits[i];
        double weight = scoring->weights[visit->epoch], contribution = weight * visit->delta,
               *of_epoch = &by_epoch[visit->epoch];
        if (weight == 0) continue;
        if (!isfinite(contribution)) continue;
        statistics.sum += contribution;
        statistics.visits++;
        *of_epoch = isnan(*of_epoch) ? contribution : *of_epoch + contribution;
    }
    return statistics;
}

static struct vw_ledger_score score_photo(const struct scoring *scoring, uint32_t image) {
    const struct statistics *statistics = &scoring->statistics[image];
    const struct vw_interval *interval = &scoring->intervals[image];
    return (struct vw_ledger_score){
        .image_id = scoring->input->images[image].image_id,
        .method = scoring->method->name,
        .value = statistics->sum,
        .unit = scoring->method->unit,
        .standard_error = interval->standard_error,
        .visits = statistics->visits,
        .ci_low = interval->ci_low,
        .ci_high = interval->ci_high,
    };
}

// Appends a score per train image; nothing if no image has a visit that counts.
static void append_scores(const struct scoring *scoring, struct vw_ledger_score *scores, uint32_t *score_count) {
    const struct vw_value_input *input = scoring->input;
    struct vw_ledger_score *own = &scores[*score_count];
    uint32_t count = 0;
    bool visited = false;
    for (uint32_t i = 0; i < input->image_count; i++) visited = visited || scoring->statistics[i].visits > 0;
    if (!visited) return;
    for (uint32_t i = 0; i < input->image_count; i++)
        if (strcmp(input->images[i].split, "train") == 0) own[count++] = score_photo(scoring, i);
    for (uint32_t i = 0; i < count; i++) scoring->values[i] = own[i].value;
    vw_rank_intervals(own, count, vw_length_variance(scoring->values, count));
    *score_count += count;
}

enum { ENTRIES_LEAST = 1 << 20, ENTRIES_PER_STEP = 16 };

// Refuses a ledger whose steps spread over far more epochs than they fill: a training visits most photos in an epoch,
// and the table of photos and epochs would take all memory.
static enum vw_status check_epochs(const struct scoring *scoring) {
    const struct vw_value_input *input = scoring->input;
    uint64_t entries = (uint64_t)input->image_count * scoring->series.epoch_count;
    if (entries <= ENTRIES_LEAST || entries / ENTRIES_PER_STEP <= input->record_count) return VW_OK;
    return vw_fail(VW_ERROR_INPUT,
                   "%u photos and %u epochs are too many for %" PRIu64 " steps: an epoch visits every photo once; "
                   "correct the epochs",
                   input->image_count, scoring->series.epoch_count, input->record_count);
}

static enum vw_status allocate(struct scoring *scoring) {
    size_t images = scoring->input->image_count, epochs = scoring->series.epoch_count;
    enum vw_status status = check_epochs(scoring);
    if (status) return status;
    scoring->starts = vw_allocate(images + 1, sizeof *scoring->starts);
    scoring->weights = vw_allocate(epochs, sizeof *scoring->weights);
    scoring->by_epoch = vw_allocate(images, epochs * sizeof *scoring->by_epoch);
    scoring->statistics = vw_allocate(images, sizeof *scoring->statistics);
    scoring->intervals = vw_allocate(images, sizeof *scoring->intervals);
    scoring->values = vw_allocate(images, sizeof *scoring->values);
    bool whole = scoring->values && scoring->starts && scoring->weights && scoring->by_epoch && scoring->statistics &&
                 scoring->intervals;
    return whole ? VW_OK : VW_ERROR_MEMORY;
}

// Computes each photo's contributions from the steps.
static enum vw_status prepare(struct scoring *scoring) {
    const struct vw_method *method = scoring->method;
    const struct vw_value_input *input = scoring->input;
    enum vw_status status = vw_series_make(input, method->measure, method->form, &scoring->series);
    if (!status) status = allocate(scoring);
    if (!status) status = vw_series_sort_by_photo(&scoring->series, input->image_count, scoring->starts);
    if (status) return status;
    for (uint32_t e = 0; e < scoring->series.epoch_count; e++) scoring->weights[e] = 1;
    if (method->weighting) method->weighting(scoring->weights, scoring->series.epoch_count);
    for (uint32_t i = 0; i < input->image_count; i++) scoring->statistics[i] = count_visits(scoring, i);
    return VW_OK;
}

static void discard(struct scoring *scoring) {
    vw_series_free(&scoring->series);
    free(scoring->starts);
    free(scoring->weights);
    free(scoring->by_epoch);
    free(scoring->statistics);
    free(scoring->intervals);
    free(scoring->values);
}

static enum vw_status score_by(const struct vw_method *method, const struct vw_value_input *input,
                               struct vw_ledger_score *scores, uint32_t *score_count) {
    if (method->form == VW_FORM_DECONVOLVED && !(input->beta1 > 0)) return VW_OK; // it equals the step form
    struct scoring scoring = {.method = method, .input = input};
    enum vw_status status = prepare(&scoring);
    if (!status)
        status =
            vw_intervals_of_sums(scoring.by_epoch, input->image_count, scoring.series.epoch_count, scoring.intervals);
    if (!status) append_scores(&scoring, scores, score_count);
    discard(&scoring);
    return status;
}

enum { OTHER_METHODS = 4 }; // quality, train_fit, lasting_psnr, lasting_loss

enum vw_status vw_value_score(const struct vw_value_input *input, struct vw_ledger_score **scores,
                              uint32_t *score_count) {
    enum vw_status status = VW_OK;
    uint32_t count = 0, most = vw_method_count + input->further_count + OTHER_METHODS;
    struct vw_ledger_score *made = vw_allocate((size_t)input->image_count * most, sizeof *made);
    if (!made) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; !status && i < vw_method_count; i++) status = score_by(&vw_methods[i], input, made, &count);
    if (!status) status = vw_quality_append(input, made, &count);
    if (!status) status = vw_lasting_scores_append(input, made, &count);
    for (uint32_t i = 0; !status && i < input->further_count; i++)
        status = score_by(&input->further[i], input, made, &count);
    if (status) {
        free(made);
        return status;
    }
    *scores = made;
    *score_count = count;
    return VW_OK;
}
