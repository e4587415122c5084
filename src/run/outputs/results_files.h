// The JSON files of OUT that have what scene and field told at the end of a run, so that a report can show it without
// them: map.json, reconstruction.json, residuals.json, and next.json of viewworth next.
#ifndef VIEWWORTH_RUN_OUTPUTS_RESULTS_FILES_H
#define VIEWWORTH_RUN_OUTPUTS_RESULTS_FILES_H

#include <jansson.h>
#include <stdbool.h>

#include "report/results.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"

enum { VW_SCENE_MAP_POINTS_MAX = 2000, VW_SCENE_MAP_DIGITS = 7 };

// Makes {"scene_hash": hex, "up": [x, y, z], "positions": [x, y, z, ...], "directions": [...], "points": [...],
// "defects": [{"defect", "description"} or null, ...]}. World coordinates with VW_SCENE_MAP_DIGITS; a position and a
// unit direction of view per image, in the order of the scene's views; `up` is the unit mean of the cameras' up axes;
// of more points than VW_SCENE_MAP_POINTS_MAX an evenly spread part is taken; `defects` has what the findings have, one
// per image. NULL when memory is short.
json_t *vw_scene_map_make(const struct vw_scene *scene, const struct vw_photo_finding *findings);

// Writes map.json, reconstruction.json and residuals.json, those that the results have.
enum vw_status vw_results_write_files(const struct vw_results *results, const struct vw_scene *scene, const char *out);
// Reads the same and next.json into results that have a row and images; with `no_photos` neither residuals.json nor
// the pictures of next.json. VW_ERROR_INPUT when one is not what it should be, is a link, or is of another scene.
enum vw_status vw_results_read_files(const char *out, bool no_photos, struct vw_results *results);
// Reads next.json alone, which a run does not make.
enum vw_status vw_results_read_next(const char *out, bool no_photos, struct vw_results *results);

#endif
