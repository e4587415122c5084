#include <math.h>

#include "value/measure.h"

// Counts the probe and updates the largest delta of its kind.
static void add_probe(const struct vw_probe *probe, double before, struct vw_noise_floor *floor) {
    double delta = fabs(probe->val_psnr - before);
    if (probe->kind > VW_PROBE_RESAMPLED) return; // not a probe of noise
    if (probe->kind == VW_PROBE_RESAMPLED) {
        if (isfinite(probe->val_psnr)) floor->resampled_count++;
    } else if (isfinite(delta)) {
        bool repeats = probe->kind == VW_PROBE_REPEATED;
        uint64_t *count = repeats ? &floor->repeated_count : &floor->zero_learning_rate_count;
        double *largest = repeats ? &floor->repeated_db : &floor->zero_learning_rate_db;
        if (!*count || delta > *largest) *largest = delta;
        ++*count;
    }
}

void vw_value_noise_floor(const struct vw_value_input *input, struct vw_noise_floor *floor) {
    *floor = (struct vw_noise_floor){.repeated_db = NAN, .zero_learning_rate_db = NAN};
    struct vw_mean_variance psnr = {0}, l1 = {0};
    double before = NAN;
    uint64_t taken = 0;
    for (uint64_t i = 0; i < input->record_count; i++) {
        const struct vw_step_record *record = &input->records[i];
        struct vw_step_probes probes = vw_step_probes_take(input, record->step, &taken);
        for (uint64_t p = 0; p < probes.count; p++) add_probe(&probes.probes[p], before, floor);
        vw_mean_variance_add(&psnr, vw_step_sampling_variance(&vw_measure_psnr, record, probes));
        vw_mean_variance_add(&l1, vw_step_sampling_variance(&vw_measure_l1, record, probes));
        before = record->val_psnr; // not finite after a flagged step, which may still have changed some params
    }
    floor->resampled_db = sqrt(vw_mean_variance_result(&psnr));
    floor->resampled_l1 = sqrt(vw_mean_variance_result(&l1));
}
