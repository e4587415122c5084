#include "lab/probes/probe_scores.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/statistics.h"

// ---- The probes of a step -------------------------------------------------------------------------------------------

// The mean of the variances of several steps, without those that are NaN.
struct mean_variance {
    double sum;
    uint32_t count;
};

static void add_variance(struct mean_variance *mean, double variance) {
    if (isnan(variance)) return;
    mean->sum += variance;
    mean->count++;
}

static double result_of(const struct mean_variance *mean) { return mean->count ? mean->sum / mean->count : NAN; }

// Counts the probes, from `first` on, of the step of the first one.
static uint32_t count_alike(const struct vw_probed_run *run, uint32_t first) {
    uint32_t end = first;
    while (end < run->probe_count && run->probes[end].step == run->probes[first].step) end++;
    return end - first;
}

// The variances of a step's delta that pixel sampling alone causes: those of the measures over the resampled steps and
// the step itself, which all start from the same state. NaN below two values.
struct sampling {
    double psnr, l1;
};

static struct sampling sampling_of(const struct vw_probed_run *run, uint32_t first, uint32_t count) {
    const struct vw_step_record *own = &run->records[run->probes[first].step];
    struct vw_spread psnr = {0}, l1 = {0};
    if (isfinite(own->val_psnr)) vw_spread_add(&psnr, own->val_psnr);
    if (isfinite(own->val_l1)) vw_spread_add(&l1, own->val_l1);
    for (uint32_t i = first; i < first + count; i++) {
        const struct vw_probe *probe = &run->probes[i];
        if (probe->kind != VW_PROBE_RESAMPLED) continue;
        if (isfinite(probe->val_psnr)) vw_spread_add(&psnr, probe->val_psnr);
        if (isfinite(probe->val_l1)) vw_spread_add(&l1, probe->val_l1);
    }
    return (struct sampling){vw_spread_variance(&psnr), vw_spread_variance(&l1)};
}

// ---- Noise ----------------------------------------------------------------------------------------------------------

// Counts the probe and updates the largest delta of its kind.
static void add_noise(const struct vw_probed_run *run, const struct vw_probe *probe, struct vw_noise_floor *floor) {
    if (probe->kind >= VW_PROBE_SAME_STATE) return;
    if (probe->kind == VW_PROBE_RESAMPLED) {
        floor->resampled_count += isfinite(probe->val_psnr);
        return;
    }
    double delta = fabs(probe->val_psnr - run->records[probe->step - 1].val_psnr);
    bool repeats = probe->kind == VW_PROBE_REPEATED;
    uint32_t *count = repeats ? &floor->repeated_count : &floor->zero_learning_rate_count;
    double *largest = repeats ? &floor->repeated_db : &floor->zero_learning_rate_db;
    if (!isfinite(delta)) return;
    if (!*count || delta > *largest) *largest = delta;
    ++*count;
}

void vw_noise_floor_find(const struct vw_probed_run *run, struct vw_noise_floor *floor) {
    *floor = (struct vw_noise_floor){.repeated_db = NAN, .zero_learning_rate_db = NAN};
    struct mean_variance psnr = {0}, l1 = {0};
    for (uint32_t first = 0, count = 0; first < run->probe_count; first += count) {
        count = count_alike(run, first);
        const struct sampling sampling = sampling_of(run, first, count);
        for (uint32_t i = first; i < first + count; i++) add_noise(run, &run->probes[i], floor);
        add_variance(&psnr, sampling.psnr);
        add_variance(&l1, sampling.l1);
    }
    floor->resampled_db = sqrt(result_of(&psnr));
    floor->resampled_l1 = sqrt(result_of(&l1));
}

// ---- Scores ---------------------------------------------------------------------------------------------------------

// The statistics of one photo. Plain sums are used for the score itself, so that one SQL query gives the same value.
struct statistics {
    double sum;
    uint32_t draw_count;
    struct vw_spread state;        // contributions of the current state
    struct vw_spread state_means;  // means of the earlier states
    struct mean_variance draws;    // variances within the earlier states
    struct mean_variance psnr, l1; // sampling variances of the photo's own steps
};

static void close_state(struct statistics *statistics) {
    if (!statistics->state.count) return;
    vw_spread_add(&statistics->state_means, statistics->state.mean);
    add_variance(&statistics->draws, vw_spread_variance(&statistics->state));
    statistics->state = (struct vw_spread){0};
}

static void add_draw(struct statistics *statistics, double contribution) {
    if (!isfinite(contribution)) return;
    statistics->sum += contribution;
    statistics->draw_count++;
    vw_spread_add(&statistics->state, contribution);
}

static void add_step(const struct vw_probed_run *run, uint32_t first, uint32_t count, struct statistics *statistics) {
    const struct vw_step_record *record = &run->records[run->probes[first].step];
    const struct sampling sampling = sampling_of(run, first, count);
    for (uint32_t i = first; i < first + count; i++)
        if (run->probes[i].kind == VW_PROBE_SAME_STATE)
            add_draw(&statistics[run->probes[i].view], run->probes[i].val_psnr - record->val_psnr);
    for (uint32_t i = 0; i < run->image_count; i++) close_state(&statistics[i]);
    if (!record->step) return; // the untrained field
    add_variance(&statistics[record->view].psnr, sampling.psnr);
    add_variance(&statistics[record->view].l1, sampling.l1);
}

// Computes a score. A photo without contributions has score 0, like one that was never visited.
static struct vw_probe_score same_state_of(uint32_t image_id, const struct statistics *statistics) {
    double count = statistics->draw_count, states = (double)statistics->state_means.count;
    return (struct vw_probe_score){
        .image_id = image_id,
        .method = "same_state_psnr",
        .unit = "dB",
        .value = statistics->draw_count ? statistics->sum / count : 0.0,
        .visits = statistics->draw_count,
        .standard_error = sqrt(vw_spread_variance(&statistics->state_means) / states),
        .resampling_stderr = sqrt(result_of(&statistics->draws) / count),
    };
}

static void list(const struct vw_probed_run *run, const struct statistics *statistics, struct vw_probe_score *scores,
                 uint32_t *count) {
    bool probed = false;
    for (uint32_t i = 0; i < run->image_count; i++) probed |= statistics[i].draw_count > 0;
    for (uint32_t i = 0; probed && i < run->image_count; i++)
        if (strcmp(run->images[i].split, "train") == 0) scores[(*count)++] = same_state_of(i, &statistics[i]);
    for (uint32_t i = 0; i < run->score_count; i++) {
        const struct vw_ledger_score *own = &run->scores[i];
        bool psnr = strcmp(own->method, "dv_psnr") == 0;
        if (!psnr && strcmp(own->method, "dv_loss") != 0) continue;
        const struct statistics *photo = &statistics[own->image_id];
        scores[(*count)++] = (struct vw_probe_score){
            .image_id = own->image_id,
            .method = own->method,
            .unit = own->unit,
            .value = own->value,
            .visits = own->visits,
            .standard_error = own->standard_error,
            .resampling_stderr = sqrt(own->visits * result_of(psnr ? &photo->psnr : &photo->l1)),
        };
    }
}

enum vw_status vw_probe_scores_make(const struct vw_probed_run *run, struct vw_probe_score **scores, uint32_t *count) {
    struct statistics *statistics = vw_allocate(run->image_count, sizeof *statistics);
    struct vw_probe_score *made = vw_allocate((size_t)run->image_count + run->score_count, sizeof *made);
    enum vw_status status = statistics && made ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t first = 0, alike = 0; !status && first < run->probe_count; first += alike) {
        alike = count_alike(run, first);
        add_step(run, first, alike, statistics);
    }
    *count = 0;
    if (!status) list(run, statistics, made, count);
    free(statistics);
    if (status) free(made);
    else *scores = made;
    return status;
}
