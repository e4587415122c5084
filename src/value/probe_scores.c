#include "value/probe_scores.h"

#include <inttypes.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "ledger/find_image.h"
#include "value/measure.h"

// The statistics of one image. Plain sums are used for the score itself, so that one SQL query gives the same value.
struct statistics {
    double sum;
    uint64_t draw_count;
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
    statistics->draw_count++;
    vw_spread_add(&statistics->state, contribution);
}

static enum vw_status add_probe(const struct vw_value_input *input, const struct vw_step_record *record,
                                const struct vw_probe *probe, struct statistics *statistics) {
    const struct vw_ledger_image *image = vw_ledger_find_image(input->images, input->image_count, probe->view);
    if (!image)
        return vw_fail(
            VW_ERROR_INPUT,
            "step %" PRIu64
            ": probe %u is of image %u, which is not in the image table; check the ledger with viewworth verify",
            record->step, probe->index, probe->view);
    add(&statistics[image - input->images], record->step, probe->val_psnr - record->val_psnr);
    return VW_OK;
}

static enum vw_status count_probes(const struct vw_value_input *input, struct statistics *statistics) {
    enum vw_status status = VW_OK;
    uint64_t taken = 0;
    for (uint64_t i = 0; i < input->record_count; i++) {
        const struct vw_step_record *record = &input->records[i];
        struct vw_step_probes probes = vw_step_probes_take(input, record->step, &taken);
        for (uint64_t p = 0; p < probes.count && record->epoch >= input->burn_in_epochs && !status; p++)
            if (probes.probes[p].kind == VW_PROBE_SAME_STATE)
                status = add_probe(input, record, &probes.probes[p], statistics);
    }
    for (uint32_t i = 0; i < input->image_count; i++) close_state(&statistics[i]);
    return status;
}

// Computes a score. A photo without contributions has score 0, like one that was never visited.
static struct vw_ledger_score score_of(uint32_t image_id, const struct statistics *statistics) {
    double count = (double)statistics->draw_count, states = (double)statistics->state_means.count;
    return (struct vw_ledger_score){
        .image_id = image_id,
        .method = "same_state_psnr",
        .unit = "dB",
        .value = statistics->draw_count ? statistics->sum / count : 0.0,
        .visits = (uint32_t)statistics->draw_count,
        .standard_error = sqrt(vw_spread_variance(&statistics->state_means) / states),
        .resampling_stderr = sqrt(vw_mean_variance_result(&statistics->draws) / count),
        .ci_low = NAN, // too few states for an interval
        .ci_high = NAN,
    };
}

enum vw_status vw_probe_scores_append(const struct vw_value_input *input, struct vw_ledger_score *scores,
                                      uint32_t *score_count) {
    struct statistics *statistics = vw_allocate(input->image_count, sizeof *statistics);
    enum vw_status status = statistics ? count_probes(input, statistics) : VW_ERROR_MEMORY;
    bool probed = false;
    for (uint32_t i = 0; !status && i < input->image_count; i++) probed |= statistics[i].draw_count > 0;
    for (uint32_t i = 0; probed && i < input->image_count; i++)
        if (strcmp(input->images[i].split, "train") == 0)
            scores[(*score_count)++] = score_of(input->images[i].image_id, &statistics[i]);
    free(statistics);
    return status;
}
