// Costs of a run's probes, as text and JSON.
#ifndef VIEWWORTH_CLI_OUTPUT_PROBE_COSTS_OUTPUT_H
#define VIEWWORTH_CLI_OUTPUT_PROBE_COSTS_OUTPUT_H

#include <jansson.h>

#include "run/probe_costs.h"

// Prints nothing without probes.
void vw_probe_costs_print(const struct vw_probe_costs *costs);
// Returns JSON that the caller owns, or NULL without probes.
json_t *vw_probe_costs_same_state_to_json(const struct vw_probe_costs *costs);

#endif
