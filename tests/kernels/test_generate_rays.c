// generate_rays against the twin's line through the pixel, straight from the view in double: near and far cameras, cameras in the box, rays
// that miss, graze or run along an axis, distortion, padding, excluded pixels.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "reference/reference.h"
#include "reference/step_bench.h"
#include "train/pixels.h"
#include "viewworth/memory.h"

static const double NEAR_EDGES = 0.02;       // of generate_rays' contract: nothing nearer to the camera is seen
static const double LINE_TOLERANCE = 1e-6;   // box edges: directions and origins are floats, rays run up to 5 edges
static const double FACE_TOLERANCE = 1e-6;   // box edges, across a face
static const double CLEAR_MARGIN = 1e-3;     // box edges: a line that misses the box by less may be called either way
static const double REPROJECTION_PX = 0.01;  // the bound
static const double TARGET_TOLERANCE = 1e-6; // a mix of colours up to 1

static const struct step_case plain = {.name = "pinhole", .seed = 121, .levels = 2, .log2_table = 4, .width = 16, .rays = 300};
static const struct step_case bent = {.name = "distortion and background",
                                      .seed = 122,
                                      .levels = 2,
                                      .log2_table = 4,
                                      .width = 16,
                                      .rays = 300,
                                      .distortion = true,
                                      .background = true};

// Places view 0's camera; `position` and `target` in box coordinates, the up vector only a hint.
static void look(struct vw_view *view, const struct vw_box *box, const double position[3], const double target[3]) {
    double back[3], right[3], length = 0.0;
    for (int i = 0; i < 3; i++) back[i] = position[i] - target[i];
    for (int i = 0; i < 3; i++) length += back[i] * back[i];
    for (int i = 0; i < 3; i++) back[i] /= sqrt(length);
    double hint[3] = {0, 0, fabs(back[2]) < 0.9}; // else along y
    if (hint[2] == 0.0) hint[1] = 1.0;
    for (int i = 0; i < 3; i++) right[i] = hint[(i + 1) % 3] * back[(i + 2) % 3] - hint[(i + 2) % 3] * back[(i + 1) % 3];
    length = sqrt(right[0] * right[0] + right[1] * right[1] + right[2] * right[2]);
    for (int i = 0; i < 3; i++) right[i] /= length;
    for (int i = 0; i < 3; i++) {
        view->camera_to_world[i][0] = right[i];
        view->camera_to_world[i][1] = back[(i + 1) % 3] * right[(i + 2) % 3] - back[(i + 2) % 3] * right[(i + 1) % 3];
        view->camera_to_world[i][2] = back[i];
        view->camera_to_world[i][3] = box->centre_world[i] + (position[i] - 0.5) * 2.0 * box->half_extent_world;
    }
}

static struct vw_ray *run(struct step_bench *bench) {
    struct vw_gpu_camera cameras[3];
    for (uint32_t i = 0; i < 3; i++) cameras[i] = pixels_camera(&bench->scene->views[i], &bench->scene->box);
    struct vw_push_rays push = {.ray_count = bench->config.rays};
    step_bench_write(bench, bench->field.cameras, cameras);
    memcpy(vw_buffer_map(bench->pixel_buffer), bench->pixels, bench->config.rays * sizeof *bench->pixels);
    step_bench_dispatch(bench, bench->step.generate, &push, sizeof push, bench->step.padded_rays);
    return step_bench_read(bench, bench->step.ray_buffer);
}

static void point_at(const struct reference_ray *ray, double parameter, double point[3]) {
    for (int i = 0; i < 3; i++) point[i] = ray->origin[i] + parameter * ray->direction[i];
}

static double distance_to_line(const double point[3], const double origin[3], const double direction[3]) {
    double along = 0.0, distance2 = 0.0;
    for (int i = 0; i < 3; i++) along += (point[i] - origin[i]) * direction[i];
    for (int i = 0; i < 3; i++) distance2 += pow(point[i] - origin[i] - along * direction[i], 2.0);
    return sqrt(distance2);
}

// How far a point is from the surface of the unit cube.
static double distance_to_face(const double point[3]) {
    double outside = 0.0, inside = 1.0;
    for (int i = 0; i < 3; i++) {
        outside = fmax(outside, fmax(-point[i], point[i] - 1.0));
        inside = fmin(inside, fmax(fmin(point[i], 1.0 - point[i]), 0.0));
    }
    return fmax(outside, inside);
}

static double distance(const double a[3], const double b[3]) {
    return sqrt(pow(a[0] - b[0], 2.0) + pow(a[1] - b[1], 2.0) + pow(a[2] - b[2], 2.0));
}

// Both ends of the span lie on the twin's line, the far one on a face, the near one on a face or at the near distance from the camera.
// Returns whether the ray hits the box.
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
    if (!reference_box_span(origin, direction, NEAR_EDGES, -CLEAR_MARGIN, &near, &far) || far - near < 10.0 * CLEAR_MARGIN)
        return false; // either way
    assert_true(ray.stride > 0.0);
    point_at(&ray, ray.near, entry);
    point_at(&ray, ray.near + ray.stride * bench->config.samples, leave);
    check_value(bench->where, "entry off the line", index, distance_to_line(entry, origin, direction), 0.0, scale * LINE_TOLERANCE);
    check_value(bench->where, "exit off the line", index, distance_to_line(leave, origin, direction), 0.0, scale * LINE_TOLERANCE);
    check_value(bench->where, "exit off the faces", index, distance_to_face(leave), 0.0, FACE_TOLERANCE);
    bool at_camera = fabs(distance(entry, origin) - NEAR_EDGES) < FACE_TOLERANCE;
    if (!at_camera) check_value(bench->where, "entry off the faces", index, distance_to_face(entry), 0.0, FACE_TOLERANCE);
    assert_true(distance(leave, origin) > distance(entry, origin) && distance(entry, origin) >= NEAR_EDGES - FACE_TOLERANCE);
    check_value(bench->where, "length of the direction", index, hypot(hypot(ray.direction[0], ray.direction[1]), ray.direction[2]), 1.0,
                1e-6);
    return true;
}

static void check_target(const struct step_bench *bench, uint32_t index, const struct vw_ray *device) {
    const struct vw_pixel *pixel = &bench->pixels[index < bench->config.rays ? index : bench->config.rays - 1];
    const double found[3] = {device->target_weight.x, device->target_weight.y, device->target_weight.z};
    double target[3];
    reference_target(&bench->model.specialization, pixel, target);
    for (int c = 0; c < 3; c++) check_value(bench->where, "target", index, found[c], target[c], TARGET_TOLERANCE);
    check_value(bench->where, "weight", index, device->target_weight.w, index < bench->config.rays ? pixel->weight : 0.0, 0.0);
}

static uint32_t check_rays(struct step_bench *bench, double scale) {
    struct vw_ray *rays = run(bench);
    uint32_t hits = 0;
    for (uint32_t i = 0; i < bench->step.padded_rays; i++) {
        check_target(bench, i, &rays[i]);
        if (i < bench->config.rays) hits += check_ray(bench, i, &rays[i], scale);
    }
    free(rays);
    return hits;
}

static void orbiting_cameras(void **state) {
    (void)state;
    const struct step_case *setups[] = {&plain, &bent};
    for (int i = 0; i < 2; i++) {
        struct step_bench *bench = step_bench_open(setups[i]);
        for (uint32_t k = 0; k < 10; k++) bench->pixels[7 * k].weight = 0.0f; // excluded
        assert_true(check_rays(bench, 1.0) > 100);
        step_bench_close(bench);
    }
}

// In box coordinates; all look at `target` through a wide lens so that some rays miss.
static void cameras_in_and_around_the_box(void **state) {
    (void)state;
    static const struct {
        double position[3], target[3];
        bool hits;
    } cameras[] = {
        {{0.5, 0.5, 0.5}, {1.0, 0.6, 0.4}, true},    {{0.01, 0.01, 0.01}, {1.0, 1.0, 1.0}, true},
        {{0.5, 0.5, 3.9}, {0.5, 0.5, 0.5}, true},    {{4.6, 0.5, 0.5}, {0.5, 0.5, 0.5}, true},
        {{-3.0, -3.0, -3.0}, {0.5, 0.5, 0.5}, true}, {{2.0, 0.5, 0.5}, {3.0, 0.5, 0.5}, false},
        {{0.999, 0.5, 0.5}, {2.0, 0.5, 0.5}, false}, {{30.0, 20.0, 10.0}, {60.0, 40.0, 20.0}, false},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(cameras); i++) {
        struct step_bench *bench = step_bench_open(&plain);
        struct vw_view *view = &bench->scene->views[0];
        view->camera.focal_x_px = view->camera.focal_y_px = 10.0;
        look(view, &bench->scene->box, cameras[i].position, cameras[i].target);
        for (uint32_t k = 0; k < bench->config.rays; k++) bench->pixels[k].view = 0;
        uint32_t hits = check_rays(bench, 2.0);
        if ((hits > 0) != cameras[i].hits) fail_msg("camera %zu: %u rays hit", i, hits);
        step_bench_close(bench);
    }
}

// The centre pixel looks exactly along an axis: two components of the direction are 0.
static void rays_along_axes_and_in_faces_are_finite(void **state) {
    (void)state;
    static const double offsets[] = {0.5, 0.0, 1.0, -0.25, 1.25, 0.3};
    for (int axis = 0; axis < 6; axis++) {
        for (size_t i = 0; i < VW_ARRAY_COUNT(offsets); i++) {
            struct step_bench *bench = step_bench_open(&plain);
            struct vw_view *view = &bench->scene->views[0];
            double position[3] = {0.5, 0.5, 0.5}, target[3] = {0.5, 0.5, 0.5};
            position[axis % 3] = axis < 3 ? 2.0 : -2.0;
            position[(axis + 1) % 3] = target[(axis + 1) % 3] = offsets[i];
            look(view, &bench->scene->box, position, target);
            for (uint32_t k = 0; k < bench->config.rays; k++)
                bench->pixels[k] =
                    (struct vw_pixel){.x_px = (float)view->camera.centre_x_px, .y_px = (float)view->camera.centre_y_px, .weight = 1.0f};
            struct vw_ray *rays = run(bench);
            struct reference_ray ray = reference_ray_of(&rays[0]);
            assert_true(isfinite(ray.near) && isfinite(ray.stride) && ray.stride >= 0.0);
            if (offsets[i] == 0.5 || offsets[i] == 0.3)
                check_value(bench->where, "length within the box", 0, ray.stride * bench->config.samples, 1.0, 2e-6);
            if (offsets[i] < 0.0 || offsets[i] > 1.0) assert_true(ray.stride == 0.0);
            free(rays);
            step_bench_close(bench);
        }
    }
}

// A camera 10^3 to 10^6 box edges away, with a lens as long: its rays hit the box where double says.
static void far_cameras_lose_no_bits(void **state) {
    (void)state;
    static const double distances[] = {10.0, 1e3, 1e6};
    for (size_t i = 0; i < VW_ARRAY_COUNT(distances); i++) {
        struct step_bench *bench = step_bench_open(&plain);
        struct vw_view *view = &bench->scene->views[0];
        const double direction[3] = {0.6, -0.48, 0.64}, target[3] = {0.5, 0.5, 0.5};
        double position[3];
        for (int k = 0; k < 3; k++) position[k] = 0.5 + distances[i] * direction[k];
        look(view, &bench->scene->box, position, target);
        view->camera.focal_x_px = view->camera.focal_y_px = 12.0 * distances[i]; // the box fills the photo
        for (uint32_t k = 0; k < bench->config.rays; k++) bench->pixels[k].view = 0;
        assert_true(check_rays(bench, 1.0) > 100);
        step_bench_close(bench);
    }
}

// World coordinates of 10^6 metres, and boxes of a millimetre and of a kilometre: the field sees the same rays.
static void the_world_may_be_anywhere_and_of_any_size(void **state) {
    (void)state;
    static const double scales[] = {1.0, 1e-3, 1e3};
    struct step_bench *bench = step_bench_open(&plain);
    for (size_t i = 0; i < VW_ARRAY_COUNT(scales); i++) {
        struct vw_scene *moved = synthetic_scene(&(struct synthetic_scene_params){
            .train_views = 2, .val_views = 1, .width_px = 24, .height_px = 20, .world_offset = 1e6, .world_scale = scales[i]});
        struct vw_scene *kept = bench->scene;
        bench->scene = moved;
        // The double position itself is only good to 1e6 * 2^-53 metres.
        uint32_t hits = check_rays(bench, 1.0 + 1e6 * 0x1p-53 / scales[i] / LINE_TOLERANCE);
        bench->scene = kept;
        vw_scene_close(&moved);
        assert_true(hits > 100);
    }
    step_bench_close(bench);
}

// Distortion undone: the direction projects back to the pixel, over the whole photo and for strong lenses.
static void undistorted_rays_reproject_to_their_pixel(void **state) {
    (void)state;
    static const double lenses[][4] = {{-0.15, 0.0, 0.0, 0.0}, {-0.3, 0.12, 0.002, -0.003}, {0.25, -0.08, -0.01, 0.008},
                                       {0.0, 0.0, 0.02, 0.02}, {-0.05, 0.01, 0.0, 0.0},     {0.5, -0.1, 0.0, 0.0},
                                       {2.0, 2.0, 0.0, 0.0},   {8.0, 20.0, 0.0, 0.0}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(lenses); i++) {
        struct step_bench *bench = step_bench_open(&bent);
        struct vw_view *view = &bench->scene->views[0];
        view->camera = (struct vw_camera){.width_px = 1920,
                                          .height_px = 1080,
                                          .focal_x_px = 1400.0,
                                          .focal_y_px = 1420.0,
                                          .centre_x_px = 951.5,
                                          .centre_y_px = 548.25,
                                          .k1 = lenses[i][0],
                                          .k2 = lenses[i][1],
                                          .p1 = lenses[i][2],
                                          .p2 = lenses[i][3]};
        for (uint32_t k = 0; k < bench->config.rays; k++) {
            bench->pixels[k].view = 0;
            bench->pixels[k].x_px = (float)(k % 20 * 101 + (k % 20 < 19 ? 0.5 : 0.0));
            bench->pixels[k].y_px = (float)(k / 20 * 77 + 0.5);
        }
        struct vw_ray *rays = run(bench);
        for (uint32_t k = 0; k < bench->config.rays; k++) {
            struct reference_ray ray = reference_ray_of(&rays[k]);
            double in_camera[3] = {0}, x_px, y_px;
            for (int column = 0; column < 3; column++)
                for (int row = 0; row < 3; row++) in_camera[column] += view->camera_to_world[row][column] * ray.direction[row];
            assert_true(vw_camera_project(&view->camera, in_camera, &x_px, &y_px));
            check_value(bench->where, "reprojected x_px", k, x_px, bench->pixels[k].x_px, REPROJECTION_PX);
            check_value(bench->where, "reprojected y_px", k, y_px, bench->pixels[k].y_px, REPROJECTION_PX);
        }
        free(rays);
        step_bench_close(bench);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(orbiting_cameras),
        cmocka_unit_test(cameras_in_and_around_the_box),
        cmocka_unit_test(rays_along_axes_and_in_faces_are_finite),
        cmocka_unit_test(far_cameras_lose_no_bits),
        cmocka_unit_test(the_world_may_be_anywhere_and_of_any_size),
        cmocka_unit_test(undistorted_rays_reproject_to_their_pixel),
    };
    return cmocka_run_group_tests_name("generate_rays", tests, NULL, step_bench_teardown);
}
