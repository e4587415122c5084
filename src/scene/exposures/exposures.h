#ifndef VIEWWORTH_SCENE_EXPOSURES_EXPOSURES_H
#define VIEWWORTH_SCENE_EXPOSURES_EXPOSURES_H

#include "viewworth/scene.h"
#include "viewworth/status.h"

// Sets scene->points_tell_exposures, which splits and points decide.
enum vw_status vw_scene_ask_points_for_exposures(struct vw_scene *scene);

#endif
