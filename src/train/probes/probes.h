// All probes of a run, as the trainer sees them: what each adds to a step's pixels, to its passes, to its rows in the
// scalars, and to its record. A step's rows are its own measurement, then those of the noise floor.
#ifndef VIEWWORTH_TRAIN_PROBES_PROBES_H
#define VIEWWORTH_TRAIN_PROBES_PROBES_H

#include "train/probes/noise_probe.h"
#include "train/probes/probe_context.h"
#include "train/probes/same_state.h"

struct vw_probes {
    struct vw_probe_context context;
    struct vw_snapshot snapshot;            // empty unless a probe needs it
    struct vw_noise_probe *noise;           // NULL without --noise-floor
    struct vw_same_state_probes same_state; // empty without --same-state
};

// Returns VW_ERROR_USAGE and names the option when a probe is asked for without validation.
enum vw_status vw_probes_check(const struct vw_config *config, bool validates);

// Returns the most that one step has: draws of its rays' pixels. The second counts measurements, the third probes in
// its record (those of --same-state come on top).
uint32_t vw_probes_draws_per_step(const struct vw_config *config);
uint32_t vw_probes_measurements_per_step(const struct vw_config *config);
uint32_t vw_probes_per_step(const struct vw_config *config);

// Creates the probes. `context` comes without its snapshot, which is made here. What it refers to exists already.
enum vw_status vw_probes_create(const struct vw_probe_context *context, struct vw_probes *probes);
void vw_probes_destroy(struct vw_probes *probes);

// Returns how many draws of pixels a step takes: draw 0 is its own.
uint32_t vw_probes_draws_of_step(const struct vw_probes *probes, uint64_t step);
// Records the probes before the step. The pixels of draw d are those from first_pixel + d * rays on; `scalar_row` is
// the step's own.
void vw_probes_record_before(const struct vw_probes *probes, struct vw_submission *batch, uint64_t step,
                             uint32_t first_pixel, uint32_t scalar_row);
// Reads the probes of the record's step, whose rows these are, into `values`, and lends them to the record.
void vw_probes_read(const struct vw_probes *probes, const vw_float4 *rows, struct vw_probe *values,
                    struct vw_step_record *record);

// Returns whether the state after a step is to be probed and was not yet. The second probes it, see
// vw_same_state_take().
bool vw_probes_state_due(const struct vw_probes *probes, uint64_t step);
enum vw_status vw_probes_take_state(struct vw_probes *probes, struct vw_submission *batch,
                                    struct vw_step_record *record);
// Resumes after `step`, whose record, with the probes of its state, was handed out before.
void vw_probes_resume_after(struct vw_probes *probes, uint64_t step);

#endif
