// Stability of a run's scores, as text and JSON.
#ifndef VIEWWORTH_CLI_OUTPUT_STABILITY_OUTPUT_H
#define VIEWWORTH_CLI_OUTPUT_STABILITY_OUTPUT_H

#include <jansson.h>

#include "value/stability.h"
#include "viewworth/train.h"

// Prints a line for people; `wanted` is the value of --until-stable, `config` the run's.
void vw_stability_print(const struct vw_stability *stability, double wanted, const struct vw_config *config);
json_t *vw_stability_to_json(const struct vw_stability *stability, double wanted); // NULL when memory is short

#endif
