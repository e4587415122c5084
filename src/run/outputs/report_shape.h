// Checks that a folder's files have what the page's script relies on; people may have edited them.
#ifndef VIEWWORTH_RUN_OUTPUTS_REPORT_SHAPE_H
#define VIEWWORTH_RUN_OUTPUTS_REPORT_SHAPE_H

#include <jansson.h>

#include "viewworth/status.h"

// Checks that a table has these columns (NULL ends them). VW_ERROR_INPUT names the file and the missing one; `path` is
// for messages. Further columns are allowed.
enum vw_status vw_report_shape_of_table(const char *path, const char *const *columns, const json_t *header);
enum vw_status vw_report_shape_of_comparison(const char *path, json_t *compare);

#endif
