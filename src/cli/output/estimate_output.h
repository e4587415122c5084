// The estimate of a run as text and JSON.
#ifndef VIEWWORTH_CLI_OUTPUT_ESTIMATE_OUTPUT_H
#define VIEWWORTH_CLI_OUTPUT_ESTIMATE_OUTPUT_H

#include <jansson.h>

#include "run/plan/estimate.h"

void vw_estimate_print(const struct vw_estimate *estimate);
json_t *vw_estimate_to_json(const struct vw_estimate *estimate); // NULL when memory is short

#endif
