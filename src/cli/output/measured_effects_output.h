// What `info --measure` found, as a table and as JSON.
#ifndef VIEWWORTH_CLI_MEASURED_EFFECTS_OUTPUT_H
#define VIEWWORTH_CLI_MEASURED_EFFECTS_OUTPUT_H

#include <jansson.h>

#include "experiment/measure_effects.h"

void vw_measured_effects_print(const struct vw_measured_effects *measured); // nothing when not measured
// [{effect, ms_per_step_on, ms_per_step_off, params, bytes, psnr_gained_db}]; NULL when memory is short.
json_t *vw_measured_effects_to_json(const struct vw_measured_effects *measured);

#endif
