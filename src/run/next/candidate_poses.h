// Poses for the next photos: places between, beside and beyond the cameras of known photos, before anything is known
// of what is there.
#ifndef VIEWWORTH_RUN_NEXT_CANDIDATE_POSES_H
#define VIEWWORTH_RUN_NEXT_CANDIDATE_POSES_H

#include "run/next/known_photos.h"

enum { VW_POSE_TARGETS = 8 };

// Places that a known photo looks at.
struct vw_pose_base {
    double focus_world[3]; // on its axis, at its median depth
    uint32_t target_count; // surface points that it sees and few photos see, the fewest first
    double targets_world[VW_POSE_TARGETS][3];
};

// Finds them for the photo at a place of known->views.
void vw_pose_base_find(const struct vw_known_photos *known, uint32_t photo, struct vw_pose_base *base);

// Makes the draw-th pose of a known photo, without a camera and a range of depths. Half of them lie between its camera
// and two of the six nearest ones: their mean with random weights. The others lie beside or beyond it: 0.5 to 2 usual
// distances away in a random direction. A pose looks at what those cameras look at, in the same mean, a quarter of them
// at one of the photo's targets; its up is theirs. `bases` are those of all known photos. Returns false where no camera
// can be placed so.
bool vw_pose_draw(const struct vw_known_photos *known, const struct vw_pose_base *bases, uint32_t photo, uint32_t draw,
                  double camera_to_world[3][4]);

#endif
