// Photos by trace_recipe, one view after another, in ranges of pixels that fit one buffer; and points from their
// depths.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/random.h"
#include "gpu/compute.h"
#include "gpu/shaders.h"
#include "image/image.h"
#include "scene/synthetic/recipe.h"
#include "viewworth/gpu.h"

// ---- Points --------------------------------------------------------------------------------------------------------

// Surface points and the views that see them, computed from the depths of the photos.
static const double DEPTH_AGREES = 0.01; // relative to the distance
enum { CANDIDATES = 4096, TRACK_VIEWS_MIN = 2 };

struct point_maker {
    const struct vw_recipe *recipe;
    const float *depths; // [view][pixel]
    struct vw_scene *scene;
    size_t point_capacity, track_capacity;
};

static const float *depth_at(const struct point_maker *maker, uint32_t view, uint32_t x_px, uint32_t y_px) {
    size_t pixels = (size_t)maker->recipe->width_px * maker->recipe->height_px;
    return &maker->depths[view * pixels + (size_t)y_px * maker->recipe->width_px + x_px];
}

// Computes the point that a view sees at the centre of a pixel; false: none.
static bool point_behind(const struct point_maker *maker, uint32_t view_index, uint32_t x_px, uint32_t y_px,
                         double position[3]) {
    const struct vw_view *view = &maker->scene->views[view_index];
    double direction[3], depth = *depth_at(maker, view_index, x_px, y_px);
    if (depth <= 0 || !vw_camera_unproject(&view->camera, x_px + 0.5, y_px + 0.5, direction)) return false;
    double along = depth / hypot(hypot(direction[0], direction[1]), direction[2]);
    for (int i = 0; i < 3; i++) {
        const double *row = view->camera_to_world[i];
        position[i] = row[3] + along * (row[0] * direction[0] + row[1] * direction[1] + row[2] * direction[2]);
    }
    return true;
}

static bool view_sees(const struct point_maker *maker, uint32_t view_index, const double position[3],
                      struct vw_track *track) {
    const struct vw_view *view = &maker->scene->views[view_index];
    double offset[3], direction[3] = {0}, x_px, y_px;
    for (int i = 0; i < 3; i++) offset[i] = position[i] - view->camera_to_world[i][3];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) direction[j] += view->camera_to_world[i][j] * offset[i];
    if (!vw_camera_project(&view->camera, direction, &x_px, &y_px)) return false;
    if (!(x_px >= 0 && x_px < view->camera.width_px && y_px >= 0 && y_px < view->camera.height_px)) return false;
    double distance = hypot(hypot(offset[0], offset[1]), offset[2]);
    if (fabs(*depth_at(maker, view_index, (uint32_t)x_px, (uint32_t)y_px) - distance) > DEPTH_AGREES * distance)
        return false;
    *track = (struct vw_track){.view = view_index, .x_px = (float)x_px, .y_px = (float)y_px};
    return true;
}

// Appends the point and its tracks, unless too few views see it.
static enum vw_status add_point(struct point_maker *maker, const double position[3], const float rgb[3]) {
    struct vw_scene *scene = maker->scene;
    uint32_t first_track = scene->track_count, count = 0;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        struct vw_track track;
        if (maker->recipe->defects[v].kind == VW_DEFECT_WRONG_POSE || !view_sees(maker, v, position, &track)) continue;
        if (vw_grow((void **)&scene->tracks, &maker->track_capacity, first_track + count + 1, sizeof track))
            return VW_ERROR_MEMORY;
        scene->tracks[first_track + count++] = track;
    }
    if (count < TRACK_VIEWS_MIN) return VW_OK;
    if (vw_grow((void **)&scene->points, &maker->point_capacity, scene->point_count + 1, sizeof *scene->points))
        return VW_ERROR_MEMORY;
    struct vw_point *point = &scene->points[scene->point_count++];
    memcpy(point->position_world, position, sizeof point->position_world);
    memcpy(point->rgb, rgb, sizeof point->rgb);
    point->first_track = first_track;
    point->track_count = count;
    scene->track_count += count;
    return VW_OK;
}

static enum vw_status add_points_of_view(struct point_maker *maker, uint32_t view, uint32_t stride_px) {
    for (uint32_t y = stride_px / 2; y < maker->recipe->height_px; y += stride_px)
        for (uint32_t x = stride_px / 2; x < maker->recipe->width_px; x += stride_px) {
            double position[3];
            float rgba[4];
            if (!point_behind(maker, view, x, y, position)) continue;
            vw_image_pixel(&maker->scene->views[view].image, x, y, rgba);
            enum vw_status status = add_point(maker, position, rgba);
            if (status) return status;
        }
    return VW_OK;
}

enum vw_status vw_recipe_make_points(const struct vw_recipe *recipe, const float *depths, struct vw_scene *scene) {
    struct point_maker maker = {.recipe = recipe, .depths = depths, .scene = scene};
    double pixels = (double)recipe->width_px * recipe->height_px * scene->view_count;
    uint32_t stride_px = (uint32_t)ceil(sqrt(pixels / CANDIDATES));
    for (uint32_t v = 0; v < scene->view_count; v++) {
        if (recipe->defects[v].kind) continue; // a corrupted photo has the wrong colours
        enum vw_status status = add_points_of_view(&maker, v, stride_px);
        if (status) return status;
    }
    return VW_OK;
}

// ---- Tracing -------------------------------------------------------------------------------------------------------

enum { RANGE_PIXELS_MAX = 1 << 20 };

struct vw_recipe_tracer {
    const struct vw_recipe *recipe;
    double edge_world;
    uint32_t range_pixels; // at most this many at a time
    struct vw_buffer *cameras, *shapes, *pixels;
    struct vw_pass *pass;
    struct vw_submission *submission;
};

// Takes the camera itself as the reference position: recipes stay near their boxes.
static struct vw_gpu_camera to_gpu_camera(const struct vw_view *view, const struct vw_box *box) {
    float axes[3][3], position[3];
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) axes[j][i] = (float)view->camera_to_world[i][j];
        position[i] =
            (float)((view->camera_to_world[i][3] - box->centre_world[i]) / (2 * box->half_extent_world) + 0.5);
    }
    const struct vw_camera *camera = &view->camera;
    return (struct vw_gpu_camera){
        .right = {axes[0][0], axes[0][1], axes[0][2], (float)camera->focal_x_px},
        .up = {axes[1][0], axes[1][1], axes[1][2], (float)camera->focal_y_px},
        .back = {axes[2][0], axes[2][1], axes[2][2], (float)camera->centre_x_px},
        .reference = {position[0], position[1], position[2], 0},
        .distortion = {(float)camera->k1, (float)camera->k2, (float)camera->p1, (float)camera->p2},
        .more = {.x = (float)camera->centre_y_px},
    };
}

static enum vw_status make_cameras(struct vw_gpu *gpu, const struct vw_scene *scene, struct vw_buffer **buffer) {
    size_t size_bytes = scene->view_count * sizeof(struct vw_gpu_camera);
    struct vw_gpu_camera *cameras = vw_allocate(scene->view_count, sizeof *cameras);
    if (!cameras) return VW_ERROR_MEMORY;
    for (uint32_t v = 0; v < scene->view_count; v++) cameras[v] = to_gpu_camera(&scene->views[v], &scene->box);
    enum vw_status status =
        vw_buffer_create(gpu, &(struct vw_buffer_params){.name = "recipe cameras", .size_bytes = size_bytes}, buffer);
    if (!status) status = vw_buffer_write(*buffer, 0, cameras, size_bytes);
    free(cameras);
    return status;
}

static enum vw_status make_shapes(struct vw_gpu *gpu, const struct vw_recipe *recipe, struct vw_buffer **buffer) {
    size_t size_bytes = recipe->shape_count * sizeof recipe->shapes[0];
    const struct vw_buffer_params params = {.name = "recipe shapes",
                                            .size_bytes = size_bytes ? size_bytes : sizeof recipe->shapes[0]};
    enum vw_status status = vw_buffer_create(gpu, &params, buffer);
    if (!status && size_bytes) status = vw_buffer_write(*buffer, 0, recipe->shapes, size_bytes);
    return status;
}

static bool any_distortion(const struct vw_scene *scene) {
    for (uint32_t v = 0; v < scene->view_count; v++)
        if (vw_camera_is_distorted(&scene->views[v].camera)) return true;
    return false;
}

static enum vw_status make_pass(struct vw_gpu *gpu, const struct vw_scene *scene, struct vw_recipe_tracer *tracer) {
    const struct vw_specialization specialization = {
        .samples = 1,
        .strata = 1,
        .effect_distortion = any_distortion(scene) ? DISTORTION_BASIC : DISTORTION_NONE,
    };
    const struct vw_binding bindings[] = {
        {.slot = VW_SLOT_CAMERAS, .buffer = tracer->cameras},
        {.slot = VW_SLOT_RECIPE_SHAPES, .buffer = tracer->shapes},
        {.slot = VW_SLOT_RECIPE_PIXELS, .buffer = tracer->pixels},
    };
    uint32_t words[VW_SPECIALIZATION_COUNT];
    memcpy(words, &specialization, sizeof words);
    const struct vw_pass_params params = {.shader = &vw_shader_trace_recipe,
                                          .specialization = words,
                                          .specialization_count = VW_SPECIALIZATION_COUNT,
                                          .bindings = bindings,
                                          .binding_count = VW_ARRAY_COUNT(bindings)};
    return vw_pass_create(gpu, &params, &tracer->pass);
}

enum vw_status vw_recipe_tracer_create(struct vw_gpu *gpu, const struct vw_recipe *recipe, const struct vw_scene *scene,
                                       struct vw_recipe_tracer **tracer) {
    struct vw_recipe_tracer *made = vw_allocate(1, sizeof *made);
    if (!made) return VW_ERROR_MEMORY;
    uint32_t pixel_count = recipe->width_px * recipe->height_px;
    made->recipe = recipe;
    made->edge_world = 2 * scene->box.half_extent_world;
    made->range_pixels = pixel_count < RANGE_PIXELS_MAX ? pixel_count : RANGE_PIXELS_MAX;
    const struct vw_buffer_params pixels = {.name = "recipe pixels",
                                            .size_bytes = made->range_pixels * sizeof(struct vw_recipe_pixel),
                                            .memory = VW_BUFFER_READBACK};
    enum vw_status status = make_cameras(gpu, scene, &made->cameras);
    if (!status) status = make_shapes(gpu, recipe, &made->shapes);
    if (!status) status = vw_buffer_create(gpu, &pixels, &made->pixels);
    if (!status) status = make_pass(gpu, scene, made);
    if (!status) status = vw_submission_create(gpu, &made->submission);
    if (status) vw_recipe_tracer_destroy(&made);
    else *tracer = made;
    return status;
}

void vw_recipe_tracer_destroy(struct vw_recipe_tracer **tracer) {
    struct vw_recipe_tracer *ending = *tracer;
    if (!ending) return;
    vw_submission_destroy(&ending->submission);
    vw_pass_destroy(&ending->pass);
    vw_buffer_destroy(&ending->pixels);
    vw_buffer_destroy(&ending->shapes);
    vw_buffer_destroy(&ending->cameras);
    free(ending);
    *tracer = NULL;
}

// Returns the sun of one photo: rotated about z by a random angle.
static void sun_of_view(const struct vw_recipe *recipe, uint32_t view, double sun[3]) {
    uint32_t words[4];
    float normals[2];
    vw_random_words(recipe->seed, VW_RANDOM_RECIPE, 0, view, VW_DRAW_SUN, words);
    vw_recipe_draw_normals(words[0], words[1], normals);
    double turn = recipe->sun_spread_deg * normals[0] * M_PI / 180, c = cos(turn), s = sin(turn);
    const double *mean = recipe->sun_direction;
    memcpy(sun, (double[3]){c * mean[0] - s * mean[1], s * mean[0] + c * mean[1], mean[2]}, 3 * sizeof *sun);
}

enum vw_status vw_recipe_trace(struct vw_recipe_tracer *tracer, uint32_t view, struct vw_recipe_photo *photo) {
    const struct vw_recipe *recipe = tracer->recipe;
    double sun[3];
    sun_of_view(recipe, view, sun);
    const float *background = recipe->background_colour;
    struct vw_push_recipe push = {
        .view = view,
        .width_px = recipe->width_px,
        .samples_side = recipe->samples_side,
        .shape_count = recipe->shape_count,
        .background = recipe->background,
        .seed = (uint32_t)recipe->seed,
        .ambient = (float)recipe->ambient,
        .sun = {(float)sun[0], (float)sun[1], (float)sun[2], (float)recipe->sun_intensity},
        .background_colour = {background[0], background[1], background[2], 1},
    };
    uint32_t pixel_count = recipe->width_px * recipe->height_px;
    for (; push.first_pixel < pixel_count; push.first_pixel += push.pixel_count) {
        uint32_t left = pixel_count - push.first_pixel;
        push.pixel_count = left < tracer->range_pixels ? left : tracer->range_pixels;
        vw_submission_begin(tracer->submission);
        vw_submission_dispatch(tracer->submission, tracer->pass, &push, sizeof push, push.pixel_count);
        enum vw_status status = vw_submission_submit(tracer->submission);
        if (!status) status = vw_submission_wait(tracer->submission);
        if (status) return status;
        memcpy(photo->pixels + push.first_pixel, vw_buffer_map(tracer->pixels),
               push.pixel_count * sizeof *photo->pixels);
    }
    for (uint32_t i = 0; i < pixel_count; i++) photo->pixels[i].depth *= (float)tracer->edge_world;
    return VW_OK;
}
