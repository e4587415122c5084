#include "detect/facts.h"

#include <math.h>

static bool is_used(const struct vw_view *view) { return view->split == VW_SPLIT_TRAIN || view->split == VW_SPLIT_VAL; }

static double corner_shift_px(const struct vw_camera *camera, double x_px, double y_px) {
    double direction[3] = {(x_px - camera->centre_x_px) / camera->focal_x_px,
                           -(y_px - camera->centre_y_px) / camera->focal_y_px, -1.0};
    double moved_x_px, moved_y_px;
    if (!vw_camera_project(camera, direction, &moved_x_px, &moved_y_px)) return 0.0;
    return hypot(moved_x_px - x_px, moved_y_px - y_px);
}

double vw_fact_distortion(const struct vw_scene *scene) {
    double largest_px = 0.0;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        const struct vw_camera *camera = &scene->views[v].camera;
        if (!vw_camera_is_distorted(camera)) continue;
        for (int corner = 0; corner < 4; corner++)
            largest_px = fmax(largest_px, corner_shift_px(camera, corner & 1 ? camera->width_px : 0.0,
                                                          corner & 2 ? camera->height_px : 0.0));
    }
    return largest_px;
}

static bool has_alpha(const struct vw_view *view) { return view->image.has_alpha; }
static bool has_mask(const struct vw_view *view) { return view->has_mask; }

static double share(const struct vw_scene *scene, bool (*holds)(const struct vw_view *view)) {
    uint32_t count = 0, used = 0;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        if (!is_used(&scene->views[v])) continue;
        count += holds(&scene->views[v]);
        used++;
    }
    return used ? (double)count / used : 0.0;
}

double vw_fact_background(const struct vw_scene *scene) { return share(scene, has_alpha); }

double vw_fact_masks(const struct vw_scene *scene) { return share(scene, has_mask); }
