#include "run/recorded/export_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/csv.h"
#include "base/file.h"
#include "base/json.h"
#include "base/memory.h"
#include "run/out_folder.h"
#include "run/recorded/recorded_run.h"
#include "scene/formats/ply.h"
#include "scene/formats/transforms.h"
#include "viewworth/value.h"

struct export {
    struct vw_recorded_run run;
    struct vw_camera_pyramid *cameras; // owned, by view
    double *scores;                    // owned, by view; NaN: the photo is not valued
    const char *method;
};

// ---- Colours -------------------------------------------------------------------------------------------------------

static void colour_cameras(struct export *export, uint32_t count) {
    for (uint32_t v = 0; v < count; v++) {
        uint32_t below = 0, others = 0;
        for (uint32_t w = 0; w < count; w++) {
            below += export->scores[w] < export->scores[v];
            others += w != v && !isnan(export->scores[w]);
        }
        if (!isnan(export->scores[v])) vw_rank_colour(others ? (double)below / others : 1, export->cameras[v].rgb);
    }
}

static enum vw_status read_scores(struct export *export) {
    struct vw_ledger_score *scores = NULL;
    uint32_t score_count = 0, count = export->run.scene->view_count;
    export->cameras = vw_allocate(count, sizeof *export->cameras);
    export->scores = vw_allocate(count, sizeof *export->scores);
    if (!export->cameras || !export->scores) return VW_ERROR_MEMORY;
    for (uint32_t v = 0; v < count; v++) {
        export->cameras[v] = (struct vw_camera_pyramid){&export->run.scene->views[v], {128, 128, 128}};
        export->scores[v] = NAN;
    }
    enum vw_status status = vw_ledger_get_scores(export->run.ledger, &scores, &score_count);
    if (status) return status;
    export->method = vw_value_method_find(vw_value_main_method(scores, score_count))->name;
    for (uint32_t i = 0; i < score_count; i++)
        if (scores[i].image_id < count && !strcmp(scores[i].method, export->method))
            export->scores[scores[i].image_id] = scores[i].value;
    free(scores);
    colour_cameras(export, count);
    return VW_OK;
}

// ---- Files ---------------------------------------------------------------------------------------------------------

static json_t *camera_to_json(const struct vw_camera_pyramid *camera, double score) {
    const struct vw_view *view = camera->view;
    return json_pack("{s:s, s:s, s:o, s:[fff], s:o, s:[ff], s:[ff], s:[ii], s:[iii]}", "name", view->name, "split",
                     vw_split_name(view->split), "score", vw_json_real(score), "position", view->camera_to_world[0][3],
                     view->camera_to_world[1][3], view->camera_to_world[2][3], "camera_to_world",
                     vw_pose_to_json(view->camera_to_world), "focal_px", view->camera.focal_x_px,
                     view->camera.focal_y_px, "centre_px", view->camera.centre_x_px, view->camera.centre_y_px,
                     "size_px", (int)view->camera.width_px, (int)view->camera.height_px, "colour", (int)camera->rgb[0],
                     (int)camera->rgb[1], (int)camera->rgb[2]);
}

static enum vw_status write_cameras(const struct export *export, const char *path) {
    const struct vw_scene *scene = export->run.scene;
    const struct vw_camera_pyramids pyramids = {export->cameras, scene->view_count, vw_camera_pyramid_depth(scene)};
    if (vw_path_ends_with(path, ".ply")) return vw_csv_write_file(path, vw_ply_print_cameras, &pyramids);
    json_t *root = json_object(), *cameras = json_array();
    for (uint32_t v = 0; v < scene->view_count; v++)
        vw_json_append(&cameras, camera_to_json(&export->cameras[v], export->scores[v]));
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
    free(export.scores);
    vw_recorded_close(&export.run);
    return status;
}

enum vw_status vw_export_scene(const struct vw_export_params *params, struct vw_export *exported) {
    struct vw_out_lock *lock = NULL;
    enum vw_status status = vw_out_check_target("cameras", params->cameras, params->out, true);
    if (!status) status = vw_out_check_target("points", params->points, params->out, false);
    if (!status && !params->cameras && !params->points)
        status = vw_fail(VW_ERROR_USAGE, "export: give --cameras FILE, --points FILE or both");
    if (!status && params->cameras) status = vw_out_lock_take_for(params->cameras, &params->out, 1, &lock);
    if (!status && params->points && !lock) status = vw_out_lock_take_for(params->points, &params->out, 1, &lock);
    if (!status) status = write_locked(params, exported);
    vw_out_lock_release(&lock);
    return status;
}
