// The splits: views that train, validate and test. Weights of validation photos in the means of validation: of a CSV
// file with the header name,weight (--val-weights), or of a splits.json.
#ifndef VIEWWORTH_SCENE_SPLITS_FILE_H
#define VIEWWORTH_SCENE_SPLITS_FILE_H

#include <jansson.h>
#include <stdbool.h>
#include <stdint.h>

#include "viewworth/scene.h"
#include "viewworth/status.h"

// Returns whether a validation photo has another weight than 1.
bool vw_scene_has_weights(const struct vw_scene *scene);
// Adds the key "weights" to an object, with the names of such photos and their weights; nothing without such photos.
// Sets the object to NULL when memory is short, as vw_json_set() does.
void vw_scene_add_weights(const struct vw_scene *scene, json_t **object);

// ---- splits.json ---------------------------------------------------------------------------------------------------

// Such a file says who trains, validates and tests, so that a later run of a scene with more or fewer photos uses the
// same splits: {"train": [name, ...], "val": [...], "test": [...]}, "excluded" if there are such photos, and "weights"
// ({name: weight}) if validation photos have any but 1. Names are those of the scene.

// Reads such a file. `claims` has an entry per view, all 0 before: it becomes 1 + the split of a view that is named.
// A view that has a weight there gets it. `*absent_count` counts names of photos that the scene does not have (any
// more). VW_ERROR_INPUT names the line and column or the entry; also if a name is in two splits, or if no name is of
// this scene.
enum vw_status vw_splits_file_read(struct vw_scene *scene, const char *path, uint8_t *claims, uint32_t *absent_count);

// Makes the text of such a file for a scene, owned by the caller.
enum vw_status vw_splits_file_make(const struct vw_scene *scene, char **text);

#endif
