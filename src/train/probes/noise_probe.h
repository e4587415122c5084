// Probes of the measurement itself (`value --noise-floor`): from the state before a step, validate once more, take the
// step with learning rate 0, and take it with other pixels of the same photo, putting the state back each time, all on
// the device. The run itself is not touched: its steps have the same bits with and without.
#ifndef VIEWWORTH_TRAIN_NOISE_PROBE_H
#define VIEWWORTH_TRAIN_NOISE_PROBE_H

#include "gpu/compute.h"
#include "train/trainer.h"
#include "train/step.h"

struct vw_trainer;

enum {
    PROBE_RESAMPLES = 4,
    PROBES_PER_STEP = 2 + PROBE_RESAMPLES, // one repeat, one still step, the redraws: in this order
};

struct noise_probe {
    struct model zero_rate_model;      // the run's, with learning rate 0
    struct field zero_rate_field;      // the run's field seen through that model; owns nothing
    struct step_passes zero_rate_step; // has moments of its own
};

// The trainer's step passes, validation and kept state exist already.
enum vw_status noise_probe_create(struct vw_trainer *trainer, struct noise_probe **probe);
void noise_probe_destroy(struct noise_probe **probe);

// Every photo's steps are probed in one epoch of PROBE_EPOCHS, from burn-in on, the photos taking turns.
bool noise_probe_due(struct vw_trainer *trainer, uint64_t step);
enum vw_probe_kind noise_probe_kind(uint32_t index);

// Records all probes of a step. The pixels of draw d are those from first_pixel + d * rays on (draw 0: the step's own);
// the measurement of probe i goes to scalars[scalar_row + i * (1 + validation views)].
void noise_probe_record(const struct vw_trainer *trainer, struct vw_batch *batch, uint64_t step, uint32_t first_pixel,
                        uint32_t scalar_row);

#endif
