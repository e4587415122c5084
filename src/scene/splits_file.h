// splits.json: who trains, validates and tests, so that a later run of a scene with more or fewer photos uses the same
// splits: {"train": [name, ...], "val": [...], "test": [...]}, "excluded" if there are such photos, and "weights"
// ({name: weight}) if validation photos have any but 1. Names are those of the scene.
#ifndef VIEWWORTH_SCENE_SPLITS_FILE_H
#define VIEWWORTH_SCENE_SPLITS_FILE_H

#include <stdint.h>

#include "viewworth/scene.h"
#include "viewworth/status.h"

// Reads such a file. `claims` has an entry per view, all 0 before: it becomes 1 + the split of a view that is named.
// A view that has a weight there gets it. `*absent_count` counts names of photos that the scene does not have (any
// more). VW_ERROR_INPUT names the line and column or the entry; also if a name is in two splits, or if no name is of
// this scene.
enum vw_status vw_splits_file_read(struct vw_scene *scene, const char *path, uint8_t *claims, uint32_t *absent_count);

// Makes the text of such a file for a scene, owned by the caller.
enum vw_status vw_splits_file_make(const struct vw_scene *scene, char **text);

#endif
