// What --same-state and --first-order cost a run, for the output of `value`.
#ifndef VIEWWORTH_PROBE_COSTS_H
#define VIEWWORTH_PROBE_COSTS_H

#include <jansson.h>

#include "viewworth/train.h"
#include "train/trainer.h"
#include "viewworth/value.h"

struct vw_probe_costs {
    uint64_t states, same_state_steps; // of the whole run, however often it was resumed
    uint64_t first_order_steps;        // likewise; each was validated twice more
    double same_state_s,
        same_state_share; // wall clock of this command's same-state steps, and that by the command's; NaN without any
};

// `command_s`: how long the command has taken so far.
struct vw_probe_costs vw_probe_costs_count(const struct vw_value_input *input, const struct vw_trainer *trainer,
                                           double command_s);
// Nothing of what there are no probes of.
void vw_probe_costs_print(const struct vw_probe_costs *costs);
// Owned by the caller, or NULL where there are no probes of that kind.
json_t *vw_probe_costs_same_state_to_json(const struct vw_probe_costs *costs);
json_t *vw_probe_costs_first_order_to_json(const struct vw_probe_costs *costs);

#endif
