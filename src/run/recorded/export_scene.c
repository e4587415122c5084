#include "run/recorded/export_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/csv.h"
#include "base/file.h"
#include "base/json.h"
#include "base/memory.h"
#include "run/out_lock.h"
#include "run/recorded/recorded_run.h"
#include "scene/formats/points_ply.h"
#include "viewworth/value.h"

#define FRUSTUM_SHARE 0.06 // depth of a camera's pyramid, of the mean distance of cameras from their centre

struct camera {
    double score; // NaN: the photo is not valued
    uint32_t rgb[3];
};

struct export {
    struct vw_recorded_run run;
    struct camera *cameras; // owned, by view
    const char *method;
};

static enum vw_status check_target(const char *option, const char *path, bool json) {
    if (!path) return VW_OK;
    if (!vw_path_ends_with(path, ".ply") && !(json && vw_path_ends_with(path, ".json")))
        return vw_fail(VW_ERROR_USAGE, "--%s %s: the name must end in .ply%s", option, path, json ? " or .json" : "");
    if (!vw_file_exists(path) && !vw_folder_exists(path)) return VW_OK;
    return vw_fail(VW_ERROR_USAGE, "--%s %s: exists; name a new file, or remove that one", option, path);
}

// ---- Colours -------------------------------------------------------------------------------------------------------

// Colours by rank, from violet (least) over green to yellow (most): outliers would leave one colour for all others.
static void colour(double share, uint32_t rgb[3]) {
    static const double anchors[3][3] = {{68, 1, 84}, {33, 145, 140}, {253, 231, 37}};
    int low = share < 0.5 ? 0 : 1;
    for (int c = 0; c < 3; c++)
        rgb[c] = (uint32_t)lround(anchors[low][c] + (2 * share - low) * (anchors[low + 1][c] - anchors[low][c]));
}

static void colour_cameras(struct export *export, uint32_t count) {
    for (uint32_t v = 0; v < count; v++) {
        uint32_t below = 0, others = 0;
        for (uint32_t w = 0; w < count; w++) {
            below += export->cameras[w].score < export->cameras[v].score;
            others += w != v && !isnan(export->cameras[w].score);
        }
        if (!isnan(export->cameras[v].score)) colour(others ? (double)below / others : 1, export->cameras[v].rgb);
    }
}

static enum vw_status read_scores(struct export *export) {
    struct vw_ledger_score *scores = NULL;
    uint32_t score_count = 0, count = export->run.scene->view_count;
    export->cameras = vw_allocate(count, sizeof *export->cameras);
    if (!export->cameras) return VW_ERROR_MEMORY;
    for (uint32_t v = 0; v < count; v++) export->cameras[v] = (struct camera){NAN, {128, 128, 128}};
    enum vw_status status = vw_ledger_get_scores(export->run.ledger, &scores, &score_count);
    if (status) return status;
    export->method = vw_value_method_find(vw_value_main_method(scores, score_count))->name;
    for (uint32_t i = 0; i < score_count; i++)
        if (scores[i].image_id < count && !strcmp(scores[i].method, export->method))
            export->cameras[scores[i].image_id].score = scores[i].value;
    free(scores);
    colour_cameras(export, count);
    return VW_OK;
}

// ---- Files ---------------------------------------------------------------------------------------------------------

static double frustum_depth(const struct vw_scene *scene) {
    double mean[3] = {0}, distance = 0, count = scene->view_count;
    for (uint32_t v = 0; v < scene->view_count; v++)
        for (int axis = 0; axis < 3; axis++) mean[axis] += scene->views[v].camera_to_world[axis][3] / count;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        const double(*pose)[4] = scene->views[v].camera_to_world;
        distance += hypot(hypot(pose[0][3] - mean[0], pose[1][3] - mean[1]), pose[2][3] - mean[2]) / count;
    }
    return FRUSTUM_SHARE * (distance > 0 ? distance : scene->box.half_extent_world);
}

// Prints the corner (x, y) of the image, in photo sizes, at a depth; depth 0 is the centre.
static void print_corner(FILE *stream, const struct vw_view *view, const int at[2], double depth,
                         const uint32_t rgb[3]) {
    const struct vw_camera *camera = &view->camera;
    double world[3],
        direction[3] = {(at[0] * (double)camera->width_px - camera->centre_x_px) / camera->focal_x_px,
                        (camera->centre_y_px - at[1] * (double)camera->height_px) / camera->focal_y_px, -1};
    for (int axis = 0; axis < 3; axis++) {
        const double *row = view->camera_to_world[axis];
        world[axis] = row[3] + depth * (row[0] * direction[0] + row[1] * direction[1] + row[2] * direction[2]);
    }
    vw_ply_print_vertex(stream, world, rgb);
}

static void print_cameras(FILE *stream, const void *context) {
    static const int corners[5][2] = {{0, 0}, {0, 0}, {1, 0}, {1, 1}, {0, 1}};
    static const uint32_t faces[6][3] = {{0, 2, 1}, {0, 3, 2}, {0, 4, 3}, {0, 1, 4}, {1, 2, 3}, {1, 3, 4}};
    const struct export *export = context;
    const struct vw_scene *scene = export->run.scene;
    double depth = frustum_depth(scene);
    fprintf(stream, "ply\nformat ascii 1.0\nelement vertex %u\n%s", 5 * scene->view_count, vw_ply_vertex_properties);
    fprintf(stream, "element face %u\nproperty list uchar int vertex_indices\nend_header\n", 6 * scene->view_count);
    for (uint32_t v = 0; v < scene->view_count; v++)
        for (int k = 0; k < 5; k++)
            print_corner(stream, &scene->views[v], corners[k], k ? depth : 0, export->cameras[v].rgb);
    for (uint32_t v = 0; v < scene->view_count; v++)
        for (int f = 0; f < 6; f++)
            vw_csv_print(stream, "3 u u u\n", 5 * v + faces[f][0], 5 * v + faces[f][1], 5 * v + faces[f][2]);
}

static json_t *camera_to_json(const struct vw_view *view, const struct camera *camera) {
    json_t *pose = json_array();
    for (int row = 0; row < 4; row++) {
        json_t *numbers = json_array();
        for (int k = 0; k < 4; k++)
            vw_json_append(&numbers, vw_json_real(row < 3 ? view->camera_to_world[row][k] : k == 3));
        vw_json_append(&pose, numbers);
    }
    return json_pack("{s:s, s:s, s:o, s:[fff], s:o, s:[ff], s:[ff], s:[ii], s:[iii]}", "name", view->name, "split",
                     vw_split_name(view->split), "score", vw_json_real(camera->score), "position",
                     view->camera_to_world[0][3], view->camera_to_world[1][3], view->camera_to_world[2][3],
                     "camera_to_world", pose, "focal_px", view->camera.focal_x_px, view->camera.focal_y_px, "centre_px",
                     view->camera.centre_x_px, view->camera.centre_y_px, "size_px", (int)view->camera.width_px,
                     (int)view->camera.height_px, "colour", (int)camera->rgb[0], (int)camera->rgb[1],
                     (int)camera->rgb[2]);
}

static enum vw_status write_cameras(const struct export *export, const char *path) {
    if (vw_path_ends_with(path, ".ply")) return vw_csv_write_file(path, print_cameras, export);
    json_t *root = json_object(), *cameras = json_array();
    for (uint32_t v = 0; v < export->run.scene->view_count; v++)
        vw_json_append(&cameras, camera_to_json(&export->run.scene->views[v], &export->cameras[v]));
    vw_json_set(&root, "method", json_string(export->method));
    vw_json_set(&root, "cameras", cameras);
    return vw_json_write_file(path, root);
}

static enum vw_status check_points(const struct vw_export_params *params, const struct vw_scene *scene) {
    if (!params->points || scene->point_count) return VW_OK;
    return vw_fail(VW_ERROR_INPUT, "--points: %s has no points from structure from motion; a COLMAP model has them",
                   scene->path);
}

static enum vw_status write_locked(const struct vw_export_params *params, struct vw_export *exported) {
    struct export export = {0};
    enum vw_status status = vw_recorded_open(params->out, &export.run);
    if (!status) status = vw_recorded_open_scene(&export.run, params->device);
    if (!status) status = vw_recorded_check_images(&export.run);
    if (!status) status = check_points(params, export.run.scene);
    if (!status) status = read_scores(&export);
    if (!status && params->cameras) status = write_cameras(&export, params->cameras);
    if (!status && params->points) status = vw_csv_write_file(params->points, vw_ply_print_points, export.run.scene);
    if (!status)
        *exported = (struct vw_export){export.method, export.run.scene->view_count, export.run.scene->point_count};
    free(export.cameras);
    vw_recorded_close(&export.run);
    return status;
}

enum vw_status vw_export_scene(const struct vw_export_params *params, struct vw_export *exported) {
    struct vw_out_lock *lock = NULL;
    enum vw_status status = check_target("cameras", params->cameras, true);
    if (!status) status = check_target("points", params->points, false);
    if (!status && !params->cameras && !params->points)
        status = vw_fail(VW_ERROR_USAGE, "export: give --cameras FILE, --points FILE or both");
    if (!status && params->cameras) status = vw_out_lock_take_for(params->cameras, &params->out, 1, &lock);
    if (!status && params->points && !lock) status = vw_out_lock_take_for(params->points, &params->out, 1, &lock);
    if (!status) status = write_locked(params, exported);
    vw_out_lock_release(&lock);
    return status;
}
