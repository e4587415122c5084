#include "scene/lens_mask.h"

#include <math.h>
#include <string.h>

#include "base/memory.h"

static double distance_of(const struct vw_camera *camera, double x_px, double y_px) {
    return hypot((x_px - camera->centre_x_px) / camera->focal_x_px, (y_px - camera->centre_y_px) / camera->focal_y_px);
}

// Returns the distance from the principal point to the farthest pixel, which is in a corner.
static double farthest(const struct vw_camera *camera) {
    double distance = 0;
    for (int corner = 0; corner < 4; corner++)
        distance = fmax(distance, distance_of(camera, corner & 1 ? camera->width_px - 0.5 : 0.5,
                                              corner & 2 ? camera->height_px - 0.5 : 0.5));
    return distance;
}

enum vw_status vw_lens_mask(struct vw_view *view, uint64_t *hidden_count) {
    const struct vw_camera *camera = &view->camera;
    double reach = vw_camera_reach(camera);
    if (farthest(camera) < reach) return VW_OK;
    size_t pixel_count = (size_t)camera->width_px * camera->height_px;
    if (!view->mask) {
        view->mask = vw_allocate(pixel_count, 1);
        if (!view->mask) return VW_ERROR_MEMORY;
        memset(view->mask, VW_MASK_KEEP, pixel_count);
    }
    for (size_t i = 0; i < pixel_count; i++) {
        if (distance_of(camera, (double)(i % camera->width_px) + 0.5, (double)(i / camera->width_px) + 0.5) < reach)
            continue;
        view->mask[i] = VW_MASK_BEYOND_LENS;
        ++*hidden_count;
    }
    return VW_OK;
}
