#include "scene/near_far.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "viewworth/memory.h"

static const double NEAR_SHARE = 0.001, FAR_SHARE = 0.999;
// n points drawn from a view leave 2 / (n + 1) of what it sees outside their range on average: 6 % here, which the margins of
// pixels_camera() are there for. With fewer points, whole surfaces could be cut off.
enum { POINTS_MIN = 32 };

static double depth_of(const struct vw_view *view, const double position_world[3]) {
    double depth = 0;
    for (int i = 0; i < 3; i++) depth -= (position_world[i] - view->camera_to_world[i][3]) * view->camera_to_world[i][2];
    return depth;
}

static int compare_doubles(const void *a, const void *b) {
    double left = *(const double *)a, right = *(const double *)b;
    return (left > right) - (left < right);
}

// Of sorted values, linear between neighbours.
static double quantile(const double *sorted, uint32_t count, double share) {
    double place = share * (count - 1);
    uint32_t below = (uint32_t)place, above = below + 1 < count ? below + 1 : below;
    return sorted[below] + (place - below) * (sorted[above] - sorted[below]);
}

// Sorts the depths of all tracks by view: those of view v are depths[ends[v - 1]] to depths[ends[v] - 1]. Points behind a camera are no
// evidence of what it sees.
static void gather(const struct vw_scene *scene, uint32_t *ends, double *depths) {
    for (int pass = 0; pass < 2; pass++) { // count, then fill
        for (uint32_t p = 0; p < scene->point_count; p++) {
            const struct vw_point *point = &scene->points[p];
            for (uint32_t t = point->first_track; t < point->first_track + point->track_count; t++) {
                uint32_t v = scene->tracks[t].view;
                double depth = depth_of(&scene->views[v], point->position_world);
                if (!(depth > 0)) continue;
                if (pass) depths[ends[v]] = depth;
                ends[v + !pass]++; // the count of view v lies one further, so that sums of counts are begins
            }
        }
        for (uint32_t v = 1; !pass && v <= scene->view_count; v++) ends[v] += ends[v - 1];
    }
}

enum vw_status vw_near_far_measure(struct vw_scene *scene) {
    uint32_t *ends = vw_allocate((size_t)scene->view_count + 1, sizeof *ends);
    double *depths = vw_allocate(scene->track_count, sizeof *depths);
    enum vw_status status = ends && depths ? VW_OK : VW_ERROR_MEMORY;
    if (!status) gather(scene, ends, depths);
    for (uint32_t v = 0, begin = 0; !status && v < scene->view_count; begin = ends[v++]) {
        struct vw_view *view = &scene->views[v];
        uint32_t count = ends[v] - begin;
        bool known = count >= POINTS_MIN;
        qsort(depths + begin, count, sizeof *depths, compare_doubles);
        view->near_world = known ? quantile(depths + begin, count, NEAR_SHARE) : 0;
        view->far_world = known ? quantile(depths + begin, count, FAR_SHARE) : 0;
    }
    free(ends);
    free(depths);
    return status;
}
