#include "value/probe_scores.h"

#include <inttypes.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "ledger/find_image.h"
#include "value/measure.h"
#include "base/memory.h"

static const struct vw_probe_method methods[] = {
    {"same_state_psnr", "dB",
     "mean over states and draws of (val_psnr after a step on the photo - val_psnr of the state)"},
    {"same_state_loss", "mean absolute error",
     "mean over states and draws of (val_l1 of the state - val_l1 after a step on the photo)"},
    {"first_order_psnr", "dB", "sum over visits of the gradient of val_psnr times the step"},
    {"first_order_loss", "mean absolute error", "- sum over visits of the gradient of val_l1 times the step"},
};

// How each method is computed.
static const struct {
    enum vw_probe_kind kind;
    const struct vw_measure *measure;
    double sign;
} rules[VW_ARRAY_COUNT(methods)] = {
    {VW_PROBE_SAME_STATE, &vw_measure_psnr, 1},
    {VW_PROBE_SAME_STATE, &vw_measure_l1, -1},
    {VW_PROBE_FIRST_ORDER, &vw_measure_psnr, 1},
    {VW_PROBE_FIRST_ORDER, &vw_measure_l1, -1},
};

const struct vw_probe_method *vw_probe_methods(uint32_t *count) {
    *count = VW_ARRAY_COUNT(methods);
    return methods;
}

// The statistics of one image. Plain sums are used for the score itself, so that one SQL query gives the same value.
struct statistics {
    double sum;
    struct vw_spread all;          // all contributions
    uint64_t step;                 // the step after which `state` was probed
    struct vw_spread state;        // contributions of the current state
    struct vw_spread state_means;  // means of the earlier states
    struct vw_mean_variance draws; // variances within the earlier states
};

static void close_state(struct statistics *statistics) {
    if (!statistics->state.count) return;
    vw_spread_add(&statistics->state_means, statistics->state.mean);
    vw_mean_variance_add(&statistics->draws, vw_spread_variance(&statistics->state));
    statistics->state = (struct vw_spread){0};
}

static void add(struct statistics *statistics, uint64_t step, double contribution) {
    if (!isfinite(contribution)) return;
    if (statistics->step != step) close_state(statistics);
    statistics->step = step;
    statistics->sum += contribution;
    vw_spread_add(&statistics->all, contribution);
    vw_spread_add(&statistics->state, contribution);
}

static enum vw_status add_probe(size_t method, const struct vw_value_input *input, const struct vw_step_record *record,
                                const struct vw_probe *probe, struct statistics *statistics) {
    uint32_t view = probe->view == VW_RECORD_UNTRAINED ? record->view : probe->view;
    const struct vw_ledger_image *image = vw_ledger_find_image(input->images, input->image_count, view);
    if (!image)
        return vw_fail(
            VW_ERROR_INPUT,
            "step %" PRIu64
            ": probe %u is of image %u, which is not in the image table; check the ledger with viewworth verify",
            record->step, probe->index, view);
    double value = vw_measure_of_probe(rules[method].measure, probe);
    if (rules[method].kind == VW_PROBE_SAME_STATE) value -= vw_measure_of_record(rules[method].measure, record);
    add(&statistics[image - input->images], record->step, rules[method].sign * value);
    return VW_OK;
}

static enum vw_status count_probes(size_t method, const struct vw_value_input *input, struct statistics *statistics) {
    enum vw_status status = VW_OK;
    uint64_t taken = 0;
    for (uint64_t i = 0; i < input->record_count; i++) {
        const struct vw_step_record *record = &input->records[i];
        struct vw_step_probes probes = vw_step_probes_take(input, record->step, &taken);
        for (uint64_t p = 0; p < probes.count && record->epoch >= input->burn_in_epochs && !status; p++)
            if (probes.probes[p].kind == rules[method].kind)
                status = add_probe(method, input, record, &probes.probes[p], statistics);
    }
    for (uint32_t i = 0; i < input->image_count; i++) close_state(&statistics[i]);
    return status;
}

// The score of a photo without contributions is 0, like that of a photo that was never visited.
static struct vw_ledger_score score_of(size_t method, uint32_t image_id, const struct statistics *statistics) {
    struct vw_ledger_score score = {.image_id = image_id,
                                    .method = methods[method].name,
                                    .value = statistics->sum,
                                    .unit = methods[method].unit,
                                    .standard_error =
                                        sqrt(vw_spread_variance(&statistics->all) * (double)statistics->all.count),
                                    .visits = (uint32_t)statistics->all.count,
                                    .resampling_stderr = NAN,
                                    .ci_low = NAN, // too few states for an interval
                                    .ci_high = NAN};
    if (rules[method].kind != VW_PROBE_SAME_STATE) return score;
    score.value = statistics->all.count ? statistics->sum / (double)statistics->all.count : 0.0;
    score.standard_error = sqrt(vw_spread_variance(&statistics->state_means) / (double)statistics->state_means.count);
    score.resampling_stderr = sqrt(vw_mean_variance_result(&statistics->draws) / (double)statistics->all.count);
    return score;
}

static void append_scores(size_t method, const struct statistics *statistics, const struct vw_value_input *input,
                          struct vw_ledger_score *scores, uint32_t *score_count) {
    bool probed = false;
    for (uint32_t i = 0; i < input->image_count; i++) probed |= statistics[i].all.count > 0;
    for (uint32_t i = 0; probed && i < input->image_count; i++)
        if (strcmp(input->images[i].split, "train") == 0)
            scores[(*score_count)++] = score_of(method, input->images[i].image_id, &statistics[i]);
}

enum vw_status vw_probe_scores_append(const struct vw_value_input *input, struct vw_ledger_score *scores,
                                      uint32_t *score_count) {
    struct statistics *statistics = vw_allocate(input->image_count, sizeof *statistics);
    enum vw_status status = statistics ? VW_OK : VW_ERROR_MEMORY;
    for (size_t method = 0; !status && method < VW_ARRAY_COUNT(methods); method++) {
        memset(statistics, 0, input->image_count * sizeof *statistics);
        status = count_probes(method, input, statistics);
        if (!status) append_scores(method, statistics, input, scores, score_count);
    }
    free(statistics);
    return status;
}
