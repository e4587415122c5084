// Poses from outside: a camera path of nerfstudio, the frames of a transforms.json, numbers on the command line.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/json_reader.h"
#include "base/memory.h"
#include "scene/builder.h"
#include "scene/camera_path.h"
#include "scene/formats/transforms.h"

struct reading {
    const struct vw_scene *scene;
    const char *file;
    struct vw_camera camera; // for frames without one
    struct vw_camera_path path;
};

static enum vw_status begin(struct reading *reading, size_t frames) {
    reading->path.frames = vw_allocate(frames, sizeof *reading->path.frames);
    return reading->path.frames ? VW_OK : VW_ERROR_MEMORY;
}

static void add(struct reading *reading, const struct vw_camera *camera, double camera_to_world[3][4]) {
    struct vw_view *frame = &reading->path.frames[reading->path.count++];
    frame->camera = vw_camera_pinhole(camera);
    memcpy(frame->camera_to_world, camera_to_world, sizeof frame->camera_to_world);
    vw_camera_path_set_depths(reading->scene, frame);
}

static enum vw_status end(struct reading *reading, enum vw_status status, struct vw_camera_path *path) {
    if (!status) *path = reading->path;
    else vw_camera_path_free(&reading->path);
    return status;
}

// ---- nerfstudio -----------------------------------------------------------------------------------------------------

static void read_frame(struct vw_json_reader *reader, const json_t *item, void *context) {
    struct reading *reading = context;
    struct vw_camera camera = reading->camera;
    double matrix[4][4] = {{NAN}}, camera_to_world[3][4], fov_deg = NAN;
    char where[sizeof reader->place + 4096];
    vw_json_numbers(reader, item, "camera_to_world", -VW_POSITION_MOST_WORLD, VW_POSITION_MOST_WORLD, matrix[0], 16);
    vw_json_number(reader, item, "fov", 1e-3, 179.9, &fov_deg);
    if (reader->status) return;
    snprintf(where, sizeof where, "%s: %s", reading->file, reader->place);
    camera.focal_x_px = camera.focal_y_px = 0.5 * camera.height_px / tan(0.5 * fov_deg * M_PI / 180);
    reader->status = vw_pose_of_matrix(where, "field camera_to_world", matrix, camera_to_world);
    if (!reader->status) add(reading, &camera, camera_to_world);
}

static enum vw_status read_nerfstudio(struct reading *reading, const json_t *file) {
    struct vw_json_reader reader = {.path = reading->file};
    int64_t width_px = -1, height_px = -1;
    int type = 0;
    vw_json_word(&reader, file, "camera_type", "perspective", &type);
    vw_json_integer(&reader, file, "render_width", 1, VW_CAMERA_PATH_SIDE_MOST_PX, &width_px);
    vw_json_integer(&reader, file, "render_height", 1, VW_CAMERA_PATH_SIDE_MOST_PX, &height_px);
    reading->camera = (struct vw_camera){.width_px = (uint32_t)width_px,
                                         .height_px = (uint32_t)height_px,
                                         .centre_x_px = 0.5 * (double)width_px,
                                         .centre_y_px = 0.5 * (double)height_px};
    if (!reader.status) reader.status = begin(reading, VW_CAMERA_PATH_FRAMES_MOST);
    vw_json_each(&reader, file, "camera_path", VW_CAMERA_PATH_FRAMES_MOST, read_frame, reading);
    if (reader.status || reading->path.count) return reader.status;
    return vw_fail(VW_ERROR_INPUT, "%s: field camera_path is empty; give at least one camera", reading->file);
}

// ---- transforms.json ------------------------------------------------------------------------------------------------

// Takes a side from the frame, from the file or as it is.
static enum vw_status read_side(const char *where, const json_t *file, const json_t *frame, const char *key,
                                uint32_t *side_px) {
    const json_t *given = json_object_get(frame, key);
    if (!given) given = json_object_get(file, key);
    if (!given) return VW_OK;
    double side = json_number_value(given);
    if (!(side >= 1 && side <= VW_CAMERA_PATH_SIDE_MOST_PX && side == floor(side)))
        return vw_fail(VW_ERROR_INPUT, "%s: field %s must be an integer from 1 to %d", where, key,
                       VW_CAMERA_PATH_SIDE_MOST_PX);
    *side_px = (uint32_t)side;
    return VW_OK;
}

static bool has_focal(const json_t *file, const json_t *frame) {
    static const char *const keys[] = {"fl_x", "fl_y", "camera_angle_x", "camera_angle_y"};
    bool has = false;
    for (size_t i = 0; i < VW_ARRAY_COUNT(keys); i++)
        has |= json_object_get(file, keys[i]) || json_object_get(frame, keys[i]);
    return has;
}

// Returns a camera of the same lens for pictures of another size and shape.
static struct vw_camera with_size(const struct vw_camera *camera, uint32_t width_px, uint32_t height_px) {
    double factor = fmax(width_px, height_px) / fmax(camera->width_px, camera->height_px);
    struct vw_camera sized = vw_camera_resized(camera, width_px, height_px);
    sized.focal_x_px = factor * camera->focal_x_px;
    sized.focal_y_px = factor * camera->focal_y_px;
    return sized;
}

static enum vw_status read_transform(struct reading *reading, const char *where, const json_t *file,
                                     const json_t *frame) {
    uint32_t width_px = reading->camera.width_px, height_px = reading->camera.height_px;
    double camera_to_world[3][4];
    struct vw_camera camera;
    bool rescaled;
    enum vw_status status = vw_transforms_refuse_unknown(where, frame);
    if (!status) status = vw_transforms_pose(where, frame, camera_to_world);
    if (!status) status = read_side(where, file, frame, "w", &width_px);
    if (!status) status = read_side(where, file, frame, "h", &height_px);
    if (!has_focal(file, frame)) camera = with_size(&reading->camera, width_px, height_px);
    else if (!status) status = vw_transforms_camera(where, file, frame, width_px, height_px, &camera, &rescaled);
    if (!status) add(reading, &camera, camera_to_world);
    const char *name = json_string_value(json_object_get(frame, "file_path"));
    if (status || !name) return status;
    char **kept = &reading->path.frames[reading->path.count - 1].name;
    return (*kept = vw_copy_text(name)) ? VW_OK : VW_ERROR_MEMORY;
}

static enum vw_status read_transforms(struct reading *reading, const json_t *file) {
    const json_t *frames = json_object_get(file, "frames");
    size_t count = json_array_size(frames);
    if (!count || count > VW_CAMERA_PATH_FRAMES_MOST)
        return vw_fail(VW_ERROR_INPUT, "%s: neither field camera_path nor field frames is a list of 1 to %d cameras",
                       reading->file, VW_CAMERA_PATH_FRAMES_MOST);
    enum vw_status status = vw_transforms_refuse_unknown(reading->file, file);
    if (!status) status = begin(reading, count);
    for (size_t i = 0; i < count && !status; i++) {
        char *where = vw_format_text("%s: frame %zu", reading->file, i);
        status = where ? read_transform(reading, where, file, json_array_get(frames, i)) : VW_ERROR_MEMORY;
        free(where);
    }
    return status;
}

enum vw_status vw_camera_path_read(const struct vw_scene *scene, const char *path, uint32_t view,
                                   struct vw_camera_path *camera_path) {
    struct reading reading = {.scene = scene, .file = path, .camera = scene->views[view].camera};
    json_t *file = NULL;
    enum vw_status status = vw_transforms_parse(NULL, path, &file);
    if (status) return status;
    status = json_object_get(file, "camera_path") ? read_nerfstudio(&reading, file) : read_transforms(&reading, file);
    json_decref(file);
    return end(&reading, status, camera_path);
}

// ---- Numbers --------------------------------------------------------------------------------------------------------

enum vw_status vw_camera_path_parse(const struct vw_scene *scene, const char *where, const char *numbers, uint32_t view,
                                    struct vw_camera_path *path) {
    struct reading reading = {.scene = scene};
    double matrix[4][4] = {[3] = {0, 0, 0, 1}}, camera_to_world[3][4];
    const char *rest = numbers + strspn(numbers, " ,");
    int count = 0;
    for (char *after; *rest && count < 16; rest = after + strspn(after, " ,")) {
        matrix[count / 4][count % 4] = strtod(rest, &after);
        if (after == rest || !isfinite(matrix[count / 4][count % 4])) break;
        count++;
    }
    if (*rest || (count != 12 && count != 16))
        return vw_fail(VW_ERROR_USAGE, "%s: give the 12 or 16 numbers of a camera-to-world matrix, rows first", where);
    enum vw_status status = vw_pose_of_matrix(where, "matrix", matrix, camera_to_world);
    if (status) return VW_ERROR_USAGE;
    status = begin(&reading, 1);
    if (!status) add(&reading, &scene->views[view].camera, camera_to_world);
    return end(&reading, status, path);
}
