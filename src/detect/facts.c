#include "detect/facts.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "gpu/compute.h"
#include "train/evaluator.h"

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

// ---- Measured on a pilot --------------------------------------------------------------------------------------------

// The field's own passes, on rays of ours: each runs along x through the middles of a row of cells, and samples fall on
// them.

static const double OPACITY_MIN = 0.01; // opacity of a stratum; density * length, as 1 - exp(-x) is x here

static void fill_rays(uint32_t cells, uint32_t first, uint32_t count, struct vw_ray *rays) {
    for (uint32_t i = 0; i < count; i++) {
        float y = (float)((first + i) % cells), z = (float)((first + i) / cells % cells), edge = 1.0f / (float)cells;
        rays[i] = (struct vw_ray){.origin_near = {0.0f, (y + 0.5f) * edge, (z + 0.5f) * edge, 0.0f},
                                  .direction_stride = {1.0f, 0.0f, 0.0f, edge}};
    }
}

static enum vw_status count_part(struct vw_evaluator *evaluator, uint32_t cells, uint32_t rays, uint32_t *occupied) {
    vw_float4 *samples = vw_allocate((size_t)rays * cells, sizeof *samples);
    if (!samples) return VW_ERROR_MEMORY;
    enum vw_status status = vw_evaluator_run(evaluator);
    if (!status) status = vw_buffer_read(evaluator->samples, 0, samples, (uint64_t)rays * cells * sizeof *samples);
    for (uint32_t i = 0; !status && i < rays * cells; i++) *occupied += samples[i].w >= OPACITY_MIN * cells;
    free(samples);
    return status;
}

enum vw_status vw_occupied_share(struct vw_radiance_field *field, uint32_t samples, double *share) {
    uint32_t cells = samples, occupied = 0;
    struct vw_evaluator evaluator = {0};
    struct vw_ray *rays = NULL;
    enum vw_status status = vw_evaluator_create(field, cells, &evaluator); // a layer of cells at a time
    if (!status) rays = vw_allocate(evaluator.ray_count, sizeof *rays);
    if (!status && !rays) status = VW_ERROR_MEMORY;
    for (uint32_t layer = 0; layer < cells && !status; layer++) {
        fill_rays(cells, layer * cells, evaluator.ray_count, rays);
        status = vw_buffer_write(evaluator.rays, 0, rays, evaluator.ray_count * sizeof *rays);
        if (!status) status = count_part(&evaluator, cells, cells, &occupied);
    }
    if (!status) *share = (double)occupied / ((double)cells * cells * cells);
    vw_evaluator_destroy(&evaluator);
    free(rays);
    return status;
}
