// map.json: where a run's cameras and its scene's points are, and why photos need a look, so that a
// report can show them without the scene.
#ifndef VIEWWORTH_RUN_OUTPUTS_SCENE_MAP_H
#define VIEWWORTH_RUN_OUTPUTS_SCENE_MAP_H

#include <jansson.h>
#include <stdint.h>

#include "run/out_files.h"
#include "run/outputs/checksums.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"

enum { VW_SCENE_MAP_POINTS_MAX = 2000 };

// Writes OUT/map.json: {"scene_hash": hex, "up": [x, y, z], "positions": [x, y, z, ...], "directions": [...],
// "points": [...], "reasons": [word or null, ...]}. World coordinates; a position and a unit direction of view per
// image, in the order of the scene's views; `up` is the unit mean of the cameras' up axes; of more points than
// VW_SCENE_MAP_POINTS_MAX an evenly spread part is taken; `reasons` has a word of report/told.h per image, NULL: none.
// Notes the file in `made`. VW_ERROR_IO, VW_ERROR_MEMORY.
enum vw_status vw_scene_map_write(const struct vw_scene *scene, const char *const *reasons, const char *out,
                                  struct vw_checksums *made);

// Checks that a map is one of `image_count` images of the scene with this hash. VW_ERROR_INPUT names the file and what
// is wrong; `path` is for messages.
enum vw_status vw_scene_map_check(const char *path, json_t *map, const char *scene_hash, uint32_t image_count);

#endif
