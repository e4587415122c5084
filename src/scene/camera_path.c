#include "scene/camera_path.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/json.h"
#include "base/memory.h"
#include "base/statistics.h"
#include "scene/builder.h"
#include "scene/formats/transforms.h"

static const double SPIRAL_SHARE = 0.9, SPIRAL_TURNS = 2;
static const double PARALLEL = 1e-6; // a sine, or a length of a mean of unit vectors, that is as good as none

struct vw_camera vw_camera_pinhole(const struct vw_camera *camera) {
    return (struct vw_camera){.width_px = camera->width_px,
                              .height_px = camera->height_px,
                              .focal_x_px = camera->focal_x_px,
                              .focal_y_px = camera->focal_y_px,
                              .centre_x_px = camera->centre_x_px,
                              .centre_y_px = camera->centre_y_px};
}

struct vw_camera vw_camera_resized(const struct vw_camera *camera, uint32_t width_px, uint32_t height_px) {
    struct vw_camera resized = vw_camera_pinhole(camera);
    vw_camera_resize(width_px, height_px, &resized);
    return resized;
}

void vw_camera_path_free(struct vw_camera_path *path) {
    for (uint32_t f = 0; f < path->count; f++) free(path->frames[f].name);
    free(path->frames);
    *path = (struct vw_camera_path){0};
}

void vw_camera_path_set_depths(const struct vw_scene *scene, struct vw_view *frame) {
    double near = 0, far = 0, weights = 0;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        const struct vw_view *view = &scene->views[v];
        double square = 0;
        for (int i = 0; i < 3; i++)
            square += pow(view->camera_to_world[i][VW_POSE_POSITION] - frame->camera_to_world[i][VW_POSE_POSITION], 2);
        if (!(view->far_world > 0)) continue;
        double weight = 1 / (square * square);
        if (isinf(weight)) {
            near = view->near_world;
            far = view->far_world;
            weights = 1;
            break;
        }
        near += weight * view->near_world;
        far += weight * view->far_world;
        weights += weight;
    }
    if (!(weights > 0)) return;
    frame->near_world = near / weights;
    frame->far_world = far / weights;
}

// ---- Vectors --------------------------------------------------------------------------------------------------------

static void cross(const double a[3], const double b[3], double product[3]) {
    for (int i = 0; i < 3; i++) product[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

// Returns the length that the vector had; a vector shorter than `least` stays.
static double normalise(double vector[3], double least) {
    double length = sqrt(vw_dot(vector, vector, 3));
    for (int i = 0; i < 3 && length > least; i++) vector[i] /= length;
    return length;
}

static void column_of(const struct vw_view *view, enum vw_pose_column axis, double column[3]) {
    for (int i = 0; i < 3; i++) column[i] = view->camera_to_world[i][axis];
}

static void mean_of(const struct vw_scene *scene, enum vw_pose_column axis, double mean[3]) {
    for (int i = 0; i < 3; i++) mean[i] = 0;
    for (uint32_t v = 0; v < scene->view_count; v++)
        for (int i = 0; i < 3; i++) mean[i] += scene->views[v].camera_to_world[i][axis] / scene->view_count;
}

bool vw_camera_look_at(const double position[3], const double target[3], const double up[3],
                       double camera_to_world[3][4]) {
    double axes[3][3];
    for (int i = 0; i < 3; i++) axes[VW_POSE_BACK][i] = position[i] - target[i];
    normalise(axes[VW_POSE_BACK], 0);
    cross(up, axes[VW_POSE_BACK], axes[VW_POSE_RIGHT]);
    if (!(normalise(axes[VW_POSE_RIGHT], 0) > PARALLEL)) return false;
    cross(axes[VW_POSE_BACK], axes[VW_POSE_RIGHT], axes[VW_POSE_UP]);
    for (int i = 0; i < 3; i++) {
        for (int axis = VW_POSE_RIGHT; axis <= VW_POSE_BACK; axis++) camera_to_world[i][axis] = axes[axis][i];
        camera_to_world[i][VW_POSE_POSITION] = position[i];
    }
    return true;
}

// ---- Orbit ----------------------------------------------------------------------------------------------------------

// Splits the place of a camera relative to `focus` into its height along `up` and the rest.
static double height_of(const struct vw_view *view, const double focus[3], const double up[3], double across[3]) {
    column_of(view, VW_POSE_POSITION, across);
    for (int i = 0; i < 3; i++) across[i] -= focus[i];
    double height = vw_dot(across, up, 3);
    for (int i = 0; i < 3; i++) across[i] -= height * up[i];
    return height;
}

static enum vw_status median_cylinder(const struct vw_scene *scene, const double focus[3], const double up[3],
                                      double *radius, double *height) {
    double *radii = vw_allocate(scene->view_count, sizeof *radii);
    double *heights = vw_allocate(scene->view_count, sizeof *heights);
    enum vw_status status = radii && heights ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t v = 0; v < scene->view_count && !status; v++) {
        double across[3];
        heights[v] = height_of(&scene->views[v], focus, up, across);
        radii[v] = sqrt(vw_dot(across, across, 3));
    }
    if (!status) {
        *radius = vw_median(radii, scene->view_count);
        *height = vw_median(heights, scene->view_count);
    }
    free(radii);
    free(heights);
    return status;
}

static void find_axis(const struct vw_scene *scene, uint32_t view, double focus[3], double up[3]) {
    vw_bounds_focus(scene, focus);
    mean_of(scene, VW_POSE_UP, up);
    if (normalise(up, PARALLEL) <= PARALLEL) column_of(&scene->views[view], VW_POSE_UP, up);
}

static enum vw_status make_orbit(const struct vw_scene *scene, uint32_t view, const struct vw_camera_path *path) {
    double focus[3], up[3], first[3], second[3], radius = 0, height = 0;
    find_axis(scene, view, focus, up);
    enum vw_status status = median_cylinder(scene, focus, up, &radius, &height);
    if (status) return status;
    (void)height_of(&scene->views[view], focus, up, first);
    if (!(normalise(first, 0) > PARALLEL * radius)) radius = 0;
    cross(up, first, second);
    for (uint32_t f = 0; f < path->count; f++) {
        double angle = 2 * M_PI * f / path->count, position[3];
        for (int i = 0; i < 3; i++)
            position[i] = focus[i] + height * up[i] + radius * (cos(angle) * first[i] + sin(angle) * second[i]);
        if (!(radius > 0) || !vw_camera_look_at(position, focus, up, path->frames[f].camera_to_world))
            return vw_fail(VW_ERROR_USAGE,
                           "--path orbit: the cameras are above what they look at, not around it; use --path cameras");
    }
    return VW_OK;
}

// ---- Spiral ---------------------------------------------------------------------------------------------------------

struct spiral {
    double mean_to_world[3][4]; // the mean camera
    double up[3], target[3], spread[3];
};

// Finds the mean camera and what it looks at; false where the cameras do not face one way.
static bool find_mean(const struct vw_scene *scene, struct spiral *spiral) {
    double focus[3], back[3], mean[3], depth = 0;
    vw_bounds_focus(scene, focus);
    mean_of(scene, VW_POSE_UP, spiral->up);
    mean_of(scene, VW_POSE_BACK, back);
    mean_of(scene, VW_POSE_POSITION, mean);
    if (!(normalise(back, PARALLEL) > PARALLEL)) return false;
    for (int i = 0; i < 3; i++) depth += (mean[i] - focus[i]) * back[i];
    for (int i = 0; i < 3; i++) spiral->target[i] = mean[i] - depth * back[i];
    return depth > 0 && vw_camera_look_at(mean, spiral->target, spiral->up, spiral->mean_to_world);
}

static enum vw_status find_spread(const struct vw_scene *scene, struct spiral *spiral) {
    const double(*mean)[4] = spiral->mean_to_world;
    double *offsets = vw_allocate(scene->view_count, sizeof *offsets);
    if (!offsets) return VW_ERROR_MEMORY;
    for (int axis = VW_POSE_RIGHT; axis <= VW_POSE_BACK; axis++) {
        for (uint32_t v = 0; v < scene->view_count; v++) {
            double along = 0;
            for (int i = 0; i < 3; i++)
                along +=
                    mean[i][axis] * (scene->views[v].camera_to_world[i][VW_POSE_POSITION] - mean[i][VW_POSE_POSITION]);
            offsets[v] = fabs(along);
        }
        vw_sort(offsets, scene->view_count);
        spiral->spread[axis] = vw_quantile_of_sorted(offsets, scene->view_count, SPIRAL_SHARE);
    }
    free(offsets);
    return VW_OK;
}

static bool place_on_spiral(const struct spiral *spiral, double angle, double camera_to_world[3][4]) {
    const double along[3] = {cos(angle), -sin(angle), -sin(angle / SPIRAL_TURNS)};
    double position[3];
    for (int i = 0; i < 3; i++) {
        position[i] = spiral->mean_to_world[i][VW_POSE_POSITION];
        for (int axis = VW_POSE_RIGHT; axis <= VW_POSE_BACK; axis++)
            position[i] += along[axis] * spiral->spread[axis] * spiral->mean_to_world[i][axis];
    }
    return vw_camera_look_at(position, spiral->target, spiral->up, camera_to_world);
}

static enum vw_status make_spiral(const struct vw_scene *scene, const struct vw_camera_path *path) {
    struct spiral spiral;
    bool told = find_mean(scene, &spiral);
    enum vw_status status = told ? find_spread(scene, &spiral) : VW_OK;
    for (uint32_t f = 0; f < path->count && !status && told; f++)
        told = place_on_spiral(&spiral, 2 * M_PI * SPIRAL_TURNS * f / path->count, path->frames[f].camera_to_world);
    if (status || told) return status;
    return vw_fail(VW_ERROR_USAGE, "--path spiral: the cameras do not face one way; use --path orbit");
}

// ---- Cameras --------------------------------------------------------------------------------------------------------

static int by_name(const void *one, const void *other) {
    return strverscmp((*(const struct vw_view *const *)one)->name, (*(const struct vw_view *const *)other)->name);
}

static void set_rotation(const double q[4], double m[3][4]) {
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            double odd = i == j ? 0 : ((j + 3 - i) % 3 == 1 ? -q[4 - i - j] : q[4 - i - j]) * q[0];
            m[i][j] = 2 * (q[i + 1] * q[j + 1] + odd) + (i == j ? 2 * q[0] * q[0] - 1 : 0);
        }
}

static void turn_between(const struct vw_view *from, const struct vw_view *to, double share, double m[3][4]) {
    double a[4], b[4], q[4];
    vw_pose_quaternion(from->camera_to_world, a);
    vw_pose_quaternion(to->camera_to_world, b);
    double cosine = vw_dot(a, b, 4), sign = cosine < 0 ? -1 : 1, angle = acos(fmin(fabs(cosine), 1));
    bool near = sin(angle) < PARALLEL; // where sines of the angle are nearly the angle
    for (int i = 0; i < 4; i++)
        q[i] = near ? (1 - share) * a[i] + share * sign * b[i]
                    : (sin((1 - share) * angle) * a[i] + sign * sin(share * angle) * b[i]) / sin(angle);
    set_rotation(q, m);
}

// Returns Catmull-Rom's curve from p[1] to p[2].
static double interpolate(const double p[4], double share) {
    return p[1] + 0.5 * share *
                      (p[2] - p[0] +
                       share * (2 * p[0] - 5 * p[1] + 4 * p[2] - p[3] + share * (3 * (p[1] - p[2]) + p[3] - p[0])));
}

// Places a frame `share` of the way from one camera to the next.
static void place_between(const struct vw_view *const *views, uint32_t count, uint32_t from, double share,
                          double camera_to_world[3][4]) {
    memcpy(camera_to_world, views[from]->camera_to_world, sizeof views[from]->camera_to_world);
    if (share == 0) return;
    turn_between(views[from], views[from + 1], share, camera_to_world);
    for (int i = 0; i < 3; i++) {
        double p[4];
        p[1] = views[from]->camera_to_world[i][VW_POSE_POSITION];
        p[2] = views[from + 1]->camera_to_world[i][VW_POSE_POSITION];
        p[0] = from ? views[from - 1]->camera_to_world[i][VW_POSE_POSITION] : 2 * p[1] - p[2];
        p[3] = from + 2 < count ? views[from + 2]->camera_to_world[i][VW_POSE_POSITION] : 2 * p[2] - p[1];
        camera_to_world[i][VW_POSE_POSITION] = interpolate(p, share);
    }
}

static enum vw_status make_through(const struct vw_scene *scene, const struct vw_camera_path *path) {
    const struct vw_view **views = vw_allocate(scene->view_count, sizeof(const struct vw_view *));
    if (!views) return VW_ERROR_MEMORY;
    for (uint32_t v = 0; v < scene->view_count; v++) views[v] = &scene->views[v];
    qsort(views, scene->view_count, sizeof *views, by_name);
    uint64_t last = path->count > 1 ? path->count - 1 : 1;
    for (uint32_t f = 0; f < path->count; f++) {
        uint64_t place = (uint64_t)f * (scene->view_count - 1);
        place_between(views, scene->view_count, (uint32_t)(place / last), (double)(place % last) / (double)last,
                      path->frames[f].camera_to_world);
    }
    free(views);
    return VW_OK;
}

// ---- All of them ----------------------------------------------------------------------------------------------------

bool vw_camera_path_is(const char *name) {
    return !strcmp(name, "orbit") || !strcmp(name, "spiral") || !strcmp(name, "cameras");
}

enum vw_status vw_camera_path_make(const struct vw_scene *scene, const char *name, uint32_t view, uint32_t count,
                                   struct vw_camera_path *path) {
    struct vw_camera_path made = {vw_allocate(count, sizeof *made.frames), count};
    if (!made.frames) return VW_ERROR_MEMORY;
    enum vw_status status = !strcmp(name, "orbit")    ? make_orbit(scene, view, &made)
                            : !strcmp(name, "spiral") ? make_spiral(scene, &made)
                                                      : make_through(scene, &made);
    for (uint32_t f = 0; f < count && !status; f++) {
        made.frames[f].camera = vw_camera_pinhole(&scene->views[view].camera);
        vw_camera_path_set_depths(scene, &made.frames[f]);
    }
    if (!status) *path = made;
    else free(made.frames);
    return status;
}

// ---- Poses from outside --------------------------------------------------------------------------------------------

// Poses from outside: a camera path of nerfstudio, the frames of a transforms.json, numbers on the command line.
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
