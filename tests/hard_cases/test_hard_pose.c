// Hard poses: cameras far from the box, corrections that are large beside the ridge, rays that all miss, photos that
// are never visited or wholly masked, and losses beyond the floats.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "hard_cases/hard_run.h"
#include "hard_cases/hard_step.h"
#include "kernels/checks/check.h"
#include "reference/effects/pose.h"
#include "support/synthetic_scene.h"

static const struct step_case setup = {.name = "pose", .seed = 521, HARD_STEP, .effects = "pose"};
enum { LATE = REFERENCE_POSE_WARM_UP + 1 };

static struct vw_scene *scene;

// Opens a bench with all rays of one photo, whose camera stands at `position` and looks at the box's middle (NULL: as
// it is).
static struct step_bench *open_at(const double position[3], float size) {
    struct step_bench *bench = step_bench_open(&setup);
    struct vw_view *view = &bench->scene->views[bench->view];
    float *poses = bench->params + bench->model.ranges[VW_SLOT_POSES].offset_bytes / sizeof *poses;
    for (size_t i = 0; i < bench->model.ranges[VW_SLOT_POSES].size_bytes / sizeof *poses; i++) poses[i] *= size / 0.05f;
    step_bench_write_params(bench);
    for (uint32_t i = 0; i < bench->config.rays; i++) bench->pixels[i].view = bench->view;
    hard_write_pixels(bench);
    if (!position) return bench;
    double far = hypot(hypot(position[0], position[1]), position[2]);
    rays_look(view, &bench->model.box, position, (const double[3]){0.5, 0.5, 0.5});
    view->camera.focal_x_px = view->camera.focal_y_px = 20.0 * far;
    struct vw_gpu_camera *cameras = step_bench_read(bench, bench->field.cameras);
    cameras[bench->view] = vw_field_camera(&bench->model, view, &bench->model.box);
    step_bench_write(bench, bench->field.cameras, cameras);
    return bench;
}

static void pose_now(struct step_bench *bench, double pose[REFERENCE_POSE]) {
    float *params = step_bench_read(bench, bench->field.params);
    reference_pose_of(&bench->model, params, bench->view, pose);
}

// Checks that the device's rays pass close to the reference's lines, near the box. Returns how many hit it.
static uint32_t compare_rays(struct hard_finding *finding, struct step_bench *bench) {
    const struct vw_box *box = &bench->model.box;
    double pose[REFERENCE_POSE];
    uint32_t hits = 0;
    pose_now(bench, pose);
    struct vw_view moved = reference_pose_apply(&bench->scene->views[bench->view], box, pose);
    struct vw_ray *rays = step_bench_read(bench, bench->step.ray_buffer);
    for (uint32_t i = 0; i < bench->config.rays; i++) {
        struct reference_ray ray = reference_ray_of(&rays[i]);
        double origin[3], direction[3], along = 0.0, middle = ray.near + 0.5 * setup.samples * ray.stride;
        hard_require(
            finding,
            reference_camera_line(&moved, box, bench->pixels[i].x_px, bench->pixels[i].y_px, origin, direction),
            "the lens has a line there");
        if (ray.stride == 0.0) continue;
        for (int k = 0; k < 3; k++) along += (ray.origin[k] + middle * ray.direction[k] - origin[k]) * direction[k];
        for (int k = 0; k < 3; k++)
            hard_compare(finding, "middle of a ray off its line", 3 * i + k, ray.origin[k] + middle * ray.direction[k],
                         origin[k] + along * direction[k], 1.0, 4e-6);
        hits++;
    }
    return hits;
}

// Checks the move that a step makes from what its rays say.
static void compare_move(struct hard_finding *finding, struct step_bench *bench, uint64_t number) {
    const struct vw_specialization *s = &bench->model.specialization;
    double before[REFERENCE_POSE], after[REFERENCE_POSE], gradient[REFERENCE_POSE], force[3] = {0}, torque[3] = {0};
    struct vw_pose_moments *moments = step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_POSE_MOMENTS]);
    pose_now(bench, before);
    step_bench_step(bench, number);
    pose_now(bench, after);
    float *d_poses = step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_D_POSES]);
    for (uint32_t i = 0; i < 3 * bench->step.padded_rays; i++) {
        force[i % 3] += d_poses[8 * (i / 3) + i % 3];
        torque[i % 3] += d_poses[8 * (i / 3) + 4 + i % 3];
    }
    reference_pose_gradient(&bench->scene->views[bench->view], &bench->model.box, before, force, torque, gradient);
    uint64_t visits = moments[bench->view].visits + 1;
    for (int i = 0; i < REFERENCE_POSE; i++) {
        const float *own = (const float *)&moments[bench->view] + i / 3 * 8 + i % 3;
        double moment1 = own[0], moment2 = own[4],
               mean = gradient[i] * s->inverse_rays + reference_pose_ridge * before[i],
               by = reference_pose_rate(visits) * reference_adam(s, mean, visits, &moment1, &moment2);
        hard_compare(finding, "number of a pose", (uint64_t)i, after[i], before[i] - by,
                     1e-4 * fabs(before[i]) + s->learning_rate, 2e-3);
    }
}

static void far_cameras(struct hard_finding *finding) {
    static const double positions[][3] = {{6.0, -4.0, 3.0}, {60.0, 40.0, -30.0}, {6e5, -4.8e5, 6.4e5}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(positions); i++) {
        struct step_bench *bench = open_at(positions[i], 0.05f);
        step_bench_gradients(bench, 1);
        hard_require(finding, compare_rays(finding, bench) > bench->config.rays / 4, "rays hit the box");
        compare_move(finding, bench, LATE);
        compare_move(finding, bench, LATE + 1);
        test_release(bench);
    }
}

static void large_corrections(struct hard_finding *finding) {
    static const float sizes[] = {0.3f, 1.0f};
    for (size_t i = 0; i < VW_ARRAY_COUNT(sizes); i++) {
        struct step_bench *bench = open_at(NULL, sizes[i]);
        step_bench_gradients(bench, 1);
        compare_rays(finding, bench);
        compare_move(finding, bench, LATE);
        test_release(bench);
    }
}

// Checks that the ridge alone moves the pose of a camera that sees nothing, towards 0, and by no more than a step.
static void rays_that_miss(struct hard_finding *finding) {
    struct step_bench *bench = open_at(NULL, 1.0f);
    struct vw_view *view = &bench->scene->views[bench->view];
    rays_look(view, &bench->model.box, (const double[3]){3.0, 3.0, 3.0}, (const double[3]){9.0, 9.0, 9.0});
    struct vw_gpu_camera *cameras = step_bench_read(bench, bench->field.cameras);
    cameras[bench->view] = vw_field_camera(&bench->model, view, &bench->model.box);
    step_bench_write(bench, bench->field.cameras, cameras);
    double before[REFERENCE_POSE], after[REFERENCE_POSE];
    pose_now(bench, before);
    compare_move(finding, bench, LATE);
    pose_now(bench, after);
    struct vw_pose *d_poses = step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_D_POSES]), zero = {0};
    for (uint32_t i = 0; i < bench->step.padded_rays; i++)
        hard_same_bits(finding, "what a ray says", &d_poses[i], &zero, sizeof zero);
    for (int i = 0; i < REFERENCE_POSE; i++)
        hard_require(finding, fabs(after[i]) < fabs(before[i]), "the ridge pulls to 0");
}

static void photos_without_pixels(struct hard_finding *finding) {
    struct step_bench *bench = open_at(NULL, 0.0f);
    for (uint32_t i = 0; i < bench->config.rays; i++) bench->pixels[i].weight = 0.0f;
    hard_write_pixels(bench);
    step_bench_step(bench, LATE);
    struct hard_state state = hard_state_read(bench);
    struct vw_pose_moments *moments = step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_POSE_MOMENTS]),
                           unvisited = {0};
    hard_same_bits(finding, "params", state.grid.grid, bench->params, bench->model.param_bytes);
    hard_equal(finding, "visits", 0, moments[bench->view].visits, 1.0);
    for (uint32_t view = 0; view < 3; view++)
        if (view != bench->view)
            hard_same_bits(finding, "moments of a photo never visited", &moments[view], &unvisited, sizeof unvisited);
}

static void infinite_losses(struct hard_finding *finding) {
    struct step_bench *bench = open_at(NULL, 0.05f);
    bench->pixels[3].rgba.x = 1e30f;
    hard_write_pixels(bench);
    step_bench_step(bench, LATE);
    struct hard_state state = hard_state_read(bench);
    hard_require(finding, state.skipped, "the step is skipped");
    hard_same_bits(finding, "params", state.grid.grid, bench->params, bench->model.param_bytes);
}

static void photos_of_one_pixel(struct hard_finding *finding) {
    scene = synthetic_scene(
        &(struct synthetic_scene_params){.train_views = 4, .val_views = 2, .width_px = 1, .height_px = 1});
    struct vw_config config = hard_run_config();
    strcpy(config.effects, "pose");
    hard_train_well(finding, scene, &config);
}

static const struct hard_case cases[] = {
    {"cameras 6 to 600,000 box edges away", "turns that throw all rays off the box; lost digits", far_cameras},
    {"corrections of up to a radian and a box edge", "gradients that hold for small turns alone", large_corrections},
    {"all rays miss the box", "0/0 in Adam; a camera that flies off", rays_that_miss},
    {"a photo without pixels, and one never visited", "a correction without a reason", photos_without_pixels},
    {"infinite losses", "a camera at infinity", infinite_losses},
    {"photos of one pixel", "numbers that are not finite", photos_of_one_pixel},
};

int main(void) { return hard_cases_run("pose", cases, VW_ARRAY_COUNT(cases)); }
