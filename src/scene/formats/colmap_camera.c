// COLMAP's camera models and their params as fields of struct vw_camera.
#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "scene/builder.h"
#include "scene/formats/colmap_builder.h"

enum { SIDE_PX_MAX = 1 << 30 };
static const double NUMBER_LIMIT = VW_FOCAL_MOST_PX; // for every param, as in transforms.json

#define FIELD(name)                                                                                                    \
    { #name, offsetof(struct vw_camera, name) }
#define SINGLE_FOCAL FIELD(focal_x_px), FIELD(centre_x_px), FIELD(centre_y_px)
#define TWO_FOCALS FIELD(focal_x_px), FIELD(focal_y_px), FIELD(centre_x_px), FIELD(centre_y_px)

// Models with a single focal length leave focal_y_px 0. The index in this table is COLMAP's number of the model.
static const struct colmap_camera_model {
    const char *name;
    uint32_t param_count; // 0: not supported
    enum vw_lens lens;
    struct {
        const char *name;
        size_t offset;
    } params[COLMAP_PARAMS_MAX];
} models[] = {
    {"SIMPLE_PINHOLE", 3, VW_LENS_POLYNOMIAL, {SINGLE_FOCAL}},
    {"PINHOLE", 4, VW_LENS_POLYNOMIAL, {TWO_FOCALS}},
    {"SIMPLE_RADIAL", 4, VW_LENS_POLYNOMIAL, {SINGLE_FOCAL, FIELD(k1)}},
    {"RADIAL", 5, VW_LENS_POLYNOMIAL, {SINGLE_FOCAL, FIELD(k1), FIELD(k2)}},
    {"OPENCV", 8, VW_LENS_POLYNOMIAL, {TWO_FOCALS, FIELD(k1), FIELD(k2), FIELD(p1), FIELD(p2)}},
    {"OPENCV_FISHEYE", 8, VW_LENS_FISHEYE, {TWO_FOCALS, FIELD(k1), FIELD(k2), FIELD(k3), FIELD(k4)}},
    {"FULL_OPENCV",
     12,
     VW_LENS_POLYNOMIAL,
     {TWO_FOCALS, FIELD(k1), FIELD(k2), FIELD(p1), FIELD(p2), FIELD(k3), FIELD(k4), FIELD(k5), FIELD(k6)}},
    {.name = "FOV"},
    {.name = "SIMPLE_RADIAL_FISHEYE"},
    {.name = "RADIAL_FISHEYE"},
    {.name = "THIN_PRISM_FISHEYE"},
};

static const char REMEDY[] =
    "undistort the photos (colmap image_undistorter) or choose SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, "
    "OPENCV, OPENCV_FISHEYE or FULL_OPENCV";

static enum vw_status check_supported(uint32_t camera, const struct colmap_camera_model *candidate,
                                      const struct colmap_camera_model **model) {
    if (!candidate->param_count)
        return vw_fail(VW_ERROR_INPUT, "camera %u: model %s is not supported; %s", camera, candidate->name, REMEDY);
    *model = candidate;
    return VW_OK;
}

enum vw_status colmap_camera_model_by_id(uint32_t camera, int32_t id, const struct colmap_camera_model **model) {
    if (id >= 0 && id < (int32_t)VW_ARRAY_COUNT(models)) return check_supported(camera, &models[id], model);
    return vw_fail(VW_ERROR_INPUT, "camera %u: model number %d is not supported; %s", camera, id, REMEDY);
}

enum vw_status colmap_camera_model_by_name(uint32_t camera, const char *name,
                                           const struct colmap_camera_model **model) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(models); i++)
        if (!strcmp(models[i].name, name)) return check_supported(camera, &models[i], model);
    return vw_fail(VW_ERROR_INPUT, "camera %u: model %.64s is not supported; %s", camera, name, REMEDY);
}

uint32_t colmap_camera_param_count(const struct colmap_camera_model *model) { return model->param_count; }

enum vw_status colmap_camera_make(uint32_t camera, const struct colmap_camera_model *model, uint64_t width_px,
                                  uint64_t height_px, const double params[COLMAP_PARAMS_MAX], struct vw_camera *made) {
    if (!width_px || !height_px || width_px > SIDE_PX_MAX || height_px > SIDE_PX_MAX)
        return vw_fail(VW_ERROR_INPUT,
                       "camera %u: fields width and height are %llu and %llu; they must be from 1 to %d", camera,
                       (unsigned long long)width_px, (unsigned long long)height_px, SIDE_PX_MAX);
    struct vw_camera result = {.width_px = (uint32_t)width_px, .height_px = (uint32_t)height_px, .lens = model->lens};
    for (uint32_t i = 0; i < model->param_count; i++) {
        bool focal = !strncmp(model->params[i].name, "focal", 5);
        if (!(fabs(params[i]) <= NUMBER_LIMIT) || (focal && params[i] < VW_FOCAL_LEAST_PX))
            return vw_fail(VW_ERROR_INPUT, "camera %u: field %s is %g; it must be a finite number %s and at most %g",
                           camera, model->params[i].name, params[i], focal ? "from 0.001" : "in size", NUMBER_LIMIT);
        memcpy((char *)&result + model->params[i].offset, &params[i], sizeof params[i]);
    }
    if (result.focal_y_px == 0) result.focal_y_px = result.focal_x_px;
    *made = result;
    return VW_OK;
}

uint32_t colmap_camera_params(const struct vw_camera *camera, int32_t *id, double params[COLMAP_PARAMS_MAX]) {
    for (*id = 0; *id < (int32_t)VW_ARRAY_COUNT(models); ++*id) {
        const struct colmap_camera_model *model = &models[*id];
        struct vw_camera made = {.width_px = camera->width_px, .height_px = camera->height_px, .lens = model->lens};
        for (uint32_t i = 0; i < model->param_count; i++) {
            memcpy(&params[i], (const char *)camera + model->params[i].offset, sizeof params[i]);
            memcpy((char *)&made + model->params[i].offset, &params[i], sizeof params[i]);
        }
        if (made.focal_y_px == 0) made.focal_y_px = made.focal_x_px;
        if (vw_camera_same(&made, camera)) return model->param_count;
    }
    return 0; // not reached: FULL_OPENCV and OPENCV_FISHEYE have all that scenes have
}
