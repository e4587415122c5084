// Writes a COLMAP model, as colmap_files.c reads it.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/csv.h"
#include "base/memory.h"
#include "scene/builder.h"
#include "scene/formats/colmap_builder.h"
#include "scene/formats/ply.h"
#include "scene/formats/scene_copy.h"

// A point that an image shows.
struct feature {
    uint32_t track, point;
};

struct model {
    const struct vw_scene *scene;
    uint32_t *cameras; // owned; per view: the first one with the same camera
    uint32_t camera_count;
    uint32_t *first_features; // owned; per view, and one more: its range in features
    struct feature *features; // owned; by view, then by point
    uint32_t *places;         // owned; of each track among the features of its view
};

static void put(FILE *stream, const void *value, size_t size_bytes) { (void)fwrite(value, size_bytes, 1, stream); }
static void put_u32(FILE *stream, uint32_t value) { put(stream, &value, sizeof value); }
static void put_u64(FILE *stream, uint64_t value) { put(stream, &value, sizeof value); }
static void put_real(FILE *stream, double value) { put(stream, &value, sizeof value); }

// ---- Cameras ----

static void print_cameras(FILE *stream, const void *context) {
    const struct model *model = context;
    put_u64(stream, model->camera_count);
    for (uint32_t v = 0; v < model->scene->view_count; v++) {
        const struct vw_camera *camera = &model->scene->views[v].camera;
        double params[COLMAP_PARAMS_MAX];
        int32_t id;
        if (model->cameras[v] != v) continue;
        uint32_t param_count = colmap_camera_params(camera, &id, params);
        put_u32(stream, v + 1);
        put(stream, &id, sizeof id);
        put_u64(stream, camera->width_px);
        put_u64(stream, camera->height_px);
        put(stream, params, param_count * sizeof *params);
    }
}

// ---- Images ----

// Inverts a pose and turns its axes from OpenGL's to COLMAP's.
static void put_pose(FILE *stream, const double camera_to_world[3][4]) {
    double pose[3][4] = {{0}}, quaternion[4];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            pose[i][j] = i == 0 ? camera_to_world[j][i] : -camera_to_world[j][i];
            pose[i][3] -= pose[i][j] * camera_to_world[j][3];
        }
    vw_pose_quaternion(pose, quaternion);
    put(stream, quaternion, sizeof quaternion);
    for (int i = 0; i < 3; i++) put_real(stream, pose[i][3]);
}

static void print_images(FILE *stream, const void *context) {
    const struct model *model = context;
    put_u64(stream, model->scene->view_count);
    for (uint32_t v = 0; v < model->scene->view_count; v++) {
        const struct vw_view *view = &model->scene->views[v];
        put_u32(stream, v + 1);
        put_pose(stream, view->camera_to_world);
        put_u32(stream, model->cameras[v] + 1);
        put(stream, view->name, strlen(view->name) + 1);
        put_u64(stream, model->first_features[v + 1] - model->first_features[v]);
        for (uint32_t f = model->first_features[v]; f < model->first_features[v + 1]; f++) {
            const struct vw_track *track = &model->scene->tracks[model->features[f].track];
            put_real(stream, track->x_px);
            put_real(stream, track->y_px);
            put_u64(stream, model->features[f].point + UINT64_C(1));
        }
    }
}

// ---- Points ----

// Returns how far from the point's image the view sees it; NaN if it is behind the camera.
static double error_px(const struct vw_view *view, const double position_world[3], const struct vw_track *track) {
    double direction[3] = {0}, x_px, y_px;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            direction[i] += view->camera_to_world[j][i] * (position_world[j] - view->camera_to_world[j][3]);
    if (!vw_camera_project(&view->camera, direction, &x_px, &y_px)) return NAN;
    return hypot(x_px - track->x_px, y_px - track->y_px);
}

static void print_points(FILE *stream, const void *context) {
    const struct model *model = context;
    const struct vw_scene *scene = model->scene;
    put_u64(stream, scene->point_count);
    for (uint32_t p = 0; p < scene->point_count; p++) {
        const struct vw_point *point = &scene->points[p];
        const struct vw_track *tracks = &scene->tracks[point->first_track];
        uint32_t rgb[3];
        double error = 0;
        for (uint32_t t = 0; t < point->track_count; t++)
            error += error_px(&scene->views[tracks[t].view], point->position_world, &tracks[t]) / point->track_count;
        vw_point_rgb(point, rgb);
        put_u64(stream, p + UINT64_C(1));
        put(stream, point->position_world, sizeof point->position_world);
        for (int c = 0; c < 3; c++) (void)fputc((int)rgb[c], stream);
        put_real(stream, isfinite(error) ? error : -1); // -1: unknown
        put_u64(stream, point->track_count);
        for (uint32_t t = 0; t < point->track_count; t++) {
            put_u32(stream, tracks[t].view + 1);
            put_u32(stream, model->places[point->first_track + t]);
        }
    }
}

// ---- The model ----

static void find_cameras(struct model *model) {
    const struct vw_view *views = model->scene->views;
    for (uint32_t v = 0; v < model->scene->view_count; v++) {
        uint32_t same = 0;
        while (!vw_camera_same(&views[same].camera, &views[v].camera)) same++;
        model->cameras[v] = same;
        model->camera_count += same == v;
    }
}

static void list_features(struct model *model) {
    const struct vw_scene *scene = model->scene;
    uint32_t *ends = model->first_features + 1; // ends of the views' features; their counts at first
    for (uint32_t t = 0; t < scene->track_count; t++) model->places[t] = ends[scene->tracks[t].view]++;
    for (uint32_t v = 1; v < scene->view_count; v++) ends[v] += ends[v - 1];
    for (uint32_t p = 0; p < scene->point_count; p++)
        for (uint32_t k = 0; k < scene->points[p].track_count; k++) {
            uint32_t track = scene->points[p].first_track + k, first = model->first_features[scene->tracks[track].view];
            model->features[first + model->places[track]] = (struct feature){track, p};
        }
}

static enum vw_status write_file(const struct model *model, const char *folder, const char *name,
                                 vw_csv_printer *print) {
    char *path = vw_format_text("%s/%s.bin", folder, name);
    enum vw_status status = path ? vw_csv_write_file(path, print, model) : VW_ERROR_MEMORY;
    free(path);
    return status;
}

enum vw_status vw_colmap_write(const struct vw_scene *scene, const char *folder) {
    struct model model = {
        .scene = scene,
        .cameras = vw_allocate(scene->view_count, sizeof *model.cameras),
        .first_features = vw_allocate(scene->view_count + UINT64_C(1), sizeof *model.first_features),
        .features = vw_allocate(scene->track_count, sizeof *model.features),
        .places = vw_allocate(scene->track_count, sizeof *model.places),
    };
    enum vw_status status = VW_ERROR_MEMORY;
    if (model.cameras && model.first_features && model.features && model.places) {
        find_cameras(&model);
        list_features(&model);
        status = write_file(&model, folder, "cameras", print_cameras);
    }
    if (!status) status = write_file(&model, folder, "images", print_images);
    if (!status) status = write_file(&model, folder, "points3D", print_points);
    free(model.cameras);
    free(model.first_features);
    free(model.features);
    free(model.places);
    return status;
}
