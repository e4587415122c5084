#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/json.h"
#include "base/memory.h"
#include "scene/builder.h"
#include "scene/formats/scene_copy.h"
#include "scene/formats/transforms.h"
#include "viewworth/log.h"

// The keys of intrinsics: k1 to k6, then p1 and p2, follow K1.
enum key { FL_X, FL_Y, FOV_X, FOV_Y, ANGLE_X, ANGLE_Y, CX, CY, WIDTH, HEIGHT, K1, P1 = K1 + 6, KEY_COUNT = P1 + 2 };
static const char *const key_names[KEY_COUNT] = {
    "fl_x", "fl_y", "x_fov", "y_fov", "camera_angle_x", "camera_angle_y", "cx", "cy", "w", "h", "k1", "k2", "k3", "k4",
    "k5",   "k6",   "p1",    "p2"};

static const char *const refused_keys[] = {"latlong",   "orthographic", "equirectangular", "rolling_shutter",
                                           "ftheta_p0", "ftheta_p1",    "ftheta_p2",       "ftheta_p3",
                                           "ftheta_p4", "from_mitsuba"};

// The distortion params of each camera model. OPENCV, as these files use it, and files without a model have the k1 to
// k3 of a polynomial. A k4 is refused there: it could belong to that polynomial or to FULL_OPENCV's denominator.
static const struct vw_model {
    const char *name;
    enum vw_lens lens;
    uint32_t radial_count; // k1, k2, ...
    bool tangential;       // p1 and p2
} models[] = {
    {"OPENCV", VW_LENS_POLYNOMIAL, 3, true}, // also for files without a model
    {"OPENCV_FISHEYE", VW_LENS_FISHEYE, 4, false},    {"FULL_OPENCV", VW_LENS_POLYNOMIAL, 6, true},
    {"SIMPLE_PINHOLE", VW_LENS_POLYNOMIAL, 0, false}, {"PINHOLE", VW_LENS_POLYNOMIAL, 0, false},
    {"SIMPLE_RADIAL", VW_LENS_POLYNOMIAL, 1, false},  {"RADIAL", VW_LENS_POLYNOMIAL, 2, false},
};
enum { MODEL_OPENCV, MODEL_OPENCV_FISHEYE };

static const double NUMBER_LIMIT = VW_FOCAL_MOST_PX; // for every field, so that products are precise in 32-bit floats

static bool is_set(const json_t *value) {
    if (json_is_number(value)) return json_number_value(value) != 0;
    if (!json_is_array(value)) return value && !json_is_false(value) && !json_is_null(value);
    for (size_t i = 0; i < json_array_size(value); i++)
        if (is_set(json_array_get(value, i))) return true;
    return false;
}

enum vw_status vw_transforms_refuse_unknown(const char *where, const json_t *object) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(refused_keys); i++)
        if (is_set(json_object_get(object, refused_keys[i])))
            return vw_fail(
                VW_ERROR_INPUT,
                "%s: field %s is not supported; undistort the photos to a pinhole or OPENCV k1 k2 p1 p2 camera", where,
                refused_keys[i]);
    return VW_OK;
}

// Reads the model that an object names; leaves `*model` unchanged if it names none.
static enum vw_status read_model(const char *where, const json_t *object, const struct vw_model **model) {
    const json_t *given = json_object_get(object, "camera_model");
    const char *name = json_string_value(given);
    bool fisheye = is_set(json_object_get(object, "is_fisheye"));
    const struct vw_model *found = fisheye ? &models[MODEL_OPENCV_FISHEYE] : NULL;
    if (is_set(given)) {
        found = NULL;
        for (size_t i = 0; name && i < VW_ARRAY_COUNT(models); i++)
            if (!strcmp(name, models[i].name)) found = &models[i];
        if (!found)
            return vw_fail(
                VW_ERROR_INPUT,
                "%s: field camera_model: %s is not supported; undistort the photos to a PINHOLE or OPENCV camera",
                where, name ? name : "this value");
    }
    if (fisheye && found->lens != VW_LENS_FISHEYE)
        return vw_fail(VW_ERROR_INPUT, "%s: field is_fisheye contradicts camera_model %s; keep the right one", where,
                       found->name);
    if (found) *model = found;
    return VW_OK;
}

// Reads the intrinsics in an object; NaN: missing.
static enum vw_status read_keys(const char *where, const json_t *object, double values[KEY_COUNT]) {
    for (int key = 0; key < KEY_COUNT; key++) {
        const json_t *value = json_object_get(object, key_names[key]);
        if (value && !json_is_null(value) && !json_is_number(value))
            return vw_fail(VW_ERROR_INPUT, "%s: field %s is not a number; give a number or leave it out", where,
                           key_names[key]);
        values[key] = json_is_number(value) ? json_number_value(value) : NAN;
    }
    return VW_OK;
}

static enum vw_status check_range(const char *where, enum key key, double value, double above, double below) {
    if (isnan(value) || (value > above && value < below)) return VW_OK;
    return vw_fail(VW_ERROR_INPUT, "%s: field %s is %g; it must be above %g and below %g", where, key_names[key], value,
                   above, below);
}

static enum vw_status check_keys(const char *where, const double values[KEY_COUNT]) {
    enum vw_status status = VW_OK;
    for (enum key key = 0; !status && key < KEY_COUNT; key++)
        status = check_range(where, key, values[key], -NUMBER_LIMIT, NUMBER_LIMIT);
    const struct {
        enum key key; // key of the x axis; that of the y axis follows
        double below;
    } positive[] = {{FL_X, NUMBER_LIMIT}, {FOV_X, 180}, {ANGLE_X, M_PI}, {WIDTH, NUMBER_LIMIT}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(positive); i++)
        for (enum key key = positive[i].key; !status && key <= positive[i].key + 1; key++)
            status = check_range(where, key, values[key], 0, positive[i].below);
    return status;
}

static double first_known(double first, double second) { return isnan(first) ? second : first; }

// Returns the focal length in pixels of an image that is `scale` times as large as fields w and h; NaN if the object
// has none for this axis. A focal length overrides an angle.
static double focal_px(const double values[KEY_COUNT], enum key axis, double side_px, double scale) {
    double from_fov = 0.5 * side_px / tan(0.5 * values[FOV_X + axis] * M_PI / 180);
    double from_angle = 0.5 * side_px / tan(0.5 * values[ANGLE_X + axis]);
    return first_known(values[FL_X + axis] * scale, first_known(from_fov, from_angle));
}

// Prefers the frame's keys, then the file's, then defaults.
static struct vw_camera combine(const double file[KEY_COUNT], const double frame[KEY_COUNT],
                                const double given[KEY_COUNT], uint32_t width_px, uint32_t height_px, double scale) {
    double focal_x = first_known(focal_px(frame, 0, width_px, scale), focal_px(file, 0, width_px, scale));
    double focal_y = first_known(focal_px(frame, 1, height_px, scale), focal_px(file, 1, height_px, scale));
    struct vw_camera camera = {.width_px = width_px,
                               .height_px = height_px,
                               .focal_x_px = first_known(focal_x, focal_y),
                               .focal_y_px = first_known(focal_y, focal_x),
                               .centre_x_px = first_known(given[CX] * scale, 0.5 * width_px),
                               .centre_y_px = first_known(given[CY] * scale, 0.5 * height_px)};
    double *const distortion[] = {&camera.k1, &camera.k2, &camera.k3, &camera.k4,
                                  &camera.k5, &camera.k6, &camera.p1, &camera.p2};
    for (size_t i = 0; i < VW_ARRAY_COUNT(distortion); i++) *distortion[i] = first_known(given[K1 + i], 0);
    return camera;
}

static enum vw_status check_distortion(const char *where, const double given[KEY_COUNT], const struct vw_model *model) {
    for (enum key key = K1; key < KEY_COUNT; key++)
        if (!isnan(given[key]) && given[key] != 0 && !(key < P1 ? key < K1 + model->radial_count : model->tangential))
            return vw_fail(
                VW_ERROR_INPUT,
                "%s: field %s is not supported with camera_model %s; set it to 0, name the right model, or undistort "
                "the photos",
                where, key_names[key], model->name);
    return VW_OK;
}

// Finds the size of the image relative to fields w and h, which must have its shape.
static enum vw_status find_scale(const char *where, double given_width_px, double given_height_px, uint32_t width_px,
                                 uint32_t height_px, double *scale) {
    *scale = first_known(width_px / given_width_px, first_known(height_px / given_height_px, 1));
    if (isnan(given_width_px) || isnan(given_height_px) || given_width_px * height_px == given_height_px * width_px)
        return VW_OK;
    return vw_fail(VW_ERROR_INPUT,
                   "%s: fields w and h say %g x %g pixels but the image has %u x %u; correct them or the image", where,
                   given_width_px, given_height_px, width_px, height_px);
}

enum vw_status vw_transforms_camera(const char *where, const json_t *file, const json_t *frame, uint32_t width_px,
                                    uint32_t height_px, struct vw_camera *camera, bool *rescaled) {
    double of_file[KEY_COUNT], of_frame[KEY_COUNT], given[KEY_COUNT], scale = 1;
    const struct vw_model *model = &models[MODEL_OPENCV];
    enum vw_status status = read_model(where, file, &model);
    if (!status) status = read_model(where, frame, &model); // the frame overrides the file
    if (!status) status = read_keys(where, file, of_file);
    if (!status) status = read_keys(where, frame, of_frame);
    if (!status) status = check_keys(where, of_file);
    if (!status) status = check_keys(where, of_frame);
    if (status) return status;
    for (int key = 0; key < KEY_COUNT; key++) given[key] = first_known(of_frame[key], of_file[key]);
    status = check_distortion(where, given, model);
    if (!status) status = find_scale(where, given[WIDTH], given[HEIGHT], width_px, height_px, &scale);
    if (status) return status;
    struct vw_camera combined = combine(of_file, of_frame, given, width_px, height_px, scale);
    if (isnan(combined.focal_x_px))
        return vw_fail(VW_ERROR_INPUT, "%s: no focal length; give one of the fields fl_x, camera_angle_x, x_fov",
                       where);
    status = vw_camera_check(where, "fields fl_x, fl_y, w, h and angles", &combined);
    if (status) return status;
    combined.lens = model->lens;
    *camera = combined;
    *rescaled = scale != 1;
    return VW_OK;
}

// ---- The pose ------------------------------------------------------------------------------------------------------

static const double TOLERANCE = 1e-3; // poses are often written with few digits
enum { POLAR_STEPS = 3 };             // errors from 1e-3: 1e-6, 1e-12, exact
static const double POSITION_LIMIT_WORLD = VW_POSITION_MOST_WORLD;

static enum vw_status read_matrix(const char *where, const json_t *value, double matrix[4][4]) {
    size_t rows = json_array_size(value); // 0 for anything but an array
    bool complete = rows == 3 || rows == 4;
    for (size_t i = 0; complete && i < rows; i++) {
        const json_t *row = json_array_get(value, i);
        complete = json_array_size(row) == 4;
        for (size_t j = 0; complete && j < 4; j++) {
            complete = json_is_number(json_array_get(row, j));
            matrix[i][j] = json_number_value(json_array_get(row, j));
        }
    }
    if (complete) return VW_OK;
    return vw_fail(VW_ERROR_INPUT,
                   "%s: field transform_matrix is missing or not 4 rows of 4 numbers; export the pose again", where);
}

// Returns the largest deviation of the columns, divided by `scale`, from orthonormality.
static double distance_from_rotation(double m[4][4], double scale) {
    double worst = 0;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            double product = 0;
            for (int k = 0; k < 3; k++) product += m[k][i] / scale * (m[k][j] / scale);
            worst = fmax(worst, fabs(product - (i == j)));
        }
    }
    return worst;
}

// Replaces a matrix that is almost a rotation by the nearest rotation, by Newton's iteration for the polar
// decomposition: R = (R + inverse transpose of R) / 2. Otherwise, the rounding of a matrix with few digits would
// distort rays, and other exports of the same pose would give other rays.
static void make_rotation(double m[4][4], double scale) {
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) m[i][j] /= scale;
    for (int step = 0; step < POLAR_STEPS; step++) {
        double cofactors[3][3], divisor = vw_determinant(m[0], m[1], m[2]);
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) {
                int below = (i + 1) % 3, last = (i + 2) % 3, right = (j + 1) % 3, end = (j + 2) % 3;
                cofactors[i][j] = m[below][right] * m[last][end] - m[below][end] * m[last][right];
            }
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) m[i][j] = 0.5 * (m[i][j] + cofactors[i][j] / divisor);
    }
}

static enum vw_status check_matrix(const char *where, const char *field, double m[4][4], double *scale) {
    const double last_row[4] = {0, 0, 0, 1};
    for (int j = 0; j < 4; j++)
        if (fabs(m[3][j] - last_row[j]) > TOLERANCE)
            return vw_fail(VW_ERROR_INPUT, "%s: %s: last row is not 0 0 0 1; give camera to world", where, field);
    for (int i = 0; i < 3; i++)
        if (!(fabs(m[i][3]) <= POSITION_LIMIT_WORLD))
            return vw_fail(VW_ERROR_INPUT, "%s: %s: position %g is beyond %g; correct the pose", where, field, m[i][3],
                           POSITION_LIMIT_WORLD);
    *scale = cbrt(vw_determinant(m[0], m[1], m[2]));
    if (*scale < 0)
        return vw_fail(VW_ERROR_INPUT, "%s: %s: mirrored (negative determinant); give right-handed OpenGL axes", where,
                       field);
    if (!(*scale > 0 && isfinite(*scale)) || !(distance_from_rotation(m, *scale) <= TOLERANCE))
        return vw_fail(VW_ERROR_INPUT, "%s: %s: its 3 x 3 part is not a rotation; export the pose again", where, field);
    return VW_OK;
}

enum vw_status vw_pose_of_matrix(const char *where, const char *field, double matrix[4][4],
                                 double camera_to_world[3][4]) {
    double scale = 1;
    enum vw_status status = check_matrix(where, field, matrix, &scale);
    if (status) return status;
    make_rotation(matrix, scale);
    memcpy(camera_to_world, matrix, 3 * sizeof matrix[0]);
    return VW_OK;
}

enum vw_status vw_transforms_pose(const char *where, const json_t *frame, double camera_to_world[3][4]) {
    double matrix[4][4] = {[3] = {0, 0, 0, 1}};
    enum vw_status status = read_matrix(where, json_object_get(frame, "transform_matrix"), matrix);
    return status ? status : vw_pose_of_matrix(where, "field transform_matrix", matrix, camera_to_world);
}

// ---- Writing -------------------------------------------------------------------------------------------------------

// Writes transforms.json with nerfstudio's conventions, as transforms_json.c reads it.
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

const char *vw_transforms_split_key(enum vw_split split) {
    static const char *const keys[VW_SPLIT_EXCLUDED] = {"train_filenames", "val_filenames", "test_filenames"};
    return keys[split];
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
