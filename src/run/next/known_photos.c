#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "run/next/next_private.h"
#include "train/trainer.h"

enum { VAL_PIXELS_MAX = 4096 }; // pixels that the error of a validation photo is measured on
static const double NEAREST_SHARE = 0.05, BEHIND_MOST = 1.1;
static const double SIDE_COSINE_LEAST = 0.5; // two rays to a point, at most 60 degrees apart

// ---- Depth maps ----------------------------------------------------------------------------------------------------

static void fill_map(const struct vw_view *pose, const float *depths_world, struct vw_depth_map *map) {
    double seen[VW_DEPTH_MAP_PIXELS];
    map->pose = *pose;
    memcpy(map->depths_world, depths_world, sizeof map->depths_world);
    for (uint32_t i = 0; i < VW_DEPTH_MAP_PIXELS; i++)
        if (depths_world[i] > 0) seen[map->seen_count++] = (double)depths_world[i];
    if (!map->seen_count) return;
    vw_sort(seen, map->seen_count);
    map->nearest_world = vw_quantile_of_sorted(seen, map->seen_count, NEAREST_SHARE);
    map->median_world = vw_quantile_of_sorted(seen, map->seen_count, 0.5);
}

enum vw_status vw_depth_maps_make(const struct vw_known_photos *known, const uint32_t *views,
                                  const struct vw_view *poses, uint32_t count, struct vw_depth_map **maps) {
    struct vw_view *small = vw_allocate(count, sizeof *small);
    float *depths_world = NULL;
    *maps = vw_allocate(count, sizeof **maps);
    enum vw_status status = small && *maps ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < count && !status; i++) {
        small[i] = poses[i];
        small[i].camera = vw_camera_resized(&poses[i].camera, VW_DEPTH_MAP_WIDTH_PX, VW_DEPTH_MAP_HEIGHT_PX);
    }
    if (!status) status = known->render(known->context, views, small, count, &depths_world);
    for (uint32_t i = 0; i < count && !status; i++)
        fill_map(&small[i], depths_world + (size_t)i * VW_DEPTH_MAP_PIXELS, &(*maps)[i]);
    free(small);
    free(depths_world);
    return status;
}

bool vw_depth_map_point(const struct vw_depth_map *map, uint32_t pixel, double point_world[3]) {
    const struct vw_camera *camera = &map->pose.camera;
    uint32_t column_px = pixel % VW_DEPTH_MAP_WIDTH_PX, row_px = pixel / VW_DEPTH_MAP_WIDTH_PX;
    double depth = (double)map->depths_world[pixel];
    double right = (column_px + 0.5 - camera->centre_x_px) / camera->focal_x_px,
           up = (camera->centre_y_px - row_px - 0.5) / camera->focal_y_px;
    for (int i = 0; i < 3; i++) {
        const double *row = map->pose.camera_to_world[i];
        point_world[i] =
            row[VW_POSE_POSITION] + depth * (row[VW_POSE_RIGHT] * right + row[VW_POSE_UP] * up - row[VW_POSE_BACK]);
    }
    return depth > 0;
}

bool vw_depth_map_sees(const struct vw_depth_map *map, const double from_world[3], const double point_world[3]) {
    const struct vw_camera *camera = &map->pose.camera;
    double place[3] = {0}, ray[3], other[3];
    for (int i = 0; i < 3; i++) {
        ray[i] = point_world[i] - map->pose.camera_to_world[i][VW_POSE_POSITION];
        other[i] = point_world[i] - from_world[i];
        for (int axis = 0; axis < 3; axis++) place[axis] += map->pose.camera_to_world[i][axis] * ray[i];
    }
    double depth = -place[2];
    if (!(depth > 0) || vw_dot(ray, other, 3) < SIDE_COSINE_LEAST * sqrt(vw_dot(ray, ray, 3) * vw_dot(other, other, 3)))
        return false;
    double column = camera->centre_x_px + camera->focal_x_px * place[0] / depth,
           row = camera->centre_y_px - camera->focal_y_px * place[1] / depth;
    if (!(column >= 0 && column < VW_DEPTH_MAP_WIDTH_PX && row >= 0 && row < VW_DEPTH_MAP_HEIGHT_PX)) return false;
    return depth <= BEHIND_MOST * (double)map->depths_world[(int)row * VW_DEPTH_MAP_WIDTH_PX + (int)column];
}

void vw_seen_points_find(const struct vw_depth_map *map, const struct vw_known_photos *known, uint32_t most,
                         struct vw_seen_points *points) {
    const double(*pose)[4] = map->pose.camera_to_world;
    const double from_world[] = {pose[0][VW_POSE_POSITION], pose[1][VW_POSE_POSITION], pose[2][VW_POSE_POSITION]};
    points->count = 0;
    for (uint32_t pixel = 0; pixel < VW_DEPTH_MAP_PIXELS; pixel += 2) {
        double *point = points->points_world[points->count];
        if (pixel / VW_DEPTH_MAP_WIDTH_PX % 2 || !vw_depth_map_point(map, pixel, point)) continue;
        uint32_t seeing = 0;
        for (uint32_t i = 0; i < known->count && seeing < most; i++)
            seeing += vw_depth_map_sees(&known->maps[i], from_world, point);
        points->seen_by[points->count++] = seeing;
    }
}

double vw_seen_points_median(const struct vw_seen_points *points) {
    double seen_by[VW_SEEN_POINTS_MOST];
    memcpy(seen_by, points->seen_by, sizeof seen_by);
    return points->count ? vw_median(seen_by, points->count) : 0;
}

// ---- Photos --------------------------------------------------------------------------------------------------------

static enum vw_status make_maps(struct vw_known_photos *known) {
    struct vw_view *poses = vw_allocate(known->count, sizeof *poses);
    for (uint32_t i = 0; poses && i < known->count; i++) poses[i] = *vw_known_photo(known, i);
    enum vw_status status =
        poses ? vw_depth_maps_make(known, known->views, poses, known->count, &known->maps) : VW_ERROR_MEMORY;
    free(poses);
    return status;
}

// Finds what photos see, and what is usual among them.
static void find_points(struct vw_known_photos *known) {
    uint32_t count = known->count;
    for (uint32_t i = 0; i < count; i++) {
        vw_seen_points_find(&known->maps[i], known, count, &known->points[i]);
        known->values[i] = fmax(vw_seen_points_median(&known->points[i]) - 1, 0); // without itself
    }
    known->usual_seen_by = vw_median(known->values, count);
    for (uint32_t i = 0; i < count; i++) known->values[i] = known->maps[i].seen_count;
    known->usual_count = vw_median(known->values, count);
    for (uint32_t i = 0; i < count; i++) {
        const struct vw_camera *camera = &vw_known_photo(known, i)->camera;
        known->values[i] = camera->focal_x_px / fmax(camera->width_px, camera->height_px);
    }
    vw_order(known->values, count, known->ordered);
    known->usual = known->ordered[(count - 1) / 2].place;
}

enum vw_status vw_known_photos_create(const struct vw_scene *scene, uint64_t seed, vw_depth_renderer *render,
                                      void *context, struct vw_known_photos *known) {
    *known = (struct vw_known_photos){.scene = scene, .seed = seed, .render = render, .context = context};
    enum vw_status status = vw_view_scales_find(scene, &known->scales);
    if (!status) status = vw_scene_list_views(scene, VW_SPLIT_TRAIN, &known->views, &known->count);
    if (!status) status = vw_scene_list_views(scene, VW_SPLIT_VAL, &known->val_views, &known->val_count);
    if (status) return status;
    known->points = vw_allocate(known->count, sizeof *known->points);
    known->values = vw_allocate(known->count, sizeof *known->values);
    known->ordered = vw_allocate(known->count, sizeof *known->ordered);
    known->val_mse = vw_allocate(known->val_count, sizeof *known->val_mse);
    if (!known->points || !known->values || !known->ordered || !known->val_mse) return VW_ERROR_MEMORY;
    status = make_maps(known);
    if (!status) find_points(known);
    return status;
}

enum vw_status vw_known_photos_measure(struct vw_known_photos *known, struct vw_trainer *trainer) {
    struct vw_view_error *errors = vw_allocate(known->val_count, sizeof *errors);
    double *sorted = vw_allocate(known->val_count, sizeof *sorted);
    uint32_t count = known->val_count, finite = 0;
    enum vw_status status = errors && sorted ? VW_OK : VW_ERROR_MEMORY;
    if (!status && count) status = vw_trainer_measure_views(trainer, known->val_views, count, VAL_PIXELS_MAX, errors);
    for (uint32_t i = 0; i < count && !status; i++) {
        if (!isfinite(errors[i].mse)) continue;
        known->val_views[finite] = known->val_views[i];
        sorted[finite] = known->val_mse[finite] = errors[i].mse;
        finite++;
    }
    known->val_count = finite;
    if (!status) known->usual_mse = vw_median(sorted, finite);
    free(errors);
    free(sorted);
    return status;
}

const struct vw_view *vw_known_photo(const struct vw_known_photos *known, uint32_t photo) {
    return &known->scene->views[known->views[photo]];
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
    free(known->values);
    free(known->ordered);
    free(known->val_views);
    free(known->val_mse);
    *known = (struct vw_known_photos){0};
}
