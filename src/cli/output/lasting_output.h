// What lasting credit says, as text and JSON.
#ifndef VIEWWORTH_CLI_OUTPUT_LASTING_OUTPUT_H
#define VIEWWORTH_CLI_OUTPUT_LASTING_OUTPUT_H

#include <jansson.h>

#include "run/lasting/lasting_summary.h"

// The photos at both ends, the gate, and how far the gradient grew.
void vw_lasting_print(const struct vw_lasting_summary *summary);
json_t *vw_lasting_to_json(const struct vw_lasting_summary *summary);

#endif
