// A run's profile as text and JSON.
#ifndef VIEWWORTH_CLI_OUTPUT_PROFILE_OUTPUT_H
#define VIEWWORTH_CLI_OUTPUT_PROFILE_OUTPUT_H

#include <jansson.h>

#include "run/profile.h"

void vw_profile_print(const struct vw_profile *profile);
json_t *vw_profile_to_json(const struct vw_profile *profile); // NULL when memory is short

#endif
