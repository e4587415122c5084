// How near and how far each view sees the scene.
#ifndef VIEWWORTH_NEAR_FAR_H
#define VIEWWORTH_NEAR_FAR_H

#include "viewworth/scene.h"

// Sets near_world and far_world of every view from the depths (along its axis) of the points that it sees: their 0.1
// and 99.9 percentiles, interpolated, as NeRF-W takes them. 0, 0 where a view sees too few points to tell.
enum vw_status vw_near_far_measure(struct vw_scene *scene);

#endif
