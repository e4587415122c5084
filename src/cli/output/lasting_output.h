// Lasting credit, as text and JSON.
#ifndef VIEWWORTH_CLI_OUTPUT_LASTING_OUTPUT_H
#define VIEWWORTH_CLI_OUTPUT_LASTING_OUTPUT_H

#include <jansson.h>

#include "run/lasting/lasting_summary.h"

// Prints the photos at both ends, the gate, and the growth of the gradient.
void vw_lasting_print(const struct vw_lasting_summary *summary);
json_t *vw_lasting_to_json(const struct vw_lasting_summary *summary);

#endif
