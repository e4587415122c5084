// A recorded run whose steps are repeated, for what follows its training: the backward pass of lasting credit, and
// scores from gradients.
#ifndef VIEWWORTH_RUN_RECORDED_REPLAYED_RUN_H
#define VIEWWORTH_RUN_RECORDED_REPLAYED_RUN_H

#include "run/recorded/recorded_run.h"
#include "viewworth/types.h"

// Refuses a run whose steps cannot be repeated, or tell nothing: imported, not finished, without validation, with
// tables of halves, not of whole epochs. Its config gets as many epochs as it has. VW_ERROR_USAGE.
enum vw_status vw_recorded_check_replay(struct vw_recorded_run *run);

// Creates a trainer of the run, which takes its steps again, and compares their identities. Needs an open scene, whose
// images were checked. VW_ERROR_USAGE names what differs. Destroy the trainer also after a failure.
enum vw_status vw_recorded_create_trainer(const struct vw_recorded_run *run, bool validated,
                                          struct vw_trainer **trainer);
struct vw_recorded_steps { // borrowed
    const char *ledger_path;
    const struct vw_step_record *records; // step 0, 1, ...
    uint64_t record_count;
};
// Compares a replayed step; a vw_step_replayed whose `context` is a struct vw_recorded_steps. Returns VW_ERROR_MISMATCH
// when the step differs from the recorded one.
enum vw_status vw_recorded_steps_compare(void *context, const struct vw_step_record *replayed);

#endif
