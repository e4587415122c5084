#include "run/next/depth_maps.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/statistics.h"
#include "scene/camera_path.h"

static const double NEAREST_SHARE = 0.05, BEHIND_MOST = 1.1;
static const double SIDE_COSINE_LEAST = 0.5; // two rays to a point, at most 60 degrees apart

static struct vw_view small_pose(const struct vw_view *pose) {
    struct vw_view small = {.camera = vw_camera_resized(&pose->camera, VW_DEPTH_MAP_WIDTH_PX, VW_DEPTH_MAP_HEIGHT_PX),
                            .near_world = pose->near_world,
                            .far_world = pose->far_world};
    memcpy(small.camera_to_world, pose->camera_to_world, sizeof small.camera_to_world);
    return small;
}

static void fill_map(const struct vw_view *pose, const float *depths_world, struct vw_depth_map *map) {
    double seen[VW_DEPTH_MAP_PIXELS];
    *map = (struct vw_depth_map){.pose = *pose};
    memcpy(map->depths_world, depths_world, sizeof map->depths_world);
    for (uint32_t i = 0; i < VW_DEPTH_MAP_PIXELS; i++)
        if (depths_world[i] > 0) seen[map->seen_count++] = (double)depths_world[i];
    if (!map->seen_count) return;
    vw_sort(seen, map->seen_count);
    map->nearest_world = vw_quantile_of_sorted(seen, map->seen_count, NEAREST_SHARE);
    map->median_world = vw_quantile_of_sorted(seen, map->seen_count, 0.5);
}

enum vw_status vw_depth_maps_make(const struct vw_depth_source *source, const uint32_t *views,
                                  const struct vw_view *poses, uint32_t count, struct vw_depth_map **maps) {
    struct vw_view *small = vw_allocate(count, sizeof *small);
    struct vw_depth_map *made = vw_allocate(count, sizeof *made);
    float *depths_world = NULL;
    enum vw_status status = small && made ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < count && !status; i++) small[i] = small_pose(&poses[i]);
    if (!status) status = source->render(source->context, views, small, count, &depths_world);
    for (uint32_t i = 0; i < count && !status; i++)
        fill_map(&small[i], depths_world + (size_t)i * VW_DEPTH_MAP_PIXELS, &made[i]);
    free(small);
    free(depths_world);
    if (!status) *maps = made;
    else free(made);
    return status;
}

bool vw_depth_map_point(const struct vw_depth_map *map, uint32_t pixel, struct vw_sight *sight) {
    const struct vw_camera *camera = &map->pose.camera;
    uint32_t column_px = pixel % VW_DEPTH_MAP_WIDTH_PX, row_px = pixel / VW_DEPTH_MAP_WIDTH_PX;
    double depth = (double)map->depths_world[pixel];
    double right = (column_px + 0.5 - camera->centre_x_px) / camera->focal_x_px,
           up = (camera->centre_y_px - row_px - 0.5) / camera->focal_y_px;
    for (int i = 0; i < 3; i++) {
        const double *row = map->pose.camera_to_world[i];
        sight->from_world[i] = row[VW_POSE_POSITION];
        sight->point_world[i] =
            row[VW_POSE_POSITION] + depth * (row[VW_POSE_RIGHT] * right + row[VW_POSE_UP] * up - row[VW_POSE_BACK]);
    }
    return depth > 0;
}

bool vw_depth_map_sees(const struct vw_depth_map *map, const struct vw_sight *sight) {
    const struct vw_camera *camera = &map->pose.camera;
    double place[3] = {0}, ray[3], other[3];
    for (int i = 0; i < 3; i++) {
        ray[i] = sight->point_world[i] - map->pose.camera_to_world[i][VW_POSE_POSITION];
        other[i] = sight->point_world[i] - sight->from_world[i];
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

void vw_seen_points_find(const struct vw_depth_map *map, const struct vw_depth_map *maps, uint32_t count, uint32_t most,
                         struct vw_seen_points *points) {
    points->count = 0;
    for (uint32_t pixel = 0; pixel < VW_DEPTH_MAP_PIXELS; pixel += 2) {
        struct vw_sight sight;
        if (pixel / VW_DEPTH_MAP_WIDTH_PX % 2 || !vw_depth_map_point(map, pixel, &sight)) continue;
        uint32_t seeing = 0;
        for (uint32_t i = 0; i < count && seeing < most; i++) seeing += vw_depth_map_sees(&maps[i], &sight);
        memcpy(points->points_world[points->count], sight.point_world, sizeof sight.point_world);
        points->seen_by[points->count++] = seeing;
    }
}

double vw_seen_points_median(const struct vw_seen_points *points) {
    double seen_by[VW_SEEN_POINTS_MOST];
    memcpy(seen_by, points->seen_by, points->count * sizeof *seen_by);
    return points->count ? vw_median(seen_by, points->count) : 0;
}
