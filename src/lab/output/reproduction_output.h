// The result of `viewworth reproduce` on stdout, as tables or as one JSON object.
#ifndef VIEWWORTH_LAB_OUTPUT_REPRODUCTION_OUTPUT_H
#define VIEWWORTH_LAB_OUTPUT_REPRODUCTION_OUTPUT_H

#include <stdbool.h>

#include "lab/reproduction.h"
#include "viewworth/status.h"

// Prints the reproduction. Returns VW_ERROR_MEMORY, or VW_ERROR_IO when the JSON cannot be written to stdout.
enum vw_status vw_reproduction_print(const struct vw_reproduction *reproduction, bool json);

#endif
