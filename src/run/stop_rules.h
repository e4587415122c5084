// Rules that stop a run early. They look at ends of epochs, which changes no bit of its steps. With until_stable they
// look at every end, and stop once the scores of vw_value_default_method are stable (value/stability.h). With a budget
// they look at fewer ends, which come closer as the time runs out. Both rules may apply.
//
// Stability depends on the recorded steps alone, so that a run that was killed and resumed ends where it would have
// ended. It does not identify a run: a run may be resumed with a higher value, or without.
#ifndef VIEWWORTH_RUN_STOP_RULES_H
#define VIEWWORTH_RUN_STOP_RULES_H

#include <stdbool.h>
#include <stdint.h>

#include "run/run_private.h"

// Returns VW_ERROR_USAGE unless the rank correlation is 0 (never stop) or lies between 0 and 1.
enum vw_status vw_stop_rules_check(double until_stable);
// Sets run->stop_step to the end of the epoch that is recorded last, or of the first.
enum vw_status vw_stop_rules_begin(struct vw_run *run);
// Tells at run->stop_step whether the run continues, and sets the next stop_step. Tells false when all steps are taken.
// With a budget the run's config, and the ledger's, get the epochs up to the next stop.
enum vw_status vw_stop_rules_pass(struct vw_run *run, bool *continues);
// Measures run->stability of the steps so far. False without until_stable.
enum vw_status vw_stop_rules_measure_stability(struct vw_run *run, bool *stable);
// Returns the number of steps that the run is expected to have at its end.
uint64_t vw_stop_rules_expected_steps(const struct vw_run *run);

#endif
