// Dependence of a run's scores on its validation views, as text and JSON.
#ifndef VIEWWORTH_CLI_OUTPUT_VALIDATION_VIEWS_OUTPUT_H
#define VIEWWORTH_CLI_OUTPUT_VALIDATION_VIEWS_OUTPUT_H

#include <jansson.h>
#include <stdbool.h>

#include "run/outputs/validation_views.h"

void vw_validation_views_print(const struct vw_validation_views *validation);
// Adds matrix and validation_views to `root`; false when memory is short.
bool vw_validation_views_add_json(const struct vw_validation_views *validation, json_t *root);

#endif
