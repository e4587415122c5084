#include "viewworth/value.h"

#include <inttypes.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "ledger/find_image.h"
#include "value/measure.h"
#include "value/probe_scores.h"
#include "viewworth/memory.h"

struct estimator {
    const char *method, *unit;
    const struct vw_measure *measure;
    double sign; // +1 where more is better, -1 where less is
};

static const struct estimator estimators[] = {
    {"dv_psnr", "dB", &vw_measure_psnr, 1},
    {"dv_loss", "mean absolute error", &vw_measure_l1, -1},
    {"dv_psnr_pooled", "dB", &vw_measure_psnr_pooled, 1},
};

// What is known of one image.
struct tally {
    double sum; // of its deltas
    struct vw_spread deltas;
    struct vw_mean_variance sampling; // over its probed steps
};

static double standard_error_of_sum(const struct tally *tally) {
    return sqrt(vw_spread_variance(&tally->deltas) * (double)tally->deltas.count);
}

// Given the states they start from, the deltas of different steps are drawn independently, so that their variances add up; those of the
// probed steps stand for all.
static double sampling_error_of_sum(const struct tally *tally) {
    return sqrt((double)tally->deltas.count * vw_mean_variance_result(&tally->sampling));
}

static enum vw_status find_tally(const struct vw_value_input *input, const struct vw_step_record *record, struct tally *tallies,
                                 struct tally **tally) {
    const struct vw_ledger_image *image = vw_ledger_find_image(input->images, input->image_count, record->view);
    if (!image)
        return vw_fail(VW_ERROR_INPUT, "step %" PRIu64 ": trained on image %u, which the image table lacks; verify the ledger",
                       record->step, record->view);
    *tally = &tallies[image - input->images];
    return VW_OK;
}

// Deltas are summed in the order of the steps, so that equal ledgers give equal bits.
static enum vw_status tally_steps(const struct estimator *estimator, const struct vw_value_input *input, struct tally *tallies) {
    double before = NAN;
    uint64_t taken = 0;
    for (uint64_t i = 0; i < input->record_count; i++) {
        const struct vw_step_record *record = &input->records[i];
        struct vw_step_probes probes = vw_step_probes_take(input, record->step, &taken);
        double after = vw_measure_of_record(estimator->measure, record);
        double delta = estimator->sign * (after - before);
        if (isfinite(after)) before = after;
        if (record->epoch < input->burn_in_epochs || record->view == VW_RECORD_UNTRAINED) continue;
        struct tally *tally = NULL;
        enum vw_status status = find_tally(input, record, tallies, &tally);
        if (status) return status;
        vw_mean_variance_add(&tally->sampling, vw_step_sampling_variance(estimator->measure, record, probes));
        if (!isfinite(delta)) continue;
        tally->sum += delta;
        vw_spread_add(&tally->deltas, delta);
    }
    return VW_OK;
}

// Appends a score per train image; nothing when no image was visited after burn-in.
static void append_scores(const struct estimator *estimator, const struct tally *tallies, const struct vw_value_input *input,
                          struct vw_ledger_score *scores, uint32_t *score_count) {
    bool visited = false;
    for (uint32_t i = 0; i < input->image_count; i++) visited = visited || tallies[i].deltas.count > 0;
    for (uint32_t i = 0; visited && i < input->image_count; i++) {
        if (strcmp(input->images[i].split, "train") != 0) continue;
        scores[(*score_count)++] = (struct vw_ledger_score){
            .image_id = input->images[i].image_id,
            .method = estimator->method,
            .value = tallies[i].sum,
            .unit = estimator->unit,
            .standard_error = standard_error_of_sum(&tallies[i]),
            .visits = (uint32_t)tallies[i].deltas.count,
            .sampling_error = sampling_error_of_sum(&tallies[i]),
        };
    }
}

enum vw_status vw_value_score(const struct vw_value_input *input, struct vw_ledger_score **scores, uint32_t *score_count) {
    enum vw_status status = VW_OK;
    uint32_t count = 0, probe_methods = 0;
    (void)vw_probe_methods(&probe_methods);
    struct tally *tallies = vw_allocate(input->image_count, sizeof *tallies);
    struct vw_ledger_score *made = vw_allocate((size_t)input->image_count * (VW_ARRAY_COUNT(estimators) + probe_methods), sizeof *made);
    if (!tallies || !made) status = VW_ERROR_MEMORY;
    for (size_t i = 0; !status && i < VW_ARRAY_COUNT(estimators); i++) {
        memset(tallies, 0, input->image_count * sizeof *tallies);
        status = tally_steps(&estimators[i], input, tallies);
        if (!status) append_scores(&estimators[i], tallies, input, made, &count);
    }
    if (!status) status = vw_probe_scores_append(input, made, &count);
    free(tallies);
    if (status) {
        free(made);
        return status;
    }
    *scores = made;
    *score_count = count;
    return VW_OK;
}
