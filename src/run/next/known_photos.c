#include "run/next/known_photos.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/statistics.h"
#include "train/trainer.h"

enum { VAL_PIXELS_MAX = 4096 }; // pixels that the error of a validation photo is measured on

static enum vw_status make_maps(struct vw_known_photos *known) {
    struct vw_view *poses = vw_allocate(known->count, sizeof *poses);
    if (!poses) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < known->count; i++) poses[i] = *vw_known_photo(known, i);
    enum vw_status status = vw_depth_maps_make(&known->depths, known->views, poses, known->count, &known->maps);
    free(poses);
    return status;
}

static enum vw_status find_points(struct vw_known_photos *known) {
    double *seen_by = vw_allocate(known->count, sizeof *seen_by);
    known->points = vw_allocate(known->count, sizeof *known->points);
    bool made = seen_by && known->points;
    for (uint32_t i = 0; i < known->count && made; i++) {
        vw_seen_points_find(&known->maps[i], known->maps, known->count, known->count, &known->points[i]);
        seen_by[i] = fmax(vw_seen_points_median(&known->points[i]) - 1, 0); // without itself
    }
    if (made) known->usual_seen_by = vw_median(seen_by, known->count);
    free(seen_by);
    return made ? VW_OK : VW_ERROR_MEMORY;
}

enum vw_status vw_known_photos_create(const struct vw_scene *scene, const struct vw_depth_source *depths, uint64_t seed,
                                      struct vw_known_photos *known) {
    *known = (struct vw_known_photos){.scene = scene, .depths = *depths, .seed = seed};
    enum vw_status status = vw_scene_list_views(scene, VW_SPLIT_TRAIN, &known->views, &known->count);
    if (!status) status = vw_scene_list_views(scene, VW_SPLIT_VAL, &known->val_views, &known->val_count);
    if (!status && !(known->val_mse = vw_allocate(known->val_count, sizeof *known->val_mse))) status = VW_ERROR_MEMORY;
    if (!status) status = vw_view_scales_find(scene, &known->scales);
    if (!status) status = make_maps(known);
    return status ? status : find_points(known);
}

// Keeps the finite errors and their photos, and finds the median.
static void take_errors(const struct vw_view_error *errors, double *scratch, struct vw_known_photos *known) {
    uint32_t kept = 0;
    for (uint32_t i = 0; i < known->val_count; i++) {
        if (!isfinite(errors[i].mse)) continue;
        known->val_views[kept] = known->val_views[i];
        scratch[kept] = known->val_mse[kept] = errors[i].mse;
        kept++;
    }
    known->val_count = kept;
    known->usual_mse = vw_median(scratch, kept);
}

enum vw_status vw_known_photos_measure(struct vw_known_photos *known, struct vw_trainer *trainer) {
    struct vw_view_error *errors = vw_allocate(known->val_count, sizeof *errors);
    double *scratch = vw_allocate(known->val_count, sizeof *scratch);
    enum vw_status status = errors && scratch ? VW_OK : VW_ERROR_MEMORY;
    if (!status && known->val_count)
        status = vw_trainer_measure_views(trainer, known->val_views, known->val_count, VAL_PIXELS_MAX, errors);
    if (!status) take_errors(errors, scratch, known);
    free(errors);
    free(scratch);
    return status;
}

const struct vw_view *vw_known_photo(const struct vw_known_photos *known, uint32_t photo) {
    return &known->scene->views[known->views[photo]];
}

static double focal_share(const struct vw_known_photos *known, uint32_t photo) {
    const struct vw_camera *camera = &vw_known_photo(known, photo)->camera;
    return camera->focal_x_px / fmax(camera->width_px, camera->height_px);
}

uint32_t vw_known_photos_usual(const struct vw_known_photos *known) {
    uint32_t usual = 0;
    for (uint32_t i = 0; i < known->count; i++) {
        uint32_t below = 0;
        for (uint32_t j = 0; j < known->count; j++) {
            double difference = focal_share(known, j) - focal_share(known, i);
            below += difference < 0 || (difference == 0 && j < i);
        }
        if (below == (known->count - 1) / 2) usual = i;
    }
    return usual;
}

uint32_t vw_known_photos_nearest(const struct vw_known_photos *known, const struct vw_view *pose) {
    uint32_t nearest = 0;
    double least_world = INFINITY;
    for (uint32_t i = 0; i < known->count; i++) {
        double between_world = vw_view_between_world(pose, vw_known_photo(known, i));
        if (between_world < least_world) least_world = between_world, nearest = i;
    }
    return nearest;
}

void vw_known_photos_destroy(struct vw_known_photos *known) {
    free(known->views);
    free(known->maps);
    free(known->points);
    free(known->val_views);
    free(known->val_mse);
    *known = (struct vw_known_photos){0};
}
