// Providers, payout and near-duplicates of a run, as text and JSON.
#ifndef VIEWWORTH_CLI_OUTPUT_ATTRIBUTION_OUTPUT_H
#define VIEWWORTH_CLI_OUTPUT_ATTRIBUTION_OUTPUT_H

#include <jansson.h>
#include <stdbool.h>

#include "run/outputs/attribution.h"

void vw_attribution_print(const struct vw_attribution *attribution);
// Adds providers, payout and duplicates to `root`; false when memory is short.
bool vw_attribution_add_json(const struct vw_attribution *attribution, json_t *root);

#endif
