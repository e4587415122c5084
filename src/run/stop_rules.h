// Runs that are held at ends of epochs, where it is seen whether they go on: by --until-stable (cli/until_stable.h) at
// every end, by
// --budget (cli/plan.h) at fewer, which come closer as the time runs out, or by both. Where a run is held changes no
// bit of its steps.
#ifndef VIEWWORTH_EPOCH_ENDS_H
#define VIEWWORTH_EPOCH_ENDS_H

#include "run/training_run.h"

// Holds the trainer at the end of the epoch that is recorded last, or of the first.
enum vw_status vw_stop_rules_begin(struct vw_training_run *run);
// At the end of an epoch: tells whether the run goes on, up to where the trainer is then held. False where all steps
// are taken, and where nothing holds the run. With --budget the run's config, and the ledger's, have as many epochs as
// the run is held at.
enum vw_status vw_stop_rules_pass(struct vw_training_run *run, bool *goes_on);
// Steps that the run will have at its end, as far as can be told.
uint64_t vw_stop_rules_expected_steps(const struct vw_training_run *run);

#endif
