// Hard cases of the effect unbounded: points that the contraction must not lose, strata that are next to nothing or
// next to infinite, and cameras at the centre, far away, and in worlds of any place. Rays are held against the
// reference's line through the pixel, in double, and then a whole training step and a rendering with these rays.
#include "support/cmocka_test.h"
#include "train/fields/registry.h"

#include "base/memory.h"
#include "hard_cases/hard_run.h"
#include "hard_cases/hard_step.h"

static const double POSITION_TOLERANCE = 4e-7; // in edges of the field's cube: eight roundings next to 1
static const double DISTANCE_TOLERANCE = 2e-6; // relative: thirty roundings, of a sum over strata
static const double LIGHT_TOLERANCE = 1e-5;    // the device's exp, and that of a thickness up to 8

enum { SIDE_PX = 8, RAYS = SIDE_PX * SIDE_PX, STEP = 3 };

static const struct step_case setup = {.name = "unbounded", .seed = 341, HARD_STEP, .effects = "unbounded"};

// ---- The contraction ------------------------------------------------------------------------------------------------

// Returns the positions of the rays' first samples in the field's cube, as forward_field makes them in training: x, y,
// z, 0 of one ray after the other.
static float *locate(struct step_bench *bench, const struct vw_ray *rays) {
    struct vw_push_samples push = step_bench_push(bench, STEP);
    step_bench_write(bench, bench->step.ray_buffer, rays);
    step_bench_dispatch(bench, vw_volume_step_of(&bench->step)->gradient.field.passes[HASH_FORWARD], &push, sizeof push,
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
    struct step_bench *bench = step_bench_open(&setup);
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
    struct step_bench *bench = step_bench_open(&setup);
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
    struct step_bench *bench = step_bench_open(&setup);
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
    step_bench_write(bench, evaluator->rays, rays);
    step_bench_write(bench, vw_volume_evaluation_of(evaluator)->samples, field);
    step_bench_dispatch(bench, vw_volume_evaluation_of(evaluator)->composite, &push, sizeof push,
                        step_bench_lanes(bench, push.ray_count));
    vw_float4 *colours = step_bench_read(bench, evaluator->colours);
    for (uint32_t i = 0; i < RAYS; i++) {
        double left = exp(-thickness[i]);
        hard_compare(finding, "light that is left", i, colours[i].w, left, 1.0,
                     LIGHT_TOLERANCE + DISTANCE_TOLERANCE * thickness[i]);
        hard_compare(finding, "colour of the fog", i, colours[i].x, 1.0 - left, 1.0,
                     LIGHT_TOLERANCE + DISTANCE_TOLERANCE * thickness[i]);
        if (length[i] == 0.0) hard_equal(finding, "light that nothing holds up", i, colours[i].w, 1.0);
    }
}

// ---- Cameras --------------------------------------------------------------------------------------------------------

// Opens a bench whose rays all come from view 0, which the test moves, and cover its photo evenly.
static struct step_bench *open_bench(void) {
    struct step_bench *bench = step_bench_open(&setup);
    const struct vw_camera *camera = &bench->scene->views[0].camera;
    for (uint32_t i = 0; i < RAYS; i++) {
        bench->pixels[i].view = 0;
        bench->pixels[i].x_px = (float)((i % SIDE_PX + 0.5) * camera->width_px / SIDE_PX);
        bench->pixels[i].y_px = (float)((i / SIDE_PX + 0.5) * camera->height_px / SIDE_PX);
    }
    return bench;
}

static void check_camera(struct hard_finding *finding, struct step_bench *bench) {
    hard_require(finding, rays_check(bench, 1.0) == RAYS, "every ray has samples");
    hard_check_step(finding, bench, STEP);
    hard_check_rendering(finding, bench);
}

// Checks cameras at the centre, on the sphere and outside, which look in, out and along axes.
static void cameras_in_and_around_the_ball(struct hard_finding *finding) {
    static const struct {
        double position[3], target[3];
    } cameras[] = {{{0.5, 0.5, 0.5}, {1.0, 0.5, 0.5}}, {{0.5, 0.5, 0.5}, {0.1, 0.9, 0.3}},
                   {{1.0, 0.5, 0.5}, {0.0, 0.5, 0.5}}, {{0.5, 0.5, 1.0}, {0.5, 0.5, 3.0}},
                   {{0.5, 2.5, 0.5}, {0.5, 0.5, 0.5}}, {{2.0, -3.0, 1.0}, {5.0, -9.0, 2.0}}};
    struct step_bench *bench = open_bench();
    struct vw_view *view = &bench->scene->views[0];
    for (size_t i = 0; i < VW_ARRAY_COUNT(cameras); i++) {
        rays_look(view, &bench->scene->box, cameras[i].position, cameras[i].target);
        bench->pixels[0].x_px = (float)view->camera.centre_x_px; // exactly along the axis
        bench->pixels[0].y_px = (float)view->camera.centre_y_px;
        check_camera(finding, bench);
    }
}

static void look_from(struct step_bench *bench, double distance_edges) {
    static const double back[3] = {0.6, -0.48, 0.64}, centre[3] = {0.5, 0.5, 0.5};
    struct vw_view *view = &bench->scene->views[0];
    double position[3];
    for (int i = 0; i < 3; i++) position[i] = centre[i] + distance_edges * back[i];
    rays_look(view, &bench->scene->box, position, centre);
    view->camera.focal_x_px = view->camera.focal_y_px = 24.0 * fmax(distance_edges, 1.0); // the ball fills the photo
}

// Checks that a ray begins next to what it sees where points tell the depths, as precisely as from a camera nearby.
static void cameras_far_away(struct hard_finding *finding) {
    static const double distances[] = {10.0, 1e4, 1e6};
    struct step_bench *bench = open_bench();
    struct vw_view *view = &bench->scene->views[0];
    double edge_world = 2.0 * bench->scene->box.half_extent_world;
    for (size_t i = 0; i < VW_ARRAY_COUNT(distances); i++) {
        look_from(bench, distances[i]);
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
    struct step_bench *bench = open_bench();
    struct vw_view *view = &bench->scene->views[0];
    double edge_world = 2.0 * bench->scene->box.half_extent_world;
    look_from(bench, 0.75);
    for (size_t i = 0; i < VW_ARRAY_COUNT(depths_edges); i++) {
        view->near_world = depths_edges[i][0] * edge_world;
        view->far_world = depths_edges[i][1] * edge_world;
        check_camera(finding, bench);
    }
}

// Checks world coordinates of 10^6 m, where a double is good to 10^-10 m, and boxes of a millimetre and of a kilometre.
static void worlds_anywhere_and_of_any_size(struct hard_finding *finding) {
    static const double scales[] = {1.0, 1e-3, 1e3};
    struct step_bench *bench = open_bench();
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

// ---- Runs -----------------------------------------------------------------------------------------------------------

static void whole_runs(struct hard_finding *finding) {
    struct vw_config config = hard_run_config();
    strcpy(config.effects, "unbounded");
    struct vw_scene *scene = synthetic_scene(
        &(struct synthetic_scene_params){.train_views = 6, .val_views = 2, .width_px = 12, .height_px = 10});
    hard_train_well(finding, scene, &config);
    scene->views[1].camera_to_world[0][3] = 1e7; // one was placed wrongly
    hard_train_well(finding, scene, &config);
}

static const struct hard_case cases[] = {
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
    {"whole runs, also with a camera that is lost", "one camera pulls the box away from all others", whole_runs},
};

int main(void) { return hard_cases_run("unbounded", cases, VW_ARRAY_COUNT(cases)); }
