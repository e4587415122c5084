// generate_rays against the reference's line through the pixel, straight from the view in double, and against its
// targets, corrected by their photos.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "gpu/compute.h"
#include "kernels/checks/check.h"
#include "train/effects/field_box.h"

static const double NEAR_EDGES = 0.02;     // contract of generate_rays: nothing nearer to the camera is seen
static const double LINE_TOLERANCE = 1e-6; // box edges: directions and origins are floats, rays run up to 5 edges
static const double FACE_TOLERANCE = 1e-6; // box edges, across a face
static const double CLEAR_MARGIN = 1e-3;   // box edges: a line that misses the box by less may be called either way
static const uint64_t STEP = UINT64_C(3) << 32 | 7;
static const double TARGET_TOLERANCE = 1e-6; // relative, of a mix of colours up to 1 or of corrected ones beyond

// Takes the up vector only as a hint.
void rays_look(struct vw_view *view, const struct vw_box *box, const double position[3], const double target[3]) {
    double back[3], right[3], length = 0.0;
    for (int i = 0; i < 3; i++) back[i] = position[i] - target[i];
    for (int i = 0; i < 3; i++) length += back[i] * back[i];
    for (int i = 0; i < 3; i++) back[i] /= sqrt(length);
    double hint[3] = {0, 0, fabs(back[2]) < 0.9}; // else along y
    if (hint[2] == 0.0) hint[1] = 1.0;
    for (int i = 0; i < 3; i++)
        right[i] = hint[(i + 1) % 3] * back[(i + 2) % 3] - hint[(i + 2) % 3] * back[(i + 1) % 3];
    length = sqrt(right[0] * right[0] + right[1] * right[1] + right[2] * right[2]);
    for (int i = 0; i < 3; i++) right[i] /= length;
    for (int i = 0; i < 3; i++) {
        view->camera_to_world[i][0] = right[i];
        view->camera_to_world[i][1] = back[(i + 1) % 3] * right[(i + 2) % 3] - back[(i + 2) % 3] * right[(i + 1) % 3];
        view->camera_to_world[i][2] = back[i];
        view->camera_to_world[i][3] = box->centre_world[i] + (position[i] - 0.5) * 2.0 * box->half_extent_world;
    }
}

struct vw_box rays_box(const struct step_bench *bench) {
    struct vw_box box = bench->scene->box;
    if (bench->model.specialization.effect_unbounded)
        assert_int_equal(vw_contraction_box(bench->scene, NULL, 0, &box), VW_OK);
    return box;
}

struct vw_ray *rays_make(struct step_bench *bench) {
    struct vw_gpu_camera cameras[3];
    struct vw_box box = rays_box(bench);
    for (uint32_t i = 0; i < 3; i++) cameras[i] = vw_field_camera(&bench->model, &bench->scene->views[i], &box);
    struct vw_push_rays push = {.ray_count = bench->config.rays, .key = vw_model_key_of_step(&bench->model, STEP)};
    test_write(bench->field.cameras, cameras);
    memcpy(vw_buffer_map(bench->pixel_buffer), bench->pixels, bench->config.rays * sizeof *bench->pixels);
    step_bench_dispatch(bench, bench->volume->gradient.of_rays.generate, &push, sizeof push, bench->step.padded_rays);
    return test_read(bench->step.ray_buffer);
}

static void point_at(const struct reference_ray *ray, double parameter, double point[3]) {
    for (int i = 0; i < 3; i++) point[i] = ray->origin[i] + parameter * ray->direction[i];
}

// ---- Distances in box coordinates, where the box is the unit cube
// ----------------------------------------------------

static double distance(const double a[3], const double b[3]) {
    return sqrt(pow(a[0] - b[0], 2.0) + pow(a[1] - b[1], 2.0) + pow(a[2] - b[2], 2.0));
}

// Returns the distance of a point to a line whose `direction` has unit length.
static double distance_to_line(const double point[3], const double origin[3], const double direction[3]) {
    double along = 0.0, foot[3];
    for (int i = 0; i < 3; i++) along += (point[i] - origin[i]) * direction[i];
    for (int i = 0; i < 3; i++) foot[i] = origin[i] + along * direction[i];
    return distance(point, foot);
}

// Returns the distance of a point to the box's surface, inside or outside.
static double distance_to_face(const double point[3]) {
    double outside = 0.0, inside = 1.0;
    for (int i = 0; i < 3; i++) {
        outside = fmax(outside, fmax(-point[i], point[i] - 1.0));
        inside = fmin(inside, fmax(fmin(point[i], 1.0 - point[i]), 0.0));
    }
    return fmax(outside, inside);
}

// ---- Checks
// ----------------------------------------------------------------------------------------------------------

// Checks that both ends of the span lie on the reference's line, the far one on a face, the near one on a face or at
// the near distance from the camera. Returns whether the ray hits the box.
static bool check_ray(const struct step_bench *bench, uint32_t index, const struct vw_ray *device, double scale) {
    const struct vw_pixel *pixel = &bench->pixels[index];
    const struct vw_view *view = &bench->scene->views[pixel->view];
    struct reference_ray ray = reference_ray_of(device);
    double origin[3], direction[3], near, far, entry[3], leave[3];
    assert_true(reference_camera_line(view, &bench->scene->box, pixel->x_px, pixel->y_px, origin, direction));
    if (!reference_box_span(origin, direction, NEAR_EDGES, CLEAR_MARGIN, &near, &far)) {
        if (ray.stride != 0.0) fail_msg("%s: ray %u misses the box but has stride %g", bench->where, index, ray.stride);
        return false;
    }
    if (!reference_box_span(origin, direction, NEAR_EDGES, -CLEAR_MARGIN, &near, &far) ||
        far - near < 10.0 * CLEAR_MARGIN)
        return false; // either way
    assert_true(ray.stride > 0.0);
    point_at(&ray, ray.near, entry);
    point_at(&ray, ray.near + ray.stride * bench->config.samples, leave);
    check_value(bench->where, "entry off the line", index, distance_to_line(entry, origin, direction), 0.0,
                scale * LINE_TOLERANCE);
    check_value(bench->where, "exit off the line", index, distance_to_line(leave, origin, direction), 0.0,
                scale * LINE_TOLERANCE);
    check_value(bench->where, "exit off the faces", index, distance_to_face(leave), 0.0, FACE_TOLERANCE);
    bool at_camera = fabs(distance(entry, origin) - NEAR_EDGES) < FACE_TOLERANCE;
    if (!at_camera)
        check_value(bench->where, "entry off the faces", index, distance_to_face(entry), 0.0, FACE_TOLERANCE);
    assert_true(distance(leave, origin) > distance(entry, origin) &&
                distance(entry, origin) >= NEAR_EDGES - FACE_TOLERANCE);
    check_value(bench->where, "length of the direction", index,
                hypot(hypot(ray.direction[0], ray.direction[1]), ray.direction[2]), 1.0, 1e-6);
    return true;
}

// Depths, in box edges, between which a view's samples lie with the effect unbounded: what field_box.c promises.
static void expect_depths(const struct vw_view *view, const struct vw_box *box, const double camera[3],
                          double depths[2]) {
    double edge_world = 2.0 * box->half_extent_world, from_centre = distance(camera, (const double[3]){0.5, 0.5, 0.5});
    bool known = view->far_world > 0.0;
    depths[0] =
        known ? fmax(0.9 * view->near_world / edge_world, 1.0 / 16.0) : fmax((from_centre - 0.5) / 2.0, 1.0 / 8.0);
    depths[1] = fmax(1.1 * view->far_world / edge_world, from_centre + 1000.0);
}

// Checks, with the effect unbounded, that the origin lies on the reference's line at the near distance. Floats round it
// by its distance from the box.
static void check_unbounded_ray(const struct step_bench *bench, uint32_t index, const struct vw_ray *device,
                                double scale) {
    const struct vw_pixel *pixel = &bench->pixels[index];
    const struct vw_view *view = &bench->scene->views[pixel->view];
    struct vw_box box = rays_box(bench);
    struct reference_ray ray = reference_ray_of(device);
    double origin[3], direction[3], depths[2], forward = 0.0, expected[3];
    assert_true(reference_camera_line(view, &box, pixel->x_px, pixel->y_px, origin, direction));
    expect_depths(view, &box, origin, depths);
    for (int i = 0; i < 3; i++) forward -= direction[i] * view->camera_to_world[i][2];
    for (int i = 0; i < 3; i++) expected[i] = origin[i] + depths[0] / forward * direction[i];
    double tolerance = scale * LINE_TOLERANCE * (1.0 + distance(expected, (const double[3]){0.5, 0.5, 0.5}));
    check_value(bench->where, "near distance", index, ray.near * forward / depths[0], 1.0, 1e-6);
    check_value(bench->where, "far distance", index, ray.far * forward / depths[1], 1.0, 1e-6);
    check_value(bench->where, "origin off the line", index, distance_to_line(ray.origin, origin, direction), 0.0,
                tolerance);
    check_value(bench->where, "origin off the near distance", index, distance(ray.origin, expected), 0.0,
                tolerance + 1e-6 * depths[0] / forward);
    for (int i = 0; i < 3; i++) check_value(bench->where, "direction", index, ray.direction[i], direction[i], 1e-6);
}

static void check_target(const struct step_bench *bench, uint32_t index, const struct vw_ray *device) {
    const struct vw_pixel *pixel = &bench->pixels[index < bench->config.rays ? index : bench->config.rays - 1];
    const double found[3] = {device->target_weight.x, device->target_weight.y, device->target_weight.z};
    const struct reference_photo photo = reference_photo_of(&bench->model, bench->params, pixel->view);
    double target[3];
    reference_target(&bench->model.specialization, &photo, pixel, index, vw_model_key_of_step(&bench->model, STEP),
                     target);
    for (int c = 0; c < 3; c++)
        check_value(bench->where, "target", index, found[c], target[c], TARGET_TOLERANCE * fmax(1.0, fabs(target[c])));
    bool as_stored = largest(photo.gain, 3) == 0.0 && largest(photo.bias, 3) == 0.0;
    if (as_stored && !bench->model.specialization.effect_background)
        for (int c = 0; c < 3; c++) // a corrected -0 is a 0
            check_value(bench->where, "target as it is stored", index, found[c], (&pixel->rgba.x)[c], 0.0);
    check_value(bench->where, "weight", index, device->target_weight.w,
                index < bench->config.rays ? pixel->weight : 0.0, 0.0);
}

uint32_t rays_check(struct step_bench *bench, double scale) {
    struct vw_ray *rays = rays_make(bench);
    uint32_t hits = 0;
    for (uint32_t i = 0; i < bench->step.padded_rays; i++) {
        check_target(bench, i, &rays[i]);
        if (i >= bench->config.rays) continue;
        if (!bench->model.specialization.effect_unbounded) {
            hits += check_ray(bench, i, &rays[i], scale);
            continue;
        }
        check_unbounded_ray(bench, i, &rays[i], scale);
        hits++; // no ray of an unbounded scene misses it
    }
    return hits;
}

// ---- The check ------------------------------------------------------------------------------------------------------

// Colours and coverage of the kind, within [0,1].
static void paint(struct step_bench *bench, enum input_kind kind) {
    struct test_random random = {.seed = bench->config.seed};
    for (uint32_t i = 0; i < bench->config.rays; i++) {
        vw_float4 *rgba = &bench->pixels[i].rgba;
        if (kind == INPUT_ORDINARY) {
            bench->pixels[i].weight = i % 7 != 3; // some are excluded
            continue;
        }
        *rgba =
            (vw_float4){fminf(fabsf(input_draw(kind, &random)), 1.0f), fminf(fabsf(input_draw(kind, &random)), 1.0f),
                        0.0f * input_draw(kind, &random), fminf(fabsf(input_draw(kind, &random)), 1.0f)};
    }
}

// Gives photos gains and biases of the kind, where they have any; those of blue are the least, but where all are 0.
static void correct_photos(struct step_bench *bench, enum input_kind kind) {
    const struct vw_param_range *range = &bench->model.ranges[VW_SLOT_APPEARANCE];
    struct test_random random = {.seed = bench->config.seed + 1};
    float *photos = bench->params + range->offset_bytes / sizeof(float);
    bool zero = kind == INPUT_ZERO || kind == INPUT_NEGATIVE_ZERO;
    for (size_t i = 0; i < range->size_bytes / sizeof(float) && kind != INPUT_ORDINARY; i++)
        photos[i] = zero || i % 4 == 3 ? 0.0f : i % 8 == 2 ? -0.9f : input_draw(kind, &random);
    step_bench_write_params(bench);
}

// Places the camera far away with a long lens, near with a wide one, with the longest lens, or along the axes, forwards
// and backwards.
static void place_camera(struct step_bench *bench, enum input_kind kind) {
    static const double middle[3] = {0.5, 0.5, 0.5};
    static const struct {
        double position[3], focal_px;
    } places[INPUT_KINDS] = {
        [INPUT_LARGE] = {{6e5, -4.8e5, 6.4e5}, 1.2e7}, [INPUT_TINY] = {{0.4, 0.6, 0.5}, 1.0},
        [INPUT_ZERO] = {{2.0, 0.5, 0.5}, 24.0},        [INPUT_NEGATIVE_ZERO] = {{-2.0, 0.5, 0.5}, 24.0},
        [INPUT_DENORMAL] = {{0.5, 3.0, 0.5}, 24.0},    [INPUT_SATURATING] = {{1.5, 2.5, -0.5}, 1e6},
    };
    struct vw_view *view = &bench->scene->views[0];
    if (kind == INPUT_ORDINARY) return;
    rays_look(view, &bench->scene->box, places[kind].position, middle);
    view->camera.focal_x_px = places[kind].focal_px;
    view->camera.focal_y_px = 1.1 * places[kind].focal_px;
    view->camera.k1 = 0.0; // the lens is bent for focal lengths like the photo's width
    for (uint32_t i = 0; i < bench->config.rays; i++) bench->pixels[i].view = 0;
}

void check_generate_rays(struct step_bench *bench, enum input_kind kind) {
    struct vw_view kept = bench->scene->views[0];
    size_t pixel_bytes = bench->config.rays * sizeof *bench->pixels;
    struct vw_pixel *pixels = test_allocate(bench->config.rays, sizeof *pixels);
    float *params = test_allocate(bench->model.param_bytes, 1);
    memcpy(params, bench->params, bench->model.param_bytes);
    memcpy(pixels, bench->pixels, pixel_bytes);
    correct_photos(bench, kind);
    paint(bench, kind);
    place_camera(bench, kind);
    // Within the box at a focal length of 1 px, positions at the photo's rim are 12 focal lengths off the axis.
    uint32_t hits = rays_check(bench, kind == INPUT_TINY ? 4.0 : 1.0);
    if (hits < bench->config.rays / 4) fail_msg("%s: only %u rays hit the box", bench->where, hits);
    memcpy(bench->pixels, pixels, pixel_bytes);
    memcpy(bench->params, params, bench->model.param_bytes);
    step_bench_write_params(bench);
    bench->scene->views[0] = kept;
    rays_make(bench); // cameras and pixels as they were
}
