// The box that the field lives in.
#ifndef VIEWWORTH_BOUNDS_H
#define VIEWWORTH_BOUNDS_H

#include "viewworth/scene.h"

// instant-ngp's way to name a box: its coordinates are world * scale + offset, and its box is the cube of side
// aabb_scale around 1/2.
struct vw_ngp_box {
    double aabb_scale; // 0: not given
    double scale;
    double offset[3];
};

// Sets box and box_source from `declared` (may be NULL), where it is given and holds what the cameras look at; else
// from the scene's points, where there are enough; else from its cameras.
enum vw_status vw_bounds_choose(const struct vw_ngp_box *declared, struct vw_scene *scene);

#endif
