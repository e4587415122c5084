// The range of depths that each view sees.
#ifndef VIEWWORTH_SCENE_NEAR_FAR_H
#define VIEWWORTH_SCENE_NEAR_FAR_H

#include "viewworth/scene.h"

// Sets near_world and far_world of every view from the depths (along its axis) of the points that it sees: their 0.1
// and 99.9 percentiles, interpolated, as in NeRF-W. 0, 0 if a view sees too few points.
enum vw_status vw_near_far_measure(struct vw_scene *scene);

#endif
