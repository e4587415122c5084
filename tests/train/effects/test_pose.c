// The effect pose against its reference: rays of corrected cameras, the gradient by samples' positions, what rays say
// of a camera, and how it moves. The gradient by the six numbers is held against finite differences of the reference's
// loss, through the camera, the grid and the networks, in double. Hard cases: cameras far from the box, corrections
// that are large beside the ridge, rays that all miss, photos without pixels, and losses beyond the floats.
//
// Kinks: a difference across a changed decision (another cell of the grid, a ReLU switching, the density reaching its
// maximum, an error changing sign) is not a derivative. Such a ray is skipped; at most one in ten may be.
#include "support/cmocka_test.h"

#include <float.h>

#include "base/memory.h"
#include "hard_cases/hard_step.h"
#include "reference/effects/pose.h"

enum { STEP = 300, SAMPLES_MAX = 64, LATE = REFERENCE_POSE_WARM_UP + 1 };
static const double DIFFERENCE = 1e-7;         // change of a number
static const double POSITION_TOLERANCE = 4e-6; // share of the sizes of what is summed
static const double SUM_TOLERANCE = 1e-5;      // likewise
static const double GRADIENT_TOLERANCE = 2e-3; // share of the largest of a ray's, which floats have summed
static const double LINE_TOLERANCE = 4e-6;     // box edges
static const double MOVE_TOLERANCE = 1e-3;     // share of a step

// `size`: of the corrections. `differs`: whether its loss is the reference's, against which differences are taken.
static const struct {
    struct step_case setup;
    float size;
    bool differs;
} cases[] = {
    {{"default sizes", .seed = 501, .loss = VW_LOSS_L2}, 0.02f, true},
    {{"no correction", .seed = 502, .rays = 16, .samples = 16, .loss = VW_LOSS_L2}, 0.0f, true},
    {{"large corrections, four features, distortion", .seed = 503, .rays = 256, .samples = 7, .features = 4,
      .levels = 2, .width = 16, .effects = "distortion"},
     0.5f,
     true},
    {{"wide network, by storage buffers, plain descent", .seed = 504, .rays = 16, .samples = 48, .width = 64,
      .loss = VW_LOSS_HUBER, .optimizer = VW_OPTIMIZER_SGD, .as_on_gpus = true, .effects = "background"},
     0.02f,
     true},
    {{"momentum", .seed = 505, .beta1 = 0.9, .loss = VW_LOSS_L2}, 0.02f, true},
    {{"importance samples", .seed = 506, .importance_samples = 16, .loss = VW_LOSS_L2}, 0.02f, true},
    {{"other effects", .seed = 508, .optimizer = VW_OPTIMIZER_DENSE_ADAM, .loss = VW_LOSS_L2,
      .effects = "sky,appearance,appearance_code,visibility"},
     0.02f,
     false},
    {{"transient", .seed = 509, .loss = VW_LOSS_L2, .effects = "transient"}, 0.02f, false},
};

// A step of a bench, read back, all of whose rays are of one photo.
struct taken {
    struct step_bench *bench;
    const struct vw_view *view;
    double pose[REFERENCE_POSE];
    struct reference_params *params;
    struct reference_step *step; // its rays and places
    float *rows, *d_positions, *d_poses;
};

// Opens a bench with corrections of this size and all rays of one photo.
static struct step_bench *open_with(const struct step_case *setup, float size) {
    struct step_bench *bench = step_bench_open(setup);
    float *poses = bench->params + bench->model.ranges[VW_SLOT_POSES].offset_bytes / sizeof *poses;
    for (size_t i = 0; i < bench->model.ranges[VW_SLOT_POSES].size_bytes / sizeof *poses; i++) poses[i] *= size / 0.05f;
    step_bench_write_params(bench);
    for (uint32_t i = 0; i < bench->config.rays; i++) bench->pixels[i].view = bench->view;
    hard_write_pixels(bench);
    return bench;
}

static struct step_bench *open_case(size_t index) {
    struct step_case setup = cases[index].setup;
    setup.another_effect = "pose";
    return open_with(&setup, cases[index].size);
}

static void pose_now(struct step_bench *bench, double pose[REFERENCE_POSE]) {
    reference_pose_of(&bench->model, test_read(bench->field.params), bench->view, pose);
}

static struct taken take(struct step_bench *bench) {
    struct taken it = {.bench = bench, .view = &bench->scene->views[bench->view]};
    step_bench_gradients(bench, STEP);
    it.params = reference_params_create(&bench->model, test_read(bench->field.params));
    pose_now(bench, it.pose);
    it.step = step_bench_reference(bench);
    it.rows = step_bench_read_rows(bench);
    it.d_positions = test_read(bench->step.effect_buffers[VW_SLOT_D_POSITIONS]);
    it.d_poses = test_read(bench->step.effect_buffers[VW_SLOT_D_POSES]);
    return it;
}

static const struct vw_pixel *pixel_of(const struct taken *it, uint32_t ray) {
    uint32_t last = it->bench->config.rays - 1;
    return &it->bench->pixels[ray < last ? ray : last];
}

static void line_of(const struct taken *it, const double pose[REFERENCE_POSE], uint32_t ray, double origin[3],
                    double direction[3]) {
    const struct vw_box *box = &it->bench->model.box;
    struct vw_view moved = reference_pose_apply(it->view, box, pose);
    assert_true(
        reference_camera_line(&moved, box, pixel_of(it, ray)->x_px, pixel_of(it, ray)->y_px, origin, direction));
}

// Returns how far from the corrected camera the ray's parameter 0 is, along its direction.
static double offset_of(const struct taken *it, uint32_t ray) {
    double origin[3], direction[3], along = 0.0;
    line_of(it, it->pose, ray, origin, direction);
    for (int i = 0; i < 3; i++) along += (it->step->rays[ray].origin[i] - origin[i]) * direction[i];
    return along;
}

static double place_of(const struct taken *it, uint32_t ray, uint32_t sample) {
    const struct vw_specialization *s = &it->bench->model.specialization;
    vw_uint4 key = vw_model_key_of_step(&it->bench->model, STEP);
    if (it->step->sample_places) return it->step->sample_places[(size_t)ray * s->samples + sample];
    return sample + reference_stratum_offset(s, ray, sample, key);
}

// ---- Rays, positions and sums ---------------------------------------------------------------------------------------

// Checks that the device's rays pass close to the lines of the corrected camera, near the box. Returns how many hit it.
static uint32_t check_lines(const struct taken *it) {
    uint32_t hits = 0;
    for (uint32_t i = 0; i < it->bench->config.rays; i++) {
        const struct reference_ray *ray = &it->step->rays[i];
        double origin[3], direction[3], along = 0.0, middle = ray->near + 0.5 * it->bench->config.samples * ray->stride;
        line_of(it, it->pose, i, origin, direction);
        if (ray->stride == 0.0) continue;
        for (int k = 0; k < 3; k++) along += (ray->origin[k] + middle * ray->direction[k] - origin[k]) * direction[k];
        for (int k = 0; k < 3; k++) {
            check_value(it->bench->where, "middle of a ray", i, ray->origin[k] + middle * ray->direction[k],
                        origin[k] + along * direction[k], LINE_TOLERANCE);
            check_value(it->bench->where, "direction", i, ray->direction[k], direction[k], 0.5 * LINE_TOLERANCE);
        }
        hits++;
    }
    return hits;
}

static void check_position(const struct taken *it, uint32_t slot) {
    struct step_rows row = step_bench_rows(it->bench);
    const float *position = step_bench_row(it->bench, it->rows, row.position, slot);
    const double exact[3] = {position[0], position[1], position[2]};
    double d_encoding[REFERENCE_ENCODING_MAX], expected[3];
    for (uint32_t i = 0; i < it->bench->config.levels * it->bench->config.features; i++)
        d_encoding[i] = step_bench_row(it->bench, it->rows, row.d_encoding + i / 4, slot)[i % 4];
    double size =
        reference_encode_back(&it->bench->model.specialization, it->params->grid, exact, d_encoding, expected);
    for (int axis = 0; axis < 3; axis++)
        check_value(it->bench->where, "gradient by the position", slot, it->d_positions[4 * (size_t)slot + axis],
                    expected[axis], POSITION_TOLERANCE * size + FLT_MIN);
}

// Checks the sums over the samples of a ray.
static void check_sums(const struct taken *it, uint32_t ray) {
    const struct vw_specialization *s = &it->bench->model.specialization;
    struct vw_view moved = reference_pose_apply(it->view, &it->bench->model.box, it->pose);
    double force[3] = {0}, torque[3] = {0}, sizes = FLT_MIN, reach = 0.0;
    for (uint32_t i = 0; i < s->samples; i++) {
        uint32_t slot = ray * s->samples + i;
        const float *gradient = it->d_positions + 4 * (size_t)slot,
                    *position = step_bench_row(it->bench, it->rows, step_bench_rows(it->bench).position, slot);
        double arm[3];
        for (int k = 0; k < 3; k++)
            arm[k] = position[k] - 0.5 -
                     (moved.camera_to_world[k][3] - it->bench->model.box.centre_world[k]) /
                         (2.0 * it->bench->model.box.half_extent_world);
        for (int k = 0; k < 3; k++) {
            force[k] += gradient[k];
            torque[k] += arm[(k + 1) % 3] * gradient[(k + 2) % 3] - arm[(k + 2) % 3] * gradient[(k + 1) % 3];
            sizes += fabs((double)gradient[k]);
            reach = fmax(reach, fabs(arm[k]));
        }
    }
    for (int k = 0; k < 3; k++) {
        check_value(it->bench->where, "force", ray, it->d_poses[8 * ray + k], force[k], SUM_TOLERANCE * sizes);
        check_value(it->bench->where, "torque", ray, it->d_poses[8 * ray + 4 + k], torque[k],
                    SUM_TOLERANCE * sizes * reach);
    }
}

// ---- Finite differences ---------------------------------------------------------------------------------------------

struct decisions { // choices at a ray's samples
    uint32_t cells[SAMPLES_MAX][VW_LEVELS_MAX][3];
    bool active[SAMPLES_MAX][2][REFERENCE_WIDTH_MAX], saturated[SAMPLES_MAX];
    bool below[3], small[3]; // the errors of its channels
};

static struct reference_point point_at(const struct taken *it, uint32_t ray, uint32_t index, const double position[3],
                                       struct decisions *made) {
    const struct vw_specialization *s = &it->bench->model.specialization;
    struct reference_sample sample = {0};
    struct reference_point point;
    // Colours' dependence on the direction is left out.
    memcpy(sample.direction, it->step->rays[ray].direction, sizeof sample.direction);
    reference_encode_smoothly(s, it->params->grid, position, sample.encoding, made->cells[index]);
    reference_networks_forward(s, &it->params->weights, &sample);
    memcpy(made->active[index][0], sample.active1, sizeof sample.active1);
    memcpy(made->active[index][1], sample.active2, sizeof sample.active2);
    made->saturated[index] = sample.saturated;
    memcpy(point.rgb, sample.rgb, sizeof point.rgb);
    point.density = sample.density;
    return point;
}

static double loss_of(const struct taken *it, const double pose[REFERENCE_POSE], uint32_t ray, struct decisions *made) {
    const struct vw_specialization *s = &it->bench->model.specialization;
    const struct reference_ray *base = &it->step->rays[ray];
    struct reference_point points[SAMPLES_MAX];
    double origin[3], direction[3], behind = offset_of(it, ray), backdrop[3], colour[3], loss = 0.0, unused;
    memset(made, 0, sizeof *made);
    line_of(it, pose, ray, origin, direction);
    for (uint32_t i = 0; i < s->samples; i++) {
        double position[3], along = behind + base->near + place_of(it, ray, i) * base->stride;
        for (int k = 0; k < 3; k++) position[k] = fmin(fmax(origin[k] + along * direction[k], 0.0), 1.0);
        points[i] = point_at(it, ray, i, position, made);
        points[i].length = it->step->sample_places
                               ? reference_listed_length(s, base, &it->step->sample_places[(size_t)ray * s->samples], i)
                               : reference_stratum_length(s, base, i);
    }
    reference_backdrop(s, it->params->sky, base->direction, ray, vw_model_key_of_step(&it->bench->model, STEP),
                       backdrop);
    reference_composite(points, s->samples, backdrop, colour);
    for (int c = 0; c < 3; c++) {
        double error = colour[c] - base->target[c];
        made->below[c] = error < 0.0;
        made->small[c] = fabs(error) < s->huber_length;
        loss += base->weight / 3.0 * reference_loss(s, error, &unused);
    }
    return loss;
}

// Finds the gradient by central differences. Returns false at a kink.
static bool differentiate(const struct taken *it, uint32_t ray, double gradient[REFERENCE_POSE]) {
    static struct decisions before, ahead, behind;
    loss_of(it, it->pose, ray, &before);
    for (int i = 0; i < REFERENCE_POSE; i++) {
        double pose[REFERENCE_POSE];
        memcpy(pose, it->pose, sizeof pose);
        pose[i] = it->pose[i] + DIFFERENCE;
        double more = loss_of(it, pose, ray, &ahead);
        pose[i] = it->pose[i] - DIFFERENCE;
        gradient[i] = (more - loss_of(it, pose, ray, &behind)) / (2.0 * DIFFERENCE);
        if (memcmp(&before, &ahead, sizeof before) || memcmp(&before, &behind, sizeof before)) return false;
    }
    return true;
}

// Checks the gradients of some rays by differences. At most one ray in ten may stand at a kink.
static void check_slopes(const struct taken *it) {
    struct step_bench *bench = it->bench;
    uint32_t rays = bench->config.rays < 32 ? bench->config.rays : 32, skipped = 0;
    for (uint32_t ray = 0; ray < rays; ray++) {
        double slopes[REFERENCE_POSE], found[REFERENCE_POSE], scale;
        const float *own = it->d_poses + 8 * (size_t)ray;
        const double force[3] = {own[0], own[1], own[2]}, torque[3] = {own[4], own[5], own[6]};
        if (!differentiate(it, ray, slopes)) {
            skipped++;
            continue;
        }
        reference_pose_gradient(it->view, &bench->model.box, it->pose, force, torque, found);
        scale = fmax(largest(slopes, REFERENCE_POSE), 1e-4);
        for (int k = 0; k < REFERENCE_POSE; k++)
            check_value(bench->where, "gradient by the pose", REFERENCE_POSE * ray + k, found[k], slopes[k],
                        GRADIENT_TOLERANCE * scale);
    }
    if (10 * skipped > rays + 20) fail_msg("%s: %u of %u rays stand at kinks", bench->where, skipped, rays);
}

TEST_CASES(rays_and_gradients_are_those_of_corrected_cameras, i, VW_ARRAY_COUNT(cases)) {
    struct step_bench *bench = open_case(i);
    struct taken it = take(bench);
    assert_true(check_lines(&it) > 0);
    for (uint32_t ray = 0; ray < bench->step.padded_rays; ray++) check_sums(&it, ray);
    for (uint32_t k = 0; k < bench->padded_samples; k++) check_position(&it, k);
    if (cases[i].differs) check_slopes(&it);
}

// ---- Moves ----------------------------------------------------------------------------------------------------------

// Takes a step and checks the move that it makes from what its rays say, but for `slack`.
static void check_move(struct step_bench *bench, uint64_t number, double slack) {
    const struct vw_specialization *s = &bench->model.specialization;
    const struct vw_view *view = &bench->scene->views[bench->view];
    struct vw_buffer *moment_buffer = bench->step.effect_buffers[VW_SLOT_POSE_MOMENTS];
    size_t first = bench->model.ranges[VW_SLOT_POSES].offset_bytes / 4,
           all = bench->model.ranges[VW_SLOT_POSES].size_bytes;
    float *before = test_read(bench->field.params);
    struct vw_pose_moments *moments = test_read(moment_buffer);
    step_bench_step(bench, number);
    float *after = test_read(bench->field.params), *d_poses = test_read(bench->step.effect_buffers[VW_SLOT_D_POSES]);
    struct vw_pose_moments *moments_after = test_read(moment_buffer);
    double pose[REFERENCE_POSE], moved[REFERENCE_POSE], gradient[REFERENCE_POSE], force[3] = {0}, torque[3] = {0};
    reference_pose_of(&bench->model, before, bench->view, pose);
    reference_pose_of(&bench->model, after, bench->view, moved);
    for (uint32_t i = 0; i < 3 * bench->step.padded_rays; i++) {
        force[i % 3] += d_poses[8 * (i / 3) + i % 3];
        torque[i % 3] += d_poses[8 * (i / 3) + 4 + i % 3];
    }
    reference_pose_gradient(view, &bench->model.box, pose, force, torque, gradient);
    assert_int_equal(moments_after[bench->view].visits, moments[bench->view].visits + 1);
    for (int i = 0; i < REFERENCE_POSE; i++) {
        const float *own = (const float *)&moments[bench->view] + i / 3 * 8 + i % 3;
        double moment1 = own[0], moment2 = own[4], rate = reference_pose_rate(moments[bench->view].visits + 1),
               mean = gradient[i] * s->inverse_rays + reference_pose_ridge * pose[i],
               by = rate * reference_adam(s, mean, moments[bench->view].visits + 1, &moment1, &moment2);
        check_value(bench->where, "pose", i, moved[i], pose[i] - by,
                    MOVE_TOLERANCE * fabs(by) + 2e-7 * fabs(pose[i]) + slack);
        ((float *)after)[first + 8 * bench->view + i / 3 * 4 + i % 3] = (float)pose[i];
    }
    check_same_bits(bench->where, "other photos' poses", after + first, before + first, all);
    memcpy(&moments_after[bench->view], &moments[bench->view], sizeof *moments);
    check_same_bits(bench->where, "other photos' moments", moments_after, moments, vw_buffer_size_bytes(moment_buffer));
}

static void check_stays(struct step_bench *bench, uint64_t number) {
    size_t first = bench->model.ranges[VW_SLOT_POSES].offset_bytes / 4;
    float *before = test_read(bench->field.params);
    struct vw_pose_moments *moments = test_read(bench->step.effect_buffers[VW_SLOT_POSE_MOMENTS]);
    step_bench_step(bench, number);
    float *after = test_read(bench->field.params);
    struct vw_pose_moments *moments_after = test_read(bench->step.effect_buffers[VW_SLOT_POSE_MOMENTS]);
    check_same_bits(bench->where, "poses", after + first, before + first,
                    bench->model.ranges[VW_SLOT_POSES].size_bytes);
    check_same_bits(bench->where, "moments", moments_after, moments,
                    vw_buffer_size_bytes(bench->step.effect_buffers[VW_SLOT_POSE_MOMENTS]));
}

TEST_CASES(cameras_move_once_the_field_has_come, i, VW_ARRAY_COUNT(cases)) {
    struct step_bench *bench = open_case(i);
    check_stays(bench, 1);
    check_stays(bench, REFERENCE_POSE_WARM_UP);
    for (uint64_t number = 1; number <= 3; number++) check_move(bench, REFERENCE_POSE_WARM_UP + number, 0.0);
    check_move(bench, UINT64_C(1) << 33, 0.0); // saturated, not wrapped to the beginning
    bench->pixels[1].rgba.x = INFINITY;        // a step that is not finite is not taken
    hard_write_pixels(bench);
    check_stays(bench, REFERENCE_POSE_WARM_UP + 4);
}

// ---- Hard cases -----------------------------------------------------------------------------------------------------

static const struct step_case hard = {"pose", .seed = 521, HARD_STEP, .effects = "pose"};

// Places the camera of the step's photo, in box coordinates.
static void place(struct step_bench *bench, const double position[3], const double target[3], double focal_px) {
    struct vw_view *view = &bench->scene->views[bench->view];
    rays_look(view, &bench->model.box, position, target);
    view->camera.focal_x_px = view->camera.focal_y_px = focal_px;
    struct vw_gpu_camera *cameras = test_read(bench->field.cameras);
    cameras[bench->view] = vw_field_camera(&bench->model, view, &bench->model.box);
    test_write(bench->field.cameras, cameras);
}

// Checks rays and moves from the bench's cameras. Returns how many rays hit the box.
static uint32_t check_cameras(struct hard_finding *finding, struct step_bench *bench) {
    struct taken it = take(bench);
    uint32_t hits = check_lines(&it);
    check_move(bench, LATE, 2e-3 * bench->model.specialization.learning_rate);
    check_move(bench, LATE + 1, 2e-3 * bench->model.specialization.learning_rate);
    hard_equal(finding, "flag", 0, hard_state_read(bench).scalars.z, 0.0);
    return hits;
}

static void far_cameras(struct hard_finding *finding) {
    static const double positions[][3] = {{6.0, -4.0, 3.0}, {60.0, 40.0, -30.0}, {6e5, -4.8e5, 6.4e5}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(positions); i++) {
        struct step_bench *bench = open_with(&hard, 0.05f);
        double far = hypot(hypot(positions[i][0], positions[i][1]), positions[i][2]);
        place(bench, positions[i], (const double[3]){0.5, 0.5, 0.5}, 20.0 * far);
        hard_require(finding, check_cameras(finding, bench) > bench->config.rays / 4, "rays hit the box");
        test_release(bench);
    }
}

static void large_corrections(struct hard_finding *finding) {
    check_cameras(finding, open_with(&hard, 0.3f));
    check_cameras(finding, open_with(&hard, 1.0f));
}

// Checks that the ridge alone moves the pose of a camera that sees nothing, towards 0, and by no more than a step.
static void rays_that_miss(struct hard_finding *finding) {
    struct step_bench *bench = open_with(&hard, 1.0f);
    place(bench, (const double[3]){3.0, 3.0, 3.0}, (const double[3]){9.0, 9.0, 9.0}, 20.0);
    double before[REFERENCE_POSE], after[REFERENCE_POSE];
    pose_now(bench, before);
    check_move(bench, LATE, 2e-3 * bench->model.specialization.learning_rate);
    pose_now(bench, after);
    struct vw_pose *d_poses = test_read(bench->step.effect_buffers[VW_SLOT_D_POSES]), zero = {0};
    for (uint32_t i = 0; i < bench->step.padded_rays; i++)
        hard_same_bits(finding, "what a ray says", &d_poses[i], &zero, sizeof zero);
    for (int i = 0; i < REFERENCE_POSE; i++)
        hard_require(finding, fabs(after[i]) < fabs(before[i]), "the ridge pulls to 0");
}

static void photos_without_pixels(struct hard_finding *finding) {
    struct step_bench *bench = open_with(&hard, 0.0f);
    for (uint32_t i = 0; i < bench->config.rays; i++) bench->pixels[i].weight = 0.0f;
    hard_write_pixels(bench);
    step_bench_step(bench, LATE);
    struct hard_state state = hard_state_read(bench);
    struct vw_pose_moments *moments = test_read(bench->step.effect_buffers[VW_SLOT_POSE_MOMENTS]), unvisited = {0};
    hard_same_bits(finding, "params", state.grid.grid, bench->params, bench->model.param_bytes);
    hard_equal(finding, "visits", 0, moments[bench->view].visits, 1.0);
    for (uint32_t view = 0; view < 3; view++)
        if (view != bench->view)
            hard_same_bits(finding, "moments of a photo never visited", &moments[view], &unvisited, sizeof unvisited);
}

static void infinite_losses(struct hard_finding *finding) {
    struct step_bench *bench = open_with(&hard, 0.05f);
    bench->pixels[3].rgba.x = 1e30f;
    hard_write_pixels(bench);
    step_bench_step(bench, LATE);
    struct hard_state state = hard_state_read(bench);
    hard_require(finding, state.skipped, "the step is skipped");
    hard_same_bits(finding, "params", state.grid.grid, bench->params, bench->model.param_bytes);
}

static const struct hard_case hard_poses[] = {
    {"cameras 6 to 600,000 box edges away", "turns that throw all rays off the box; lost digits", far_cameras},
    {"corrections of up to a radian and a box edge", "gradients that hold for small turns alone", large_corrections},
    {"all rays miss the box", "0/0 in Adam; a camera that flies off", rays_that_miss},
    {"a photo without pixels, and one never visited", "a correction without a reason", photos_without_pixels},
    {"infinite losses", "a camera at infinity", infinite_losses},
};
HARD_CASES("pose", hard_poses)
