// The effect pose against its reference: rays of corrected cameras, the gradient by samples' positions, what rays say
// of a camera, and how it moves. The gradient by the six numbers is held against finite differences of the reference's
// loss, through the camera, the grid and the networks, in double.
//
// Kinks: a difference across a changed decision (another cell of the grid, a ReLU switching, the density reaching its
// maximum, an error changing sign) is not a derivative. Such a ray is skipped; at most one in ten may be.
#include "support/cmocka_test.h"

#include <float.h>

#include "base/memory.h"
#include "reference/effects/pose.h"
#include "reference/step_bench.h"
#include "support/gpu_fixture.h"

enum { STEP = 300, SAMPLES_MAX = 64 };
static const double DIFFERENCE = 1e-7;         // change of a number
static const double POSITION_TOLERANCE = 4e-6; // share of the sizes of what is summed
static const double SUM_TOLERANCE = 1e-5;      // likewise
static const double GRADIENT_TOLERANCE = 2e-3; // share of the largest of a ray's, which floats have summed
static const double LINE_TOLERANCE = 2e-6;     // box edges
static const double MOVE_TOLERANCE = 1e-3;     // share of a step

// `size`: of the corrections. `differs`: whether its loss is the reference's, against which differences are taken.
static const struct {
    struct step_case setup;
    float size;
    bool differs;
} cases[] = {
    {{.name = "default sizes", .seed = 501, .loss = VW_LOSS_L2}, 0.02f, true},
    {{.name = "no correction", .seed = 502, .rays = 16, .samples = 16, .loss = VW_LOSS_L2}, 0.0f, true},
    {{.name = "large corrections, four features, distortion",
      .seed = 503,
      .rays = 256,
      .samples = 7,
      .features = 4,
      .levels = 2,
      .width = 16,
      .effects = "distortion"},
     0.5f,
     true},
    {{.name = "wide network, by storage buffers, plain descent",
      .seed = 504,
      .rays = 16,
      .samples = 48,
      .width = 64,
      .loss = VW_LOSS_HUBER,
      .optimizer = VW_OPTIMIZER_SGD,

      .as_on_gpus = true,
      .effects = "background"},
     0.02f,
     true},
    {{.name = "momentum", .seed = 505, .beta1 = 0.9, .loss = VW_LOSS_L2}, 0.02f, true},
    {{.name = "importance samples", .seed = 506, .importance_samples = 16, .loss = VW_LOSS_L2}, 0.02f, true},
    {{.name = "other effects",
      .seed = 508,

      .optimizer = VW_OPTIMIZER_DENSE_ADAM,
      .loss = VW_LOSS_L2,
      .effects = "sky,appearance,appearance_code,visibility"},
     0.02f,
     false},
    {{.name = "transient", .seed = 509, .loss = VW_LOSS_L2, .effects = "transient"}, 0.02f, false},
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

static struct step_bench *open_case(size_t index) {
    struct step_case setup = cases[index].setup;
    setup.another_effect = "pose";
    struct step_bench *bench = step_bench_open(&setup);
    float *poses = bench->params + bench->model.ranges[VW_SLOT_POSES].offset_bytes / sizeof *poses;
    for (size_t i = 0; i < bench->model.ranges[VW_SLOT_POSES].size_bytes / sizeof *poses; i++)
        poses[i] *= cases[index].size / 0.05f;
    step_bench_write_params(bench);
    for (uint32_t i = 0; i < bench->config.rays; i++) bench->pixels[i].view = bench->view;
    memcpy(vw_buffer_map(bench->pixel_buffer), bench->pixels, bench->config.rays * sizeof *bench->pixels);
    return bench;
}

static struct taken take(struct step_bench *bench) {
    struct taken it = {.bench = bench, .view = &bench->scene->views[bench->view]};
    step_bench_gradients(bench, STEP);
    float *params = step_bench_read(bench, bench->field.params);
    it.params = reference_params_create(&bench->model, params);
    reference_pose_of(&bench->model, params, bench->view, it.pose);
    it.step = step_bench_reference(bench);
    it.rows = step_bench_read_rows(bench);
    it.d_positions = step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_D_POSITIONS]);
    it.d_poses = step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_D_POSES]);
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

// ---- Rays -----------------------------------------------------------------------------------------------------------

static void check_line(const struct taken *it, uint32_t index) {
    const struct reference_ray *ray = &it->step->rays[index];
    double origin[3], direction[3], along = offset_of(it, index);
    line_of(it, it->pose, index, origin, direction);
    for (int i = 0; i < 3; i++) {
        check_value(it->bench->where, "direction", index, ray->direction[i], direction[i], LINE_TOLERANCE);
        check_value(it->bench->where, "origin", index, ray->origin[i], origin[i] + along * direction[i],
                    LINE_TOLERANCE * (1.0 + fabs(along)));
    }
}

// ---- Positions and rays ---------------------------------------------------------------------------------------------

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

TEST_CASES(gradients_are_those_of_the_reference, i, VW_ARRAY_COUNT(cases)) {
    struct step_bench *bench = open_case(i);
    struct taken it = take(bench);
    for (uint32_t ray = 0; ray < bench->step.padded_rays; ray++) {
        check_line(&it, ray);
        check_sums(&it, ray);
    }
    for (uint32_t k = 0; k < bench->padded_samples; k++) check_position(&it, k);
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

TEST(the_gradient_is_the_slope_of_the_loss) {
    uint32_t skipped = 0, all = 0;
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        if (!cases[i].differs) continue;
        struct step_bench *bench = open_case(i);
        struct taken it = take(bench);
        uint32_t rays = bench->config.rays < 32 ? bench->config.rays : 32;
        all += rays;
        for (uint32_t ray = 0; ray < rays; ray++) {
            double slopes[REFERENCE_POSE], found[REFERENCE_POSE], scale;
            const float *own = it.d_poses + 8 * (size_t)ray;
            const double force[3] = {own[0], own[1], own[2]}, torque[3] = {own[4], own[5], own[6]};
            if (!differentiate(&it, ray, slopes)) {
                skipped++;
                continue;
            }
            reference_pose_gradient(it.view, &bench->model.box, it.pose, force, torque, found);
            scale = fmax(largest(slopes, REFERENCE_POSE), 1e-4);
            for (int k = 0; k < REFERENCE_POSE; k++)
                check_value(bench->where, "gradient by the pose", REFERENCE_POSE * ray + k, found[k], slopes[k],
                            GRADIENT_TOLERANCE * scale);
        }
        test_release(bench);
    }
    if (10 * skipped > all) fail_msg("%u of %u rays stand at kinks", skipped, all);
}

// ---- Moves ----------------------------------------------------------------------------------------------------------

static void sum_rays(const struct step_bench *bench, const float *d_poses, double force[3], double torque[3]) {
    memset(force, 0, 3 * sizeof *force);
    memset(torque, 0, 3 * sizeof *torque);
    for (uint32_t i = 0; i < 3 * bench->step.padded_rays; i++) {
        force[i % 3] += d_poses[8 * (i / 3) + i % 3];
        torque[i % 3] += d_poses[8 * (i / 3) + 4 + i % 3];
    }
}

static void check_move(struct step_bench *bench, uint64_t number) {
    const struct vw_specialization *s = &bench->model.specialization;
    const struct vw_view *view = &bench->scene->views[bench->view];
    size_t first = bench->model.ranges[VW_SLOT_POSES].offset_bytes / 4,
           all = bench->model.ranges[VW_SLOT_POSES].size_bytes;
    float *before = step_bench_read(bench, bench->field.params);
    struct vw_pose_moments *moments = step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_POSE_MOMENTS]);
    step_bench_step(bench, number);
    float *after = step_bench_read(bench, bench->field.params),
          *d_poses = step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_D_POSES]);
    struct vw_pose_moments *moments_after = step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_POSE_MOMENTS]);
    double pose[REFERENCE_POSE], moved[REFERENCE_POSE], gradient[REFERENCE_POSE], force[3], torque[3];
    reference_pose_of(&bench->model, before, bench->view, pose);
    reference_pose_of(&bench->model, after, bench->view, moved);
    sum_rays(bench, d_poses, force, torque);
    reference_pose_gradient(view, &bench->model.box, pose, force, torque, gradient);
    assert_int_equal(moments_after[bench->view].visits, moments[bench->view].visits + 1);
    for (int i = 0; i < REFERENCE_POSE; i++) {
        const float *own = (const float *)&moments[bench->view] + i / 3 * 8 + i % 3;
        double moment1 = own[0], moment2 = own[4], rate = reference_pose_rate(moments[bench->view].visits + 1),
               mean = gradient[i] * s->inverse_rays + reference_pose_ridge * pose[i],
               by = rate * reference_adam(s, mean, moments[bench->view].visits + 1, &moment1, &moment2);
        check_value(bench->where, "pose", i, moved[i], pose[i] - by, MOVE_TOLERANCE * fabs(by) + 1e-7 * fabs(pose[i]));
        ((float *)after)[first + 8 * bench->view + i / 3 * 4 + i % 3] = (float)pose[i];
    }
    check_same_bits(bench->where, "other photos' poses", after + first, before + first, all);
    memcpy(&moments_after[bench->view], &moments[bench->view], sizeof *moments);
    check_same_bits(bench->where, "other photos' moments", moments_after, moments,
                    vw_buffer_size_bytes(bench->step.effect_buffers[VW_SLOT_POSE_MOMENTS]));
}

static void check_stays(struct step_bench *bench, uint64_t number) {
    size_t first = bench->model.ranges[VW_SLOT_POSES].offset_bytes / 4;
    float *before = step_bench_read(bench, bench->field.params);
    struct vw_pose_moments *moments = step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_POSE_MOMENTS]);
    step_bench_step(bench, number);
    float *after = step_bench_read(bench, bench->field.params);
    struct vw_pose_moments *moments_after = step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_POSE_MOMENTS]);
    check_same_bits(bench->where, "poses", after + first, before + first,
                    bench->model.ranges[VW_SLOT_POSES].size_bytes);
    check_same_bits(bench->where, "moments", moments_after, moments,
                    vw_buffer_size_bytes(bench->step.effect_buffers[VW_SLOT_POSE_MOMENTS]));
}

TEST_CASES(cameras_move_once_the_field_has_come, i, VW_ARRAY_COUNT(cases)) {
    struct step_bench *bench = open_case(i);
    check_stays(bench, 1);
    check_stays(bench, REFERENCE_POSE_WARM_UP);
    for (uint64_t number = 1; number <= 3; number++) check_move(bench, REFERENCE_POSE_WARM_UP + number);
    check_move(bench, UINT64_C(1) << 33); // saturated, not wrapped to the beginning
    bench->pixels[1].rgba.x = INFINITY;   // a step that is not finite is not taken
    memcpy(vw_buffer_map(bench->pixel_buffer), bench->pixels, bench->config.rays * sizeof *bench->pixels);
    check_stays(bench, REFERENCE_POSE_WARM_UP + 4);
}

TEST_GROUP(NULL, test_gpu_close)
