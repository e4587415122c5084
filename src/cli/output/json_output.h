// Results as JSON on stdout.
#ifndef VIEWWORTH_CLI_OUTPUT_JSON_OUTPUT_H
#define VIEWWORTH_CLI_OUTPUT_JSON_OUTPUT_H

#include <jansson.h>

#include "base/json.h"
#include "viewworth/status.h"

// Prints `root` and a line end, and drops the reference. NULL, what jansson gives when memory is short, is
// VW_ERROR_MEMORY.
enum vw_status vw_json_print(json_t *root);

#endif
