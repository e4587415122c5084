// How far validation views are from what is trained on: a view that no training view comes near is validated by
// guesswork.
#ifndef VIEWWORTH_VIEW_DISTANCE_H
#define VIEWWORTH_VIEW_DISTANCE_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/scene.h"
#include "viewworth/status.h"

struct vw_view_distance {
    uint32_t view,
        nearest; // indices in vw_scene.views: a validation view, and the training view that is nearest in both respects
    double between_world; // positions, to that view
    double angle_deg;     // axes, to that view
    double ratio;         // of their distance to that of a training view and its nearest, at the median
    bool far; // ratio > 4, which is rare: no training view of fox, chair or statue is as far from the others
};

// The distance of two views is the larger of two ratios: of the distance between their positions to the median over the
// training views of that to the nearest one that is no copy (farther than 2 % and 2 degrees), and of the angle between
// their axes likewise. These medians count as at least 2 % of the median distance to the box's centre, and as 10
// degrees: nearer views see the same, however dense the others lie.
// `*distances`, one per validation view in scene order, is owned by the caller (free). With fewer than two training
// views there are none.
enum vw_status vw_scene_view_distances(const struct vw_scene *scene, struct vw_view_distance **distances,
                                       uint32_t *count);

#endif
