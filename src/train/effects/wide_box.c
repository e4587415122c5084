#include "train/effects/wide_box.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/statistics.h"

static const double SHARE = 0.99, MARGIN = 1.1, LEAST = 1.0, MOST = 4.0, WITHOUT_POINTS = 2.0;
enum { POINTS_MIN = 64 }; // as for the scene's box

// Returns the distance from the box's centre, in its half extents; by the largest coordinate, since the box is a cube.
static double distance_of(const struct vw_point *point, const struct vw_box *box) {
    double most = 0.0;
    for (int i = 0; i < 3; i++) most = fmax(most, fabs(point->position_world[i] - box->centre_world[i]));
    return most / box->half_extent_world;
}

enum vw_status wide_box(const struct vw_scene *scene, struct vw_box *box) {
    double widening = WITHOUT_POINTS;
    if (scene->point_count >= POINTS_MIN && scene->track_count) {
        double *distances = vw_allocate(scene->track_count, sizeof *distances);
        uint32_t count = 0;
        if (!distances) return VW_ERROR_MEMORY;
        for (uint32_t p = 0; p < scene->point_count; p++)
            for (uint32_t t = 0; t < scene->points[p].track_count; t++)
                distances[count++] = distance_of(&scene->points[p], &scene->box);
        vw_sort(distances, count);
        if (count) widening = MARGIN * vw_quantile_of_sorted(distances, count, SHARE);
        free(distances);
    }
    *box = scene->box;
    box->half_extent_world *= fmin(fmax(widening, LEAST), MOST);
    return VW_OK;
}
