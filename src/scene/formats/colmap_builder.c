#include "scene/formats/colmap_builder.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/inside.h"
#include "base/memory.h"
#include "base/text.h"
#include "scene/builder.h"

static const double NORM_TOLERANCE = 1e-3; // for a quaternion's length; COLMAP writes 17 digits, hand-made models fewer

// The limits of transforms.json: sums and products of larger numbers would overflow or lose precision.
static const double POSITION_LIMIT_WORLD = VW_POSITION_MOST_WORLD, FEATURE_LIMIT_PX = 1e9;

// Returns false also for NaN.
static bool all_within(double limit, const double *values, size_t count) {
    for (size_t i = 0; i < count; i++)
        if (!(fabs(values[i]) <= limit)) return false;
    return true;
}

// ---- Ids ----

static int compare_ids(const void *a, const void *b) {
    uint32_t left = ((const struct colmap_id *)a)->id, right = ((const struct colmap_id *)b)->id;
    return (left > right) - (left < right);
}

// Sorts the ids of `count` records; `first` points at the id of the first record and `stride_bytes` leads from one to
// the next.
static enum vw_status index_ids(const char *what, const uint32_t *first, size_t stride_bytes, size_t count,
                                struct colmap_id **ids) {
    *ids = vw_allocate(count, sizeof **ids);
    if (!*ids) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < count; i++)
        (*ids)[i] = (struct colmap_id){.id = *(const uint32_t *)((const char *)first + i * stride_bytes), .index = i};
    qsort(*ids, count, sizeof **ids, compare_ids);
    for (size_t i = 1; i < count; i++)
        if ((*ids)[i].id == (*ids)[i - 1].id)
            return vw_fail(VW_ERROR_INPUT, "%s %u appears twice; ids must be unique, export the model again", what,
                           (*ids)[i].id);
    return VW_OK;
}

static const struct colmap_id *find_id(const struct colmap_id *ids, size_t count, uint32_t id) {
    return bsearch(&(struct colmap_id){.id = id}, ids, count, sizeof *ids, compare_ids);
}

// ---- Cameras ----

enum vw_status colmap_add_camera(struct colmap_builder *builder, uint32_t id, const struct vw_camera *camera) {
    struct vw_colmap_model *model = builder->model;
    enum vw_status status =
        vw_grow((void **)&model->cameras, &builder->camera_capacity, model->camera_count + 1, sizeof *model->cameras);
    if (!status) model->cameras[model->camera_count++] = (struct vw_colmap_camera){.id = id, .camera = *camera};
    return status;
}

static enum vw_status cameras_done(struct colmap_builder *builder) {
    const struct vw_colmap_model *model = builder->model;
    if (!model->camera_count) return vw_fail(VW_ERROR_INPUT, "no cameras in it; export the model again");
    return index_ids("camera", &model->cameras->id, sizeof *model->cameras, model->camera_count, &builder->camera_ids);
}

// ---- Images ----

// Converts COLMAP's world-to-camera pose (x right, y down, z forward) to camera-to-world with OpenGL axes (x right, y
// up, z backward).
static enum vw_status invert_pose(const struct colmap_image_fields *fields, double camera_to_world[3][4]) {
    const double *given = fields->rotation, *t = fields->translation;
    double norm = sqrt(given[0] * given[0] + given[1] * given[1] + given[2] * given[2] + given[3] * given[3]);
    if (!(fabs(norm - 1) <= NORM_TOLERANCE))
        return vw_fail(VW_ERROR_INPUT,
                       "image %u: field quaternion (%g %g %g %g) is not of length 1; export the model again",
                       fields->id, given[0], given[1], given[2], given[3]);
    if (!all_within(POSITION_LIMIT_WORLD, t, 3))
        return vw_fail(VW_ERROR_INPUT,
                       "image %u: field translation (%g %g %g) is not finite or lies beyond %g; export the model again",
                       fields->id, t[0], t[1], t[2], POSITION_LIMIT_WORLD);
    double w = given[0] / norm, x = given[1] / norm, y = given[2] / norm, z = given[3] / norm;
    const double world_to_camera[3][3] = {
        {1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
        {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
        {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)},
    };
    for (int i = 0; i < 3; i++) {
        camera_to_world[i][3] = 0;
        for (int j = 0; j < 3; j++) {
            camera_to_world[i][j] = j == 0 ? world_to_camera[j][i] : -world_to_camera[j][i];
            camera_to_world[i][3] -= world_to_camera[j][i] * t[j];
        }
    }
    return VW_OK;
}

static enum vw_status check_name(uint32_t image, const char *name) {
    if (!*name) return vw_fail(VW_ERROR_INPUT, "image %u: field name is empty; give the photo's path", image);
    if (!vw_text_is_clean(name))
        return vw_fail(VW_ERROR_INPUT, "image %u: field name is not UTF-8 or has control characters; rename the photo",
                       image);
    if (vw_path_leaves_folder(name))
        return vw_fail(VW_ERROR_INPUT,
                       "image %u: field name (%s) leaves the scene folder; use a path relative to it without ..", image,
                       name);
    return VW_OK;
}

enum vw_status colmap_add_image(struct colmap_builder *builder, const struct colmap_image_fields *fields) {
    struct vw_colmap_model *model = builder->model;
    struct vw_colmap_image image = {.id = fields->id, .first_feature = model->feature_count};
    const struct colmap_id *camera = find_id(builder->camera_ids, model->camera_count, fields->camera_id);
    if (!camera)
        return vw_fail(VW_ERROR_INPUT,
                       "image %u: field camera_id is %u, which the cameras file does not have; export the model again",
                       fields->id, fields->camera_id);
    image.camera = camera->index;
    enum vw_status status = check_name(fields->id, fields->name);
    if (!status) status = invert_pose(fields, image.camera_to_world);
    if (!status)
        status =
            vw_grow((void **)&model->images, &builder->image_capacity, model->image_count + 1, sizeof *model->images);
    if (status) return status;
    image.name = vw_copy_text(vw_view_name_of(fields->name));
    if (!image.name) return VW_ERROR_MEMORY;
    model->images[model->image_count++] = image;
    return VW_OK;
}

enum vw_status colmap_add_feature(struct colmap_builder *builder, double x_px, double y_px) {
    struct vw_colmap_model *model = builder->model;
    struct vw_colmap_image *image = &model->images[model->image_count - 1];
    if (!all_within(FEATURE_LIMIT_PX, (const double[]){x_px, y_px}, 2))
        return vw_fail(VW_ERROR_INPUT,
                       "image %u: field points2D: point %llu is (%g, %g), which is not finite or lies beyond %g; "
                       "export the model again",
                       image->id, (unsigned long long)image->feature_count, x_px, y_px, FEATURE_LIMIT_PX);
    enum vw_status status = vw_grow((void **)&model->features, &builder->feature_capacity, model->feature_count + 1,
                                    sizeof *model->features);
    if (status) return status;
    model->features[model->feature_count++] = (struct vw_colmap_feature){x_px, y_px};
    image->feature_count++;
    return VW_OK;
}

static enum vw_status index_names(struct vw_colmap_model *model) {
    enum vw_status status =
        vw_name_index_make(model->images, sizeof *model->images, offsetof(struct vw_colmap_image, name),
                           model->image_count, &model->names);
    for (size_t i = 0; i < model->image_count && !status; i++) {
        size_t first = i;
        if (vw_name_index_find(&model->names, model->images[i].name, &first) && first != i)
            status = vw_fail(VW_ERROR_INPUT, "images %u and %u: field name: both are %s; names must be unique",
                             model->images[first].id, model->images[i].id, model->images[i].name);
    }
    return status;
}

static enum vw_status images_done(struct colmap_builder *builder) {
    struct vw_colmap_model *model = builder->model;
    if (!model->image_count) return vw_fail(VW_ERROR_INPUT, "no images in it; export the model again");
    enum vw_status status =
        index_ids("image", &model->images->id, sizeof *model->images, model->image_count, &builder->image_ids);
    return status ? status : index_names(model);
}

// ---- Points ----

enum vw_status colmap_add_point(struct colmap_builder *builder, const struct colmap_point_fields *fields) {
    struct vw_colmap_model *model = builder->model;
    const double *position = fields->position_world;
    if (!all_within(POSITION_LIMIT_WORLD, position, 3))
        return vw_fail(VW_ERROR_INPUT,
                       "point %llu: field xyz (%g %g %g) is not finite or lies beyond %g; export the model again",
                       (unsigned long long)fields->id, position[0], position[1], position[2], POSITION_LIMIT_WORLD);
    if (!isfinite(fields->error_px))
        return vw_fail(VW_ERROR_INPUT, "point %llu: field error is %g; export the model again",
                       (unsigned long long)fields->id, fields->error_px);
    size_t needed = model->point_count + 1;
    enum vw_status status = vw_grow((void **)&model->points, &builder->point_capacity, needed, sizeof *model->points);
    if (!status)
        status = vw_grow((void **)&builder->point_ids, &builder->point_id_capacity, needed, sizeof *builder->point_ids);
    if (status) return status;
    builder->point_ids[model->point_count] = fields->id;
    struct vw_colmap_point *point = &model->points[model->point_count++];
    *point = (struct vw_colmap_point){.error_px = fields->error_px, .first_track = model->track_count};
    memcpy(point->position_world, position, sizeof point->position_world);
    memcpy(point->rgb, fields->rgb, sizeof point->rgb);
    return VW_OK;
}

enum vw_status colmap_add_track(struct colmap_builder *builder, uint32_t image_id, uint32_t feature) {
    struct vw_colmap_model *model = builder->model;
    unsigned long long point = builder->point_ids[model->point_count - 1];
    const struct colmap_id *image = find_id(builder->image_ids, model->image_count, image_id);
    if (!image)
        return vw_fail(VW_ERROR_INPUT,
                       "point %llu: field track: image %u is not in the images file; export the model again", point,
                       image_id);
    uint64_t feature_count = model->images[image->index].feature_count;
    if (feature >= feature_count)
        return vw_fail(
            VW_ERROR_INPUT,
            "point %llu: field track: image %u has %llu points2D, there is no number %u; export the model again", point,
            image_id, (unsigned long long)feature_count, feature);
    enum vw_status status =
        vw_grow((void **)&model->tracks, &builder->track_capacity, model->track_count + 1, sizeof *model->tracks);
    if (status) return status;
    model->tracks[model->track_count++] = (struct vw_colmap_track){.image = image->index, .feature = feature};
    model->points[model->point_count - 1].track_count++;
    return VW_OK;
}

static int compare_numbers(const void *a, const void *b) {
    uint64_t left = *(const uint64_t *)a, right = *(const uint64_t *)b;
    return (left > right) - (left < right);
}

static enum vw_status points_done(struct colmap_builder *builder) {
    size_t count = builder->model->point_count;
    uint64_t *ids = builder->point_ids;
    if (count) qsort(ids, count, sizeof *ids, compare_numbers);
    for (size_t i = 1; i < count; i++)
        if (ids[i] == ids[i - 1])
            return vw_fail(VW_ERROR_INPUT, "point %llu appears twice; ids must be unique, export the model again",
                           (unsigned long long)ids[i]);
    return VW_OK;
}

enum vw_status colmap_file_done(struct colmap_builder *builder, enum colmap_file file) {
    return file == COLMAP_CAMERAS  ? cameras_done(builder)
           : file == COLMAP_IMAGES ? images_done(builder)
                                   : points_done(builder);
}

void colmap_builder_clear(struct colmap_builder *builder) {
    free(builder->camera_ids);
    free(builder->image_ids);
    free(builder->point_ids);
}

// ---- Camera models -------------------------------------------------------------------------------------------------

// COLMAP's camera models and their params as fields of struct vw_camera.
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
