// Probes of the measurement itself (`value --noise-floor`): from the state before a step, validate once more, take the
// step with learning rate 0, and take it with other pixels of the same photo. The state is restored each time, all on
// the device. The run's own steps have the same bits with and without.
#ifndef VIEWWORTH_TRAIN_PROBES_NOISE_PROBE_H
#define VIEWWORTH_TRAIN_PROBES_NOISE_PROBE_H

#include "train/probes/probe_context.h"

enum {
    PROBE_RESAMPLES = 4,
    PROBES_PER_STEP = 2 + PROBE_RESAMPLES, // repeated, zero learning rate, resampled: in this order
};

struct vw_noise_probe {
    struct vw_model zero_rate_model;          // the run's, with learning rate 0
    struct vw_radiance_field zero_rate_field; // the run's field seen through that model; owns nothing
    struct vw_step_passes zero_rate_step;     // has moments of its own
};

enum vw_status vw_noise_probe_create(const struct vw_probe_context *context, struct vw_noise_probe **probe);
void vw_noise_probe_destroy(struct vw_noise_probe **probe);

// Returns whether a step is probed. With --noise-floor, every photo's steps are probed in one epoch of PROBE_EPOCHS,
// from burn-in on; the photos alternate.
bool vw_noise_probe_due(const struct vw_probe_context *context, uint64_t step);

// Records all probes of a step. The pixels of draw d are those from first_pixel + d * rays on (draw 0: the step's own);
// the measurement of probe i goes to scalars[scalar_row + i * rows per measurement].
void vw_noise_probe_record(const struct vw_noise_probe *probe, const struct vw_probe_context *context,
                           struct vw_submission *batch, uint64_t step, uint32_t first_pixel, uint32_t scalar_row);

// Reads these measurements into PROBES_PER_STEP probes.
void vw_noise_probe_read(const struct vw_probe_context *context, const vw_float4 *rows, uint64_t step,
                         struct vw_probe *probes);

#endif
