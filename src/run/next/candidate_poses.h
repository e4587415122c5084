// Poses for the next photos: places between, beside and beyond the cameras of known photos, before anything is known
// of what is there.
#ifndef VIEWWORTH_RUN_NEXT_CANDIDATE_POSES_H
#define VIEWWORTH_RUN_NEXT_CANDIDATE_POSES_H

#include <stdbool.h>
#include <stdint.h>

#include "scene/view_distance.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"

enum { VW_POSE_TARGETS = 8 };

// A known photo, as poses are made from it.
struct vw_pose_base {
    uint32_t view;         // scene index
    double focus_world[3]; // on its axis, at its median depth
    uint32_t target_count; // surface points that it sees and few photos see, the fewest first
    double targets_world[VW_POSE_TARGETS][3];
};

struct vw_pose_bases {
    const struct vw_scene *scene;
    const struct vw_view_scales *scales;
    const struct vw_pose_base *bases;
    uint32_t count;
    uint64_t seed;
};

// Returns the one of these views whose focal length, as a share of its longer side, is in the middle.
uint32_t vw_usual_view(const struct vw_scene *scene, const uint32_t *views, uint32_t count);

// Makes the draw-th pose of a known photo, without a camera and a range of depths. Half of them lie between its camera
// and two of the six nearest ones: their mean with random weights. The others lie beside or beyond it: 0.5 to 2 usual
// distances away in a random direction. A pose looks at what those cameras look at, in the same mean, a quarter of them
// at one of the photo's targets; its up is theirs. Returns false where no camera can be placed so.
bool vw_pose_draw(const struct vw_pose_bases *known, uint32_t base, uint32_t draw, double camera_to_world[3][4]);

#endif
