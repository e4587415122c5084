// The cost of the probes of --same-state in a run.
#ifndef VIEWWORTH_RUN_PROBE_COSTS_H
#define VIEWWORTH_RUN_PROBE_COSTS_H

#include <stdint.h>

#include "train/trainer.h"
#include "viewworth/train.h"
#include "viewworth/value.h"

struct vw_probe_costs {
    uint64_t states, same_state_steps; // in the whole run, however often it was resumed
    double same_state_s,
        same_state_share; // wall clock of this command's same-state steps, and that by the command's; NaN without any
};

// Counts the costs; `command_s` is how long the command has taken so far.
struct vw_probe_costs vw_probe_costs_count(const struct vw_value_input *input, const struct vw_trainer *trainer,
                                           double command_s);

#endif
