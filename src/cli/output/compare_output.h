// The result of `viewworth compare` on stdout, as tables or as one JSON object.
#ifndef VIEWWORTH_CLI_OUTPUT_COMPARE_OUTPUT_H
#define VIEWWORTH_CLI_OUTPUT_COMPARE_OUTPUT_H

#include <stdbool.h>

#include "experiment/comparison_data.h"
#include "experiment/comparison_files.h"
#include "viewworth/status.h"

// Prints the comparison. Returns VW_ERROR_MEMORY, or VW_ERROR_IO when the JSON cannot be written to stdout.
enum vw_status vw_comparison_print(const struct vw_comparison *comparison, bool json);

#endif
