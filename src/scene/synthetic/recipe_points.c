// Surface points and the views that see them, computed from the depths of the photos.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "image/image.h"
#include "scene/synthetic/recipe_private.h"

static const double DEPTH_AGREES = 0.01; // relative to the distance
enum { CANDIDATES = 4096, TRACK_VIEWS_MIN = 2 };

struct point_maker {
    const struct vw_recipe *recipe;
    const float *depths; // [view][pixel]
    struct vw_scene *scene;
    size_t point_capacity, track_capacity;
};

static const float *depth_at(const struct point_maker *maker, uint32_t view, uint32_t x_px, uint32_t y_px) {
    size_t pixels = (size_t)maker->recipe->width_px * maker->recipe->height_px;
    return &maker->depths[view * pixels + (size_t)y_px * maker->recipe->width_px + x_px];
}

// Computes the point that a view sees at the centre of a pixel; false: none.
static bool point_behind(const struct point_maker *maker, uint32_t view_index, uint32_t x_px, uint32_t y_px,
                         double position[3]) {
    const struct vw_view *view = &maker->scene->views[view_index];
    double direction[3], depth = *depth_at(maker, view_index, x_px, y_px);
    if (depth <= 0 || !vw_camera_unproject(&view->camera, x_px + 0.5, y_px + 0.5, direction)) return false;
    double along = depth / hypot(hypot(direction[0], direction[1]), direction[2]);
    for (int i = 0; i < 3; i++) {
        const double *row = view->camera_to_world[i];
        position[i] = row[3] + along * (row[0] * direction[0] + row[1] * direction[1] + row[2] * direction[2]);
    }
    return true;
}

// Returns whether a view sees a point, and where.
static bool view_sees(const struct point_maker *maker, uint32_t view_index, const double position[3],
                      struct vw_track *track) {
    const struct vw_view *view = &maker->scene->views[view_index];
    double offset[3], direction[3] = {0}, x_px, y_px;
    for (int i = 0; i < 3; i++) offset[i] = position[i] - view->camera_to_world[i][3];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) direction[j] += view->camera_to_world[i][j] * offset[i];
    if (!vw_camera_project(&view->camera, direction, &x_px, &y_px)) return false;
    if (!(x_px >= 0 && x_px < view->camera.width_px && y_px >= 0 && y_px < view->camera.height_px)) return false;
    double distance = hypot(hypot(offset[0], offset[1]), offset[2]);
    if (fabs(*depth_at(maker, view_index, (uint32_t)x_px, (uint32_t)y_px) - distance) > DEPTH_AGREES * distance)
        return false;
    *track = (struct vw_track){.view = view_index, .x_px = (float)x_px, .y_px = (float)y_px};
    return true;
}

// Appends the point and its tracks, unless too few views see it.
static enum vw_status add_point(struct point_maker *maker, const double position[3], const float rgb[3]) {
    struct vw_scene *scene = maker->scene;
    uint32_t first_track = scene->track_count, count = 0;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        struct vw_track track;
        if (maker->recipe->defects[v].kind == VW_DEFECT_WRONG_POSE || !view_sees(maker, v, position, &track)) continue;
        if (vw_grow((void **)&scene->tracks, &maker->track_capacity, first_track + count + 1, sizeof track))
            return VW_ERROR_MEMORY;
        scene->tracks[first_track + count++] = track;
    }
    if (count < TRACK_VIEWS_MIN) return VW_OK;
    if (vw_grow((void **)&scene->points, &maker->point_capacity, scene->point_count + 1, sizeof *scene->points))
        return VW_ERROR_MEMORY;
    struct vw_point *point = &scene->points[scene->point_count++];
    memcpy(point->position_world, position, sizeof point->position_world);
    memcpy(point->rgb, rgb, sizeof point->rgb);
    point->first_track = first_track;
    point->track_count = count;
    scene->track_count += count;
    return VW_OK;
}

static enum vw_status add_points_of_view(struct point_maker *maker, uint32_t view, uint32_t stride_px) {
    for (uint32_t y = stride_px / 2; y < maker->recipe->height_px; y += stride_px)
        for (uint32_t x = stride_px / 2; x < maker->recipe->width_px; x += stride_px) {
            double position[3];
            float rgba[4];
            if (!point_behind(maker, view, x, y, position)) continue;
            vw_image_pixel(&maker->scene->views[view].image, x, y, rgba);
            enum vw_status status = add_point(maker, position, rgba);
            if (status) return status;
        }
    return VW_OK;
}

enum vw_status vw_recipe_make_points(const struct vw_recipe *recipe, const float *depths, struct vw_scene *scene) {
    struct point_maker maker = {.recipe = recipe, .depths = depths, .scene = scene};
    double pixels = (double)recipe->width_px * recipe->height_px * scene->view_count;
    uint32_t stride_px = (uint32_t)ceil(sqrt(pixels / CANDIDATES));
    for (uint32_t v = 0; v < scene->view_count; v++) {
        if (recipe->defects[v].kind) continue; // a corrupted photo has the wrong colours
        enum vw_status status = add_points_of_view(&maker, v, stride_px);
        if (status) return status;
    }
    return VW_OK;
}
