// What probes cost a run, as text and JSON.
#ifndef VIEWWORTH_CLI_PROBE_COSTS_OUTPUT_H
#define VIEWWORTH_CLI_PROBE_COSTS_OUTPUT_H

#include <jansson.h>

#include "run/probe_costs.h"

// Prints nothing of a kind without probes.
void vw_probe_costs_print(const struct vw_probe_costs *costs);
// Owned by the caller, or NULL where there are no probes of that kind.
json_t *vw_probe_costs_same_state_to_json(const struct vw_probe_costs *costs);
json_t *vw_probe_costs_first_order_to_json(const struct vw_probe_costs *costs);

#endif
