// Text files with one name per line.
#ifndef VIEWWORTH_SCENE_FORMATS_NAME_LIST_H
#define VIEWWORTH_SCENE_FORMATS_NAME_LIST_H

#include <stdint.h>

#include "viewworth/status.h"

// Called with every name, without surrounding spaces, and its line number from 1. The name is borrowed. Blank lines are
// skipped.
typedef enum vw_status vw_name_taker(void *context, int line, const char *name);
// Reads the names; `*count` is their number. Stops at the first failure of `take`. VW_ERROR_INPUT if the file cannot be
// read.
enum vw_status vw_names_read(const char *path, vw_name_taker *take, void *context, uint32_t *count);

#endif
