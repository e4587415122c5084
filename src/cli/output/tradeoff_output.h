// The result of `viewworth tradeoff` on stdout, as tables or as one JSON object.
#ifndef VIEWWORTH_CLI_OUTPUT_TRADEOFF_OUTPUT_H
#define VIEWWORTH_CLI_OUTPUT_TRADEOFF_OUTPUT_H

#include <stdbool.h>

#include "experiment/sweep/sweep.h"
#include "viewworth/status.h"

// Prints the trade-off. Returns VW_ERROR_MEMORY, or VW_ERROR_IO when the JSON cannot be written to stdout.
enum vw_status vw_sweep_print(const struct vw_sweep *sweep, bool json);

#endif
