// Choices of a preset or a budget, as text and JSON.
#ifndef VIEWWORTH_CLI_OUTPUT_PLAN_OUTPUT_H
#define VIEWWORTH_CLI_OUTPUT_PLAN_OUTPUT_H

#include <jansson.h>
#include <stdbool.h>

#include "run/plan/plan.h"

// Prints the time that this command took, and the options that give the same bits. `config` is the run's.
void vw_plan_print(const struct vw_plan *plan, const struct vw_config *config);
// Adds the record with took_s and options as "budget" or "accuracy" to `root`; false when memory is short.
bool vw_plan_add_json(const struct vw_plan *plan, const struct vw_config *config, json_t *root);

#endif
