// `value --until-stable R`: a run is held at the end of every epoch (cli/epoch_ends.h), and ends there once its scores
// are stable (viewworth/stability.h). The decision looks at the recorded steps alone, so that a run that was killed and
// went on ends where it would have ended. It is no part of what the run is: --resume with a higher R, or without, goes
// on with it.
#ifndef VIEWWORTH_UNTIL_STABLE_H
#define VIEWWORTH_UNTIL_STABLE_H

#include "run/training_run.h"

// The scores that are watched are those of the method that is shown.
enum vw_status vw_until_stable_check_option(
    const struct vw_options *options); // VW_ERROR_USAGE unless R is 0 or in (0,1)
// Measures run->stability from the ledger. False without --until-stable.
enum vw_status vw_until_stable_measure(struct vw_training_run *run, bool *stable);
void vw_until_stable_print(const struct vw_training_run *run);      // a line for people; none without --until-stable
json_t *vw_until_stable_to_json(const struct vw_training_run *run); // NULL without --until-stable

#endif
