// Text files of names, one a line.
#ifndef VIEWWORTH_SCENE_NAME_LIST_H
#define VIEWWORTH_SCENE_NAME_LIST_H

#include <stdint.h>

#include "viewworth/status.h"

// Called with every name, without the spaces around it, and its line from 1; blank lines are passed over. The name is
// lent.
typedef enum vw_status vw_name_taker(void *context, int line, const char *name);
// `*count` is how many there were. Stops where `take` fails. VW_ERROR_INPUT when the file cannot be read.
enum vw_status vw_names_read(const char *path, vw_name_taker *take, void *context, uint32_t *count);

#endif
