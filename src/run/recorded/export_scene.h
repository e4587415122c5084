// Writes the scene of a run for other programs: its cameras, coloured by the scores of their photos, and its points.
#ifndef VIEWWORTH_RUN_RECORDED_EXPORT_SCENE_H
#define VIEWWORTH_RUN_RECORDED_EXPORT_SCENE_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/status.h"

struct vw_export_params {
    const char *out;     // the folder of the run
    const char *cameras; // .ply or .json; NULL: none
    const char *points;  // .ply; NULL: none
    const char *device;  // NULL: the preferred one
};

struct vw_export {
    const char *method; // static; whose ranks colour the cameras
    uint32_t camera_count, point_count;
};

// Writes each file whole or not at all. VW_ERROR_USAGE if one exists, VW_ERROR_INPUT if points are asked of a scene
// without any.
enum vw_status vw_export_scene(const struct vw_export_params *params, struct vw_export *exported);

#endif
