// Weights of validation photos in the means of validation: of a CSV file with the header name,weight (--val-weights),
// or of a splits.json.
#ifndef VIEWWORTH_SCENE_VAL_WEIGHTS_H
#define VIEWWORTH_SCENE_VAL_WEIGHTS_H

#include <jansson.h>
#include <stdbool.h>

#include "viewworth/scene.h"

// Returns whether a validation photo has another weight than 1.
bool vw_scene_has_weights(const struct vw_scene *scene);
// Adds the key "weights" to an object, with the names of such photos and their weights; nothing without such photos.
// Sets the object to NULL when memory is short, as vw_json_set() does.
void vw_scene_add_weights(const struct vw_scene *scene, json_t **object);

#endif
