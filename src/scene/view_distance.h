// Distances of views from the train views: validation tells little about places without train views nearby.
#ifndef VIEWWORTH_SCENE_VIEW_DISTANCE_H
#define VIEWWORTH_SCENE_VIEW_DISTANCE_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/scene.h"
#include "viewworth/status.h"

// The units of distances between poses.
struct vw_view_scales {
    double between_world, angle; // units of the distance of positions and of the angle between axes
    double copy_world;           // the distance below which a view of the same direction is a copy
    double typical;              // the median, in these units, over train views, to the nearest other one; at least 1
};
// Finds the units of a scene, as vw_scene_view_distances() says. VW_ERROR_USAGE below two train views.
enum vw_status vw_view_scales_find(const struct vw_scene *scene, struct vw_view_scales *scales);
double vw_view_between_world(const struct vw_view *a, const struct vw_view *b);
// Returns the distance of two poses as vw_view_distance.ratio says it: 1 is usual between neighbours.
double vw_view_apart(const struct vw_view_scales *scales, const struct vw_view *a, const struct vw_view *b);
// Returns the place in `views`, scene indices, of the one that is the least apart from a pose, of equal ones the first.
// `apart`: its distance; INFINITY without views.
uint32_t vw_view_nearest(const struct vw_scene *scene, const struct vw_view_scales *scales, const uint32_t *views,
                         uint32_t count, const struct vw_view *pose, double *apart);

struct vw_view_distance {
    uint32_t view, nearest; // indices in vw_scene.views: a view, and the nearest train view in both respects
    double between_world;   // distance of the positions
    double angle_deg;       // angle between the axes
    double ratio;           // their distance, divided by the median distance of a train view to its nearest one
    bool far; // ratio > 4, which is rare: no train view of fox, chair or statue is that far from the others
};

// Measures the distance of each view of a split to its nearest train view. For a train view, neither it nor its copies
// count; a train view without any other is left out.
//
// The distance of two views is the larger of two ratios: the distance of their positions, divided by its median over
// pairs of a train view and its nearest train view that is not a copy (farther than 2 % and 2 degrees), and the same
// for the angle between their axes. The medians count as at least 2 % of the median distance to the box's centre and as
// at least 10 degrees, because nearer views see the same. `*distances`, one per view of the split in scene order, is
// owned by the caller (free). It is empty if there are fewer than two train views.
enum vw_status vw_scene_view_distances(const struct vw_scene *scene, enum vw_split split,
                                       struct vw_view_distance **distances, uint32_t *count);

#endif
