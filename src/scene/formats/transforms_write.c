// Writes transforms.json with nerfstudio's conventions, as transforms_json.c reads it.
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/json.h"
#include "base/memory.h"
#include "scene/formats/scene_copy.h"
#include "scene/formats/transforms.h"
#include "viewworth/log.h"

static const char *model_name(const struct vw_camera *camera) {
    if (camera->lens == VW_LENS_FISHEYE) return "OPENCV_FISHEYE";
    return camera->k4 != 0 || camera->k5 != 0 || camera->k6 != 0 ? "FULL_OPENCV" : "OPENCV";
}

static void set_camera(json_t **object, const struct vw_camera *camera) {
    const struct {
        const char *key;
        double value;
    } numbers[] = {{"fl_x", camera->focal_x_px}, {"fl_y", camera->focal_y_px}, {"cx", camera->centre_x_px},
                   {"cy", camera->centre_y_px},  {"k1", camera->k1},           {"k2", camera->k2},
                   {"k3", camera->k3},           {"p1", camera->p1},           {"p2", camera->p2},
                   {"k4", camera->k4},           {"k5", camera->k5},           {"k6", camera->k6}};
    vw_json_set(object, "camera_model", json_string(model_name(camera)));
    vw_json_set(object, "w", json_integer(camera->width_px));
    vw_json_set(object, "h", json_integer(camera->height_px));
    for (size_t i = 0; i < VW_ARRAY_COUNT(numbers); i++)
        if (i < 4 || numbers[i].value != 0) vw_json_set(object, numbers[i].key, json_real(numbers[i].value));
}

json_t *vw_pose_to_json(const double camera_to_world[3][4]) {
    json_t *rows = json_array();
    for (int i = 0; i < 3; i++)
        vw_json_append(&rows, json_pack("[ffff]", camera_to_world[i][0], camera_to_world[i][1], camera_to_world[i][2],
                                        camera_to_world[i][3]));
    vw_json_append(&rows, json_pack("[ffff]", 0.0, 0.0, 0.0, 1.0));
    return rows;
}

// Warns if nerfstudio would read other lenses, or none.
static void warn_of_lenses(const struct vw_scene *scene) {
    const char *shared = model_name(&scene->views[0].camera);
    bool fits = strcmp(shared, "FULL_OPENCV") != 0;
    for (uint32_t v = 1; v < scene->view_count; v++) fits &= !strcmp(shared, model_name(&scene->views[v].camera));
    if (!fits)
        vw_log_warning("nerfstudio has no FULL_OPENCV and one camera_model for all photos; give it sparse/0 of the "
                       "copy, not transforms.json");
}

json_t *vw_transforms_frame_to_json(const struct vw_view *view, const char *name, const char *mask, bool own_camera) {
    json_t *frame =
        json_pack("{s:s, s:o}", "file_path", name, "transform_matrix", vw_pose_to_json(view->camera_to_world));
    if (mask) vw_json_set(&frame, "mask_path", json_string(mask));
    if (own_camera) set_camera(&frame, &view->camera);
    return frame;
}

enum vw_status vw_transforms_write(const struct vw_scene *scene, char *const *masks, const char *folder) {
    json_t *file = json_object(), *frames = json_array(), *splits[VW_SPLIT_EXCLUDED];
    bool shared = true;
    for (uint32_t v = 1; v < scene->view_count; v++)
        shared &= vw_camera_same(&scene->views[0].camera, &scene->views[v].camera);
    for (enum vw_split split = 0; split < VW_SPLIT_EXCLUDED; split++) splits[split] = json_array();
    for (uint32_t v = 0; v < scene->view_count; v++) {
        char *name = vw_format_text("images/%s", scene->views[v].name);
        vw_json_append(&frames, name ? vw_transforms_frame_to_json(&scene->views[v], name, masks[v], !shared) : NULL);
        vw_json_append(&splits[scene->views[v].split], name ? json_string(name) : NULL);
        free(name);
    }
    if (shared) set_camera(&file, &scene->views[0].camera);
    else vw_json_set(&file, "camera_model", json_string(model_name(&scene->views[0].camera)));
    if (scene->point_count) vw_json_set(&file, "ply_file_path", json_string("points.ply"));
    for (enum vw_split split = 0; split < VW_SPLIT_EXCLUDED; split++)
        vw_json_set(&file, vw_transforms_split_key(split), splits[split]);
    vw_json_set(&file, "frames", frames);
    char *path = vw_path_join(folder, "transforms.json");
    warn_of_lenses(scene);
    enum vw_status status = vw_json_write_file(path, file);
    free(path);
    return status;
}
