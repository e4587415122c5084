// Hard rays: where a line meets the box, or does not, from cameras that are near, far, inside, or bend their light too
// much; and with the effect unbounded, points that the contraction must not lose, and strata that are next to nothing
// or next to infinite. Each case holds the rays against the reference's line through the pixel, in double, and then a
// whole training step and a rendering with these rays.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "hard_cases/hard_step.h"
#include "scene/builder.h"
#include "train/fields/registry.h"
#include "train/pixels.h"

static const double NEAR_EDGES = 0.02; // distance in generate_rays' contract: nothing nearer to the camera is seen
static const double LENGTH_TOLERANCE = 2e-6;   // box edges, of lines at 45 degrees to the faces
static const double REPROJECTION_PX = 0.01;    // the bound for lenses
static const double POSITION_TOLERANCE = 4e-7; // in edges of the field's cube: eight roundings next to 1
static const double DISTANCE_TOLERANCE = 2e-6; // relative: thirty roundings, of a sum over strata
static const double LIGHT_TOLERANCE = 1e-5;    // the device's exp, and that of a thickness up to 8

enum { SIDE_PX = 8, RAYS = SIDE_PX * SIDE_PX, STEP = 3 };

static const struct step_case setup = {"rays", .seed = 301, HARD_STEP},
                              without_bounds = {"unbounded", .seed = 341, HARD_STEP, .effects = "unbounded"};

// ---- Set-up ---------------------------------------------------------------------------------------------------------

// Opens a bench whose rays all come from view 0 and cover its photo evenly.
static struct step_bench *open_bench(const struct step_case *c) {
    struct step_bench *bench = step_bench_open(c);
    const struct vw_camera *camera = &bench->scene->views[0].camera;
    for (uint32_t i = 0; i < bench->config.rays; i++) {
        bench->pixels[i].view = 0;
        bench->pixels[i].x_px = (float)((i % SIDE_PX + 0.5) * camera->width_px / SIDE_PX);
        bench->pixels[i].y_px = (float)((i / SIDE_PX % SIDE_PX + 0.5) * camera->height_px / SIDE_PX);
    }
    return bench;
}

// Places view 0's camera, in box coordinates.
static void look(struct step_bench *bench, const double position[3], const double target[3], double focal_px) {
    struct vw_view *view = &bench->scene->views[0];
    rays_look(view, &bench->scene->box, position, target);
    view->camera.focal_x_px = view->camera.focal_y_px = focal_px;
}

static void check_whole_step(struct hard_finding *finding, struct step_bench *bench) {
    hard_check_step(finding, bench, STEP);
    hard_check_rendering(finding, bench);
}

// ---- Misses, grazes, insides ----------------------------------------------------------------------------------------

static void rays_that_miss(struct hard_finding *finding) {
    static const struct {
        double position[3], target[3];
    } cameras[] = {{{2.0, 0.5, 0.5}, {3.0, 0.5, 0.5}}, // looks away from the box
                   {{30.0, 20.0, 10.0}, {60.0, 40.0, 20.0}},
                   {{0.5, 0.5, 3.0}, {-1.0, 0.5, 1.0}},  // looks past the box
                   {{-1e4, 0.5, 0.5}, {-1e4, 1.5, 0.5}}, // far away, at a right angle
                   {{1e6, 1e6, 1e6}, {2e6, 2e6, 2e6}}};  // very far away, looks away from the box
    struct step_bench *bench = open_bench(&setup);
    for (size_t i = 0; i < VW_ARRAY_COUNT(cameras); i++) {
        look(bench, cameras[i].position, cameras[i].target, 60.0);
        hard_require(finding, rays_check(bench, 1.0) == 0, "every ray misses");
        float *before = test_read(bench->field.params);
        check_whole_step(finding, bench);
        float *after = test_read(bench->field.params);
        hard_same_bits(finding, "params that no ray met", after, before, bench->model.param_bytes);
    }
}

// Aims the camera exactly at the edge x = 0, z = 1, at 45 degrees to both faces and from 2 edges away: half of the rays
// cut a corner off, by 2^-24 to 1/8 of an edge, the others just miss. The length of the cut is twice the depth.
static void rays_that_graze_an_edge(struct hard_finding *finding) {
    static const double position[3] = {-M_SQRT2, 0.5, 1.0 - M_SQRT2}, target[3] = {0.0, 0.5, 1.0};
    const double focal_px = 100.0;
    struct step_bench *bench = open_bench(&setup);
    look(bench, position, target, focal_px);
    const struct vw_view *view = &bench->scene->views[0];
    for (uint32_t i = 0; i < RAYS; i++) {
        double depth = i == 0 ? 0.0 : exp2(-24.0 + 21.0 * i / RAYS) * (i % 2 ? 1.0 : -1.0);
        bench->pixels[i].x_px = (float)view->camera.centre_x_px;
        bench->pixels[i].y_px = (float)(view->camera.centre_y_px + focal_px * depth / 2.0);
    }
    struct vw_ray *rays = rays_make(bench);
    uint32_t cuts = 0;
    for (uint32_t i = 0; i < RAYS; i++) {
        double origin[3], direction[3], near, far;
        assert_true(reference_camera_line(view, &bench->scene->box, bench->pixels[i].x_px, bench->pixels[i].y_px,
                                          origin, direction));
        bool hit = reference_box_span(origin, direction, NEAR_EDGES, 0.0, &near, &far);
        cuts += hit;
        hard_compare(finding, "length of the cut", i, (double)rays[i].direction_stride.w * bench->config.samples,
                     hit ? far - near : 0.0, 1.0, LENGTH_TOLERANCE);
    }
    hard_require(finding, cuts > RAYS / 4 && cuts < 3 * RAYS / 4, "some rays cut the edge and some miss it");
    check_whole_step(finding, bench);
}

static void rays_that_start_inside(struct hard_finding *finding) {
    static const struct {
        double position[3], target[3];
    } cameras[] = {
        {{0.5, 0.5, 0.5}, {0.5, 0.1, 0.0}},    {{0.5, 0.5, 0.5}, {1.0, 0.6, 0.4}},
        {{0.01, 0.01, 0.01}, {1.0, 1.0, 0.9}}, {{0.999, 0.5, 0.5}, {0.0, 0.5, 0.5}}, // just inside, looking in
        {{0.999, 0.5, 0.5}, {2.0, 0.5, 0.5}}, // just inside, looking out: what is left is nearer than the near distance
    };
    struct step_bench *bench = open_bench(&setup);
    for (size_t i = 0; i < VW_ARRAY_COUNT(cameras); i++) {
        look(bench, cameras[i].position, cameras[i].target, 15.0);
        hard_require(finding, rays_check(bench, 1.0) == (i < 4 ? RAYS : 0),
                     "rays hit unless the near distance hides the rest");
        check_whole_step(finding, bench);
    }
}

// Rays along an axis: two components of the direction are 0. Within a face a ray may hit or miss, but it must not be
// lost.
static void rays_parallel_to_the_box(struct hard_finding *finding) {
    static const double offsets[] = {0.5, 0.3, 1e-3, 0.0, 1.0, -1e-3, -0.25, 1.25};
    struct step_bench *bench = open_bench(&setup);
    struct vw_camera *camera = &bench->scene->views[0].camera;
    for (int axis = 0; axis < 6; axis++) {
        for (size_t i = 0; i < VW_ARRAY_COUNT(offsets); i++) {
            double position[3] = {0.5, 0.5, 0.5}, target[3] = {0.5, 0.5, 0.5},
                   length = offsets[i] > 0.0 && offsets[i] < 1.0;
            position[axis % 3] += axis < 3 ? 2.0 : -2.0;
            position[(axis + 1) % 3] = target[(axis + 1) % 3] = offsets[i];
            look(bench, position, target, 30.0);
            bench->pixels[0].x_px = (float)camera->centre_x_px;
            bench->pixels[0].y_px = (float)camera->centre_y_px;
            struct vw_ray *rays = rays_make(bench);
            double found = (double)rays[0].direction_stride.w * bench->config.samples;
            bool in_face = offsets[i] == 0.0 || offsets[i] == 1.0;
            if (in_face && fabs(found - 1.0) < 0.5) length = 1.0;
            hard_compare(finding, "length within the box", i, found, length, 1.0, LENGTH_TOLERANCE);
            if (axis == 1 || in_face) hard_check_rendering(finding, bench);
        }
    }
    hard_check_step(finding, bench, STEP);
}

// Depths that leave nothing of the box, which lies between 2.5 and 3.5 edges from the camera.
static void rays_of_no_extent(struct hard_finding *finding) {
    static const double depths[][2] = {{1e-6, 1e-5}, {1.0, 2.5}, {3.5, 4.0}, {1e3, 1e6}};
    static const double position[3] = {0.5, 0.5, 3.5}, target[3] = {0.5, 0.5, 0.5};
    struct step_bench *bench = open_bench(&setup);
    struct vw_view *view = &bench->scene->views[0];
    look(bench, position, target, 60.0);
    hard_require(finding, rays_check(bench, 1.0) == RAYS, "without known depths every ray hits");
    for (size_t i = 0; i < VW_ARRAY_COUNT(depths); i++) {
        // vw_pixels_camera() takes nine tenths of near and eleven tenths of far.
        view->near_world = depths[i][0] * 2.0 * bench->scene->box.half_extent_world / 0.9;
        view->far_world = depths[i][1] * 2.0 * bench->scene->box.half_extent_world / 1.1;
        struct vw_ray *rays = rays_make(bench);
        for (uint32_t ray = 0; ray < RAYS; ray++)
            hard_compare(finding, "length of nothing", ray,
                         (double)rays[ray].direction_stride.w * bench->config.samples, 0.0, 1.0, LENGTH_TOLERANCE);
        check_whole_step(finding, bench);
    }
}

// ---- Distances and lenses -------------------------------------------------------------------------------------------

static void look_at_centre(struct step_bench *bench, double distance_edges, double focal_px) {
    static const double back[3] = {0.6, -0.48, 0.64}, centre[3] = {0.5, 0.5, 0.5};
    double position[3];
    for (int i = 0; i < 3; i++) position[i] = centre[i] + distance_edges * back[i];
    look(bench, position, centre, focal_px);
}

static void cameras_far_from_a_small_scene(struct hard_finding *finding) {
    static const double distances[] = {10.0, 1e3, 1e6};
    struct step_bench *bench = open_bench(&setup);
    bench->scene->box.half_extent_world = 0.5; // 1 m
    for (size_t i = 0; i < VW_ARRAY_COUNT(distances); i++) {
        look_at_centre(bench, distances[i], 36.0 * distances[i]);
        hard_require(finding, rays_check(bench, 1.0) == RAYS, "every ray hits");
        check_whole_step(finding, bench);
    }
    look_at_centre(bench, 3.4, 10.0); // through a wide lens
    uint32_t hits = rays_check(bench, 1.0);
    hard_require(finding, hits > 0 && hits < RAYS, "rays at the rim miss");
}

// Moves the camera by 1 m in a box of 10^6 m, where a float next to 1/2 is good to 0.06 m.
static void camera_in_a_huge_scene(struct hard_finding *finding) {
    struct step_bench *bench = open_bench(&setup);
    bench->scene->box.half_extent_world = 5e5;
    for (int i = 0; i < 3; i++) {
        look_at_centre(bench, 0.25 + 1e-6 * i, 20.0);
        hard_require(finding, rays_check(bench, 1.0) == RAYS, "every ray hits");
        check_whole_step(finding, bench);
    }
}

// Checks world coordinates of 10^6 m, where a double is good to 10^-10 m, and boxes of a millimetre and of a kilometre.
static void scenes_far_from_the_origin(struct hard_finding *finding) {
    static const double scales[] = {1.0, 1e-3, 1e3};
    struct step_bench *bench = open_bench(&setup);
    for (size_t i = 0; i < VW_ARRAY_COUNT(scales); i++) {
        bench->scene->box = (struct vw_box){{1e6, -1e6, 1e6}, 0.5 * scales[i]};
        look_at_centre(bench, 3.0, 110.0);
        hard_require(finding, rays_check(bench, 1.0 + 1e6 * 0x1p-53 / scales[i] / 1e-6) == RAYS, "every ray hits");
        check_whole_step(finding, bench);
    }
}

// Checks 24 px through a focal length of 1 px: 85 degrees off the axis.
static void focal_length_of_1_px(struct hard_finding *finding) {
    struct step_bench *bench = open_bench(&setup);
    look_at_centre(bench, 1e-3, 1.0);
    hard_require(finding, rays_check(bench, 1.0) == RAYS, "every ray hits from inside");
    check_whole_step(finding, bench);
    look_at_centre(bench, 1.2, 1.0);
    uint32_t hits = rays_check(bench, 1.0);
    hard_require(finding, hits < RAYS, "rays at the rim miss from outside");
    check_whole_step(finding, bench);
}

// Checks neighbouring pixels that are 10^-6 radians apart: from three edges away a pixel is 3 10^-6 edges wide, three
// times the tolerance.
static void focal_length_of_1e6_px(struct hard_finding *finding) {
    struct step_bench *bench = open_bench(&setup);
    look_at_centre(bench, 3.0, 1e6);
    hard_require(finding, rays_check(bench, 1.0) == RAYS, "every ray hits");
    check_whole_step(finding, bench);
}

// Checks that a ray projects back to its pixel where the lens has an inverse, and is finite and weighs nothing
// elsewhere.
static void check_lens(struct hard_finding *finding, struct step_bench *bench) {
    const struct vw_view *view = &bench->scene->views[0];
    struct vw_ray *rays = rays_make(bench);
    for (uint32_t i = 0; i < bench->config.rays; i++) {
        const struct vw_pixel *pixel = &bench->pixels[i];
        struct reference_ray ray = reference_ray_of(&rays[i]);
        double in_camera[3] = {0}, x_px, y_px;
        bool has_inverse = vw_camera_unproject(&view->camera, pixel->x_px, pixel->y_px, in_camera);
        hard_equal(finding, "weight", i, ray.weight, has_inverse);
        double length2 = pow(ray.direction[0], 2.0) + pow(ray.direction[1], 2.0) + pow(ray.direction[2], 2.0);
        hard_compare(finding, "length of the direction", i, length2, 1.0, 1.0, 1e-6);
        hard_require(finding, isfinite(ray.near) && isfinite(ray.stride), "a ray is finite");
        if (!has_inverse) continue;
        for (int column = 0; column < 3; column++) {
            in_camera[column] = 0.0;
            for (int row = 0; row < 3; row++)
                in_camera[column] += view->camera_to_world[row][column] * ray.direction[row];
        }
        assert_true(vw_camera_project(&view->camera, in_camera, &x_px, &y_px));
        hard_compare(finding, "reprojection (px)", i, hypot(x_px - pixel->x_px, y_px - pixel->y_px), 0.0, 1.0,
                     REPROJECTION_PX);
    }
}

// Checks barrel distortion so strong that the image folds back before the corners: they are masked, the rest is undone.
static void distortion_without_inverse_in_the_corners(struct hard_finding *finding) {
    struct step_case bent = setup;
    bent.effects = "distortion";
    struct step_bench *bench = open_bench(&bent);
    struct vw_view *view = &bench->scene->views[0];
    static const struct vw_camera lenses[] = {{.focal_x_px = 20.0, .focal_y_px = 20.0, .k1 = -0.3},
                                              {.focal_x_px = 12.0, .focal_y_px = 14.0, .k1 = -0.2, .k2 = 0.004}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(lenses); i++) {
        uint64_t hidden = 0;
        uint32_t weightless = 0;
        view->camera.focal_x_px = lenses[i].focal_x_px;
        view->camera.focal_y_px = lenses[i].focal_y_px;
        view->camera.k1 = lenses[i].k1;
        view->camera.k2 = lenses[i].k2;
        assert_int_equal(vw_lens_mask(view, &hidden), VW_OK);
        for (uint32_t k = 0; k < bench->config.rays; k++) {
            uint32_t x_px = k % SIDE_PX * (view->camera.width_px - 1) / (SIDE_PX - 1);
            uint32_t y_px = k / SIDE_PX * (view->camera.height_px - 1) / (SIDE_PX - 1);
            bench->pixels[k] = vw_pixels_at(bench->scene, 0, true, x_px, y_px);
            weightless += bench->pixels[k].weight == 0.0f;
        }
        hard_require(finding, hidden >= 4 && weightless >= 4 && weightless < RAYS / 2,
                     "the corners are masked, and not much more");
        check_lens(finding, bench);
        check_whole_step(finding, bench);
        view->mask = NULL;
    }
}

// ---- The contraction ------------------------------------------------------------------------------------------------

// Returns the positions of the rays' first samples in the field's cube, as forward_field makes them in training: x, y,
// z, 0 of one ray after the other.
static float *locate(struct step_bench *bench, const struct vw_ray *rays) {
    struct vw_push_samples push = step_bench_push(bench, STEP);
    test_write(bench->step.ray_buffer, rays);
    step_bench_dispatch(bench, bench->volume->gradient.field.passes[HASH_FORWARD], &push, sizeof push,
                        bench->padded_samples);
    float *rows = step_bench_read_rows(bench), *positions = test_allocate(RAYS, 4 * sizeof *positions);
    for (uint32_t ray = 0; ray < RAYS; ray++)
        memcpy(positions + 4 * ray,
               step_bench_row(bench, rows, step_bench_rows(bench).position, ray * bench->config.samples),
               4 * sizeof *positions);
    return positions;
}

// Checks points by rays whose samples all lie at their origins, since near and far are the same.
static void check_points(struct hard_finding *finding, struct step_bench *bench, const double (*points)[3],
                         uint32_t count) {
    struct vw_ray rays[RAYS] = {0};
    assert_true(count <= RAYS && bench->step.padded_rays == RAYS);
    for (uint32_t i = 0; i < count; i++) {
        rays[i].origin_near = (vw_float4){(float)points[i][0], (float)points[i][1], (float)points[i][2], 1.0f};
        rays[i].direction_stride = (vw_float4){i % 2 ? 0.0f : 1.0f, 0.0f, 0.0f, 1.0f}; // every other one looks nowhere
    }
    for (uint32_t i = count; i < RAYS; i++) rays[i] = rays[0];
    float *positions = locate(bench, rays);
    for (uint32_t i = 0; i < count; i++) {
        const double point[3] = {rays[i].origin_near.x, rays[i].origin_near.y, rays[i].origin_near.z};
        double expected[3];
        reference_contract(point, expected);
        for (int axis = 0; axis < 3; axis++)
            hard_compare(finding, "contracted position", i, positions[4 * i + axis], expected[axis], 1.0,
                         POSITION_TOLERANCE);
    }
}

// Checks all 26 directions to the neighbours of a cell.
static void contraction_at_all_distances(struct hard_finding *finding) {
    static const double distances[] = {0.0,  1e-30, 1e-8, 0.25, 0.4999999, 0.5,  0.5000001, 0.75,
                                       10.0, 1e3,   1e10, 1e19, 1e20,      1e30, 1.5e38};
    struct step_bench *bench = step_bench_open(&without_bounds);
    for (size_t i = 0; i < VW_ARRAY_COUNT(distances); i++) {
        double points[27][3];
        for (int k = 0; k < 27; k++) {
            const double direction[3] = {k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1};
            double length = hypot(hypot(direction[0], direction[1]), direction[2]);
            for (int axis = 0; axis < 3; axis++)
                points[k][axis] = 0.5 + (length > 0.0 ? distances[i] * direction[axis] / length : 0.0);
        }
        check_points(finding, bench, (const double(*)[3])points, 27);
    }
}

// Checks that neighbouring floats on both sides of the sphere fall on neighbouring places.
static void contraction_across_the_sphere(struct hard_finding *finding) {
    struct step_bench *bench = step_bench_open(&without_bounds);
    struct vw_ray rays[RAYS] = {0};
    for (uint32_t i = 0; i < RAYS; i++) {
        double angle = 0.1 * i;
        float shift = (float)((int)(i % 16) - 8) * 0x1p-24f;
        rays[i].origin_near =
            (vw_float4){(float)(0.5 + 0.5 * cos(angle)) + shift, (float)(0.5 + 0.5 * sin(angle)), 0.5f, 1.0f};
        rays[i].direction_stride = (vw_float4){.x = 1.0f, .w = 1.0f};
    }
    float *positions = locate(bench, rays);
    for (uint32_t i = 0; i < RAYS; i++) { // x and y, which the contraction leaves alone, are halved
        hard_compare(finding, "place next to the sphere", i, positions[4 * i], 0.25 + 0.5 * rays[i].origin_near.x, 1.0,
                     8.0 * 0x1p-24);
        hard_compare(finding, "place next to the sphere", i, positions[4 * i + 1], 0.25 + 0.5 * rays[i].origin_near.y,
                     1.0, 8.0 * 0x1p-24);
    }
}

// ---- Strata ---------------------------------------------------------------------------------------------------------

// Checks that fog of the same density everywhere leaves as much light as one stratum from near to far would.
static void strata_of_any_lengths(struct hard_finding *finding) {
    static const float distances[][2] = {{1.0f, 1.0f}, {1e-3f, 1e-3f},  {0.5f, 0.50000006f}, {1e4f, 1.0001e4f},
                                         {1e4f, 1e7f}, {0.1f, 1e3f},    {1e-6f, 1e6f},       {1e-3f, 1e30f},
                                         {1e6f, 1e6f}, {0.0625f, 1e12f}};
    struct step_bench *bench = step_bench_open(&without_bounds);
    struct vw_evaluator *evaluator = step_bench_evaluator(bench);
    struct vw_push_samples push = {.ray_count = evaluator->ray_count};
    struct vw_ray rays[RAYS] = {0};
    vw_float4 field[RAYS * 16] = {0};
    double length[RAYS], thickness[RAYS];
    assert_true(evaluator->ray_count == RAYS && bench->config.samples == 16);
    for (uint32_t i = 0; i < RAYS; i++) {
        const float *ends = distances[i % VW_ARRAY_COUNT(distances)];
        length[i] = (double)ends[1] - ends[0];
        float density = (float)(length[i] > 0.0 ? 0.125 * (1 + i) / length[i] : 3e6);
        thickness[i] = density * length[i];
        rays[i] = (struct vw_ray){.origin_near.w = ends[0], .direction_stride = {1.0f, 0.0f, 0.0f, ends[1]}};
        for (uint32_t k = 0; k < 16; k++) field[16 * i + k] = (vw_float4){1.0f, 0.5f, 0.0f, density};
    }
    test_write(evaluator->rays, rays);
    test_write(vw_volume_evaluation_of(evaluator)->samples, field);
    step_bench_dispatch(bench, vw_volume_evaluation_of(evaluator)->composite, &push, sizeof push,
                        step_bench_lanes(bench, push.ray_count));
    vw_float4 *colours = test_read(evaluator->colours);
    for (uint32_t i = 0; i < RAYS; i++) {
        double left = exp(-thickness[i]);
        hard_compare(finding, "light that is left", i, colours[i].w, left, 1.0,
                     LIGHT_TOLERANCE + DISTANCE_TOLERANCE * thickness[i]);
        hard_compare(finding, "colour of the fog", i, colours[i].x, 1.0 - left, 1.0,
                     LIGHT_TOLERANCE + DISTANCE_TOLERANCE * thickness[i]);
        if (length[i] == 0.0) hard_equal(finding, "light that nothing holds up", i, colours[i].w, 1.0);
    }
}

// ---- Cameras without bounds -----------------------------------------------------------------------------------------

static void check_camera(struct hard_finding *finding, struct step_bench *bench) {
    hard_require(finding, rays_check(bench, 1.0) == RAYS, "every ray has samples");
    check_whole_step(finding, bench);
}

// Checks cameras at the centre, on the sphere and outside, which look in, out and along axes.
static void cameras_in_and_around_the_ball(struct hard_finding *finding) {
    static const struct {
        double position[3], target[3];
    } cameras[] = {{{0.5, 0.5, 0.5}, {1.0, 0.5, 0.5}}, {{0.5, 0.5, 0.5}, {0.1, 0.9, 0.3}},
                   {{1.0, 0.5, 0.5}, {0.0, 0.5, 0.5}}, {{0.5, 0.5, 1.0}, {0.5, 0.5, 3.0}},
                   {{0.5, 2.5, 0.5}, {0.5, 0.5, 0.5}}, {{2.0, -3.0, 1.0}, {5.0, -9.0, 2.0}}};
    struct step_bench *bench = open_bench(&without_bounds);
    struct vw_view *view = &bench->scene->views[0];
    for (size_t i = 0; i < VW_ARRAY_COUNT(cameras); i++) {
        rays_look(view, &bench->scene->box, cameras[i].position, cameras[i].target);
        bench->pixels[0].x_px = (float)view->camera.centre_x_px; // exactly along the axis
        bench->pixels[0].y_px = (float)view->camera.centre_y_px;
        check_camera(finding, bench);
    }
}

// Looks at the centre of the ball, which fills the photo.
static void look_at_ball(struct step_bench *bench, double distance_edges) {
    look_at_centre(bench, distance_edges, 24.0 * fmax(distance_edges, 1.0));
}

// Checks that a ray begins next to what it sees where points tell the depths, as precisely as from a camera nearby.
static void cameras_far_away(struct hard_finding *finding) {
    static const double distances[] = {10.0, 1e4, 1e6};
    struct step_bench *bench = open_bench(&without_bounds);
    struct vw_view *view = &bench->scene->views[0];
    double edge_world = 2.0 * bench->scene->box.half_extent_world;
    for (size_t i = 0; i < VW_ARRAY_COUNT(distances); i++) {
        look_at_ball(bench, distances[i]);
        view->near_world = view->far_world = 0.0;
        check_camera(finding, bench);
        view->near_world = (distances[i] - 0.5) * edge_world / 0.9;
        view->far_world = (distances[i] + 0.5) * edge_world;
        check_camera(finding, bench);
    }
}

// Checks near and far distances that are the same, next to nothing, or farther than the far distance without points.
static void depths_of_any_size(struct hard_finding *finding) {
    static const double depths_edges[][2] = {{2.0, 2.0}, {1e-9, 1e-9}, {1e-9, 1.0}, {5e3, 5e3}, {0.5, 1e7}, {1e7, 1e7}};
    struct step_bench *bench = open_bench(&without_bounds);
    struct vw_view *view = &bench->scene->views[0];
    double edge_world = 2.0 * bench->scene->box.half_extent_world;
    look_at_ball(bench, 0.75);
    for (size_t i = 0; i < VW_ARRAY_COUNT(depths_edges); i++) {
        view->near_world = depths_edges[i][0] * edge_world;
        view->far_world = depths_edges[i][1] * edge_world;
        check_camera(finding, bench);
    }
}

// Checks world coordinates of 10^6 m, where a double is good to 10^-10 m, and boxes of a millimetre and of a kilometre.
static void worlds_anywhere_and_of_any_size(struct hard_finding *finding) {
    static const double scales[] = {1.0, 1e-3, 1e3};
    struct step_bench *bench = open_bench(&without_bounds);
    for (size_t i = 0; i < VW_ARRAY_COUNT(scales); i++) {
        struct vw_scene *kept = bench->scene,
                        *moved = synthetic_scene(&(struct synthetic_scene_params){.train_views = 2,
                                                                                  .val_views = 1,
                                                                                  .width_px = 24,
                                                                                  .height_px = 20,
                                                                                  .world_offset = 1e6,
                                                                                  .world_scale = scales[i]});
        bench->scene = moved;
        hard_require(finding, rays_check(bench, 1.0 + 1e6 * 0x1p-53 / scales[i] / 1e-6) == RAYS,
                     "every ray has samples");
        hard_check_step(finding, bench, STEP);
        bench->scene = kept;
    }
}

static const struct hard_case cases[] = {
    {"rays that miss the box", "samples outside the box; gradients of nothing", rays_that_miss},
    {"rays that graze an edge", "negative or made-up lengths", rays_that_graze_an_edge},
    {"rays that start inside", "samples behind the camera", rays_that_start_inside},
    {"rays parallel to the box, also in its faces", "0/0 in the slab test", rays_parallel_to_the_box},
    {"rays of no extent", "the known depths end before the box or begin beyond it: negative strides",
     rays_of_no_extent},
    {"cameras up to 10^6 m from a scene of 1 m", "cancellation: 10^6 leaves a float 1/16 m",
     cameras_far_from_a_small_scene},
    {"cameras 1 m apart in a scene of 10^6 m", "cameras fall together, or out of the box", camera_in_a_huge_scene},
    {"scenes of any size at coordinates of 10^6 m", "cancellation between camera and box", scenes_far_from_the_origin},
    {"focal length of 1 px", "directions at right angles to the axis", focal_length_of_1_px},
    {"focal length of 10^6 px", "all pixels see along the same ray", focal_length_of_1e6_px},
    {"distortion without inverse in the corners", "Newton's method runs off to NaN",
     distortion_without_inverse_in_the_corners},
    {"contraction from the centre to 10^38", "0/0 at the centre, overflow of squares far away",
     contraction_at_all_distances},
    {"contraction across the unit sphere", "a seam where the formulas change", contraction_across_the_sphere},
    {"strata of any lengths", "near = far: 0/0; far next to infinite: cancellation", strata_of_any_lengths},
    {"cameras in and around the ball", "the camera at the centre; directions along axes",
     cameras_in_and_around_the_ball},
    {"cameras 10^4 and 10^6 edges away", "distances from the camera, but rays that start near the box",
     cameras_far_away},
    {"depths of any size", "near = far, near of nothing, far beyond the far distance", depths_of_any_size},
    {"worlds at 10^6 m, of any size", "cancellation between camera and box", worlds_anywhere_and_of_any_size},
};

HARD_CASES("rays", cases)
