// The work of `tradeoff`, for programs that also evaluate the scores.
#ifndef VIEWWORTH_CLI_COMMANDS_TRADEOFF_H
#define VIEWWORTH_CLI_COMMANDS_TRADEOFF_H

#include "cli/options.h"
#include "experiment/sweep/sweep.h"

// Measures the trade-off and prints it. `evaluator` says how good the scores are; NULL: nobody does.
enum vw_status vw_tradeoff_make(const struct vw_options *options, const struct vw_sweep_evaluator *evaluator);

#endif
