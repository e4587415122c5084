#include "scene/near_far.h"

#include <stdlib.h>

#include "base/statistics.h"

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
