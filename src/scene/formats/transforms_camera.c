#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "scene/builder.h"
#include "scene/formats/transforms.h"

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
