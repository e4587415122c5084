#include <stdlib.h>

#include "base/memory.h"
#include "base/statistics.h"
#include "scene/builder.h"
#include "viewworth/scene.h"

static double depth_of(const struct vw_view *view, const double position_world[3]) {
    double depth = 0;
    for (int i = 0; i < 3; i++)
        depth -= (position_world[i] - view->camera_to_world[i][3]) * view->camera_to_world[i][2];
    return depth;
}

// Points behind a camera are ignored.
static void gather(const struct vw_scene *scene, vw_track_filter *counts, const void *context, uint32_t *ends,
                   double *depths) {
    for (int filling = 0; filling < 2; filling++) { // count, then fill
        for (uint32_t p = 0; p < scene->point_count; p++) {
            const struct vw_point *point = &scene->points[p];
            for (uint32_t t = point->first_track; t < point->first_track + point->track_count; t++) {
                uint32_t v = scene->tracks[t].view;
                double depth = depth_of(&scene->views[v], point->position_world);
                if (!(depth > 0) || (counts && !counts(context, &scene->tracks[t]))) continue;
                if (filling) depths[ends[v]] = depth;
                ends[v + !filling]++; // counts are stored one entry further, so that their sums are the begins
            }
        }
        for (uint32_t v = 1; !filling && v <= scene->view_count; v++) ends[v] += ends[v - 1];
    }
}

enum vw_status vw_scene_depths(const struct vw_scene *scene, vw_track_filter *counts, const void *context,
                               uint32_t **ends, double **depths) {
    *ends = vw_allocate((size_t)scene->view_count + 1, sizeof **ends);
    *depths = vw_allocate(scene->track_count, sizeof **depths);
    if (*ends && *depths) {
        gather(scene, counts, context, *ends, *depths);
        return VW_OK;
    }
    free(*ends);
    free(*depths);
    *ends = NULL;
    *depths = NULL;
    return VW_ERROR_MEMORY;
}

// ---- Near and far ----

static const double NEAR_SHARE = 0.001, FAR_SHARE = 0.999;
// On average, a share of 2 / (n + 1) of what a view sees is outside the range of n points: 6 % here, which the margins
// of vw_pixels_camera() cover. With fewer points, whole surfaces could be cut off.
enum { POINTS_MIN = 32 };

enum vw_status vw_near_far_measure(struct vw_scene *scene) {
    uint32_t *ends;
    double *depths;
    enum vw_status status = vw_scene_depths(scene, NULL, NULL, &ends, &depths);
    for (uint32_t v = 0, begin = 0; !status && v < scene->view_count; begin = ends[v++]) {
        struct vw_view *view = &scene->views[v];
        uint32_t count = ends[v] - begin;
        bool known = count >= POINTS_MIN;
        vw_sort(depths + begin, count);
        view->near_world = known ? vw_quantile_of_sorted(depths + begin, count, NEAR_SHARE) : 0;
        view->far_world = known ? vw_quantile_of_sorted(depths + begin, count, FAR_SHARE) : 0;
    }
    if (status) return status;
    free(ends);
    free(depths);
    return VW_OK;
}
