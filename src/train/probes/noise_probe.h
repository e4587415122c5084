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

struct noise_probe {
    struct model zero_rate_model;      // the run's, with learning rate 0
    struct field zero_rate_field;      // the run's field seen through that model; owns nothing
    struct step_passes zero_rate_step; // has moments of its own
};

enum vw_status noise_probe_create(const struct probe_context *context, struct noise_probe **probe);
void noise_probe_destroy(struct noise_probe **probe);

// With --noise-floor, every photo's steps are probed in one epoch of PROBE_EPOCHS, from burn-in on; the photos
// alternate.
bool noise_probe_due(const struct probe_context *context, uint64_t step);

// Records all probes of a step. The pixels of draw d are those from first_pixel + d * rays on (draw 0: the step's own);
// the measurement of probe i goes to scalars[scalar_row + i * rows per measurement].
void noise_probe_record(const struct noise_probe *probe, const struct probe_context *context, struct vw_batch *batch,
                        uint64_t step, uint32_t first_pixel, uint32_t scalar_row);

// Reads these measurements into PROBES_PER_STEP probes.
void noise_probe_read(const struct probe_context *context, const vw_float4 *rows, uint64_t step,
                      struct vw_probe *probes);

#endif
