// The box that the field covers.
#ifndef VIEWWORTH_SCENE_BOUNDS_H
#define VIEWWORTH_SCENE_BOUNDS_H

#include "viewworth/scene.h"

// A box as instant-ngp declares it: its coordinates are world * scale + offset, and its box is the cube of side
// aabb_scale around 1/2.
struct vw_ngp_box {
    double aabb_scale; // 0: not given
    double scale;
    double offset[3];
};

// Sets box and box_source: from `declared` (NULL: none) if it contains what the cameras look at, otherwise from the
// scene's points if there are enough, otherwise from its cameras.
enum vw_status vw_bounds_choose(const struct vw_ngp_box *declared, struct vw_scene *scene);

#endif
