// Results of select --verify, as a table and as JSON.
#ifndef VIEWWORTH_CLI_OUTPUT_VERIFIED_SELECTION_OUTPUT_H
#define VIEWWORTH_CLI_OUTPUT_VERIFIED_SELECTION_OUTPUT_H

#include <jansson.h>

#include "experiment/verified_selection.h"

// Returns {candidates: [{name, photos, gain_db, ci_low, ci_high}], chosen}; NULL when memory is short.
json_t *vw_verified_selection_to_json(const struct vw_verified_selection *verified);
// Prints a table of the candidates, and a sentence that names the choice and its reason.
void vw_verified_selection_print(const struct vw_verified_selection *verified, uint32_t seeds);

#endif
