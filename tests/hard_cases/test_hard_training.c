// Hard training: densities beyond exp and of nothing, 4,096 samples on a ray, learning rates that diverge, gradients at
// their clamp, entries long silent, extreme seeds and step numbers. What a step makes of params and moments is held
// against the reference, from the device's own gradients where those are not the point.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "gpu/compute.h"
#include "hard_cases/hard_run.h"
#include "hard_cases/hard_step.h"
#include "support/synthetic_scene.h"

static const struct step_case setup = {"training", .seed = 341, HARD_STEP};

static const double STEP_TOLERANCE =
    1e-4; // learning rates: params of up to 1/2 round to 3e-8, and the device's exp2 and log2 enter

static struct vw_scene *scene;

static void open_scene(void) {
    scene = synthetic_scene(
        &(struct synthetic_scene_params){.train_views = 5, .val_views = 2, .width_px = 12, .height_px = 8});
}

// ---- Media ----------------------------------------------------------------------------------------------------------

static void check_densities(struct hard_finding *finding, struct step_bench *bench, double expected, double tolerance) {
    vw_float4 *samples = test_read(bench->volume->samples);
    for (uint32_t i = 0; i < bench->padded_samples; i++)
        hard_compare(finding, "density", i, samples[i].w, expected, 1.0, tolerance);
}

// Checks densities from just above the largest to beyond the floats.
static void density_beyond_exp(struct hard_finding *finding) {
    static const float weights[] = {1e3f, 1e6f, 1e30f, 3e38f};
    struct step_bench *bench = step_bench_open(&setup);
    for (size_t i = 0; i < VW_ARRAY_COUNT(weights); i++) {
        hard_set_density(bench, weights[i]);
        hard_check_step(finding, bench, 3);
        check_densities(finding, bench, reference_density_max, 0.0);
        hard_check_rendering(finding, bench);
    }
}

// Checks that in empty space the background alone is seen, and no gradient comes back.
static void no_density_anywhere(struct hard_finding *finding) {
    static const float weights[] = {-1e3f, -1e30f, -3e38f};
    struct step_case white = setup;
    white.effects = "background";
    struct step_bench *bench = step_bench_open(&white);
    for (size_t i = 0; i < VW_ARRAY_COUNT(weights); i++) {
        hard_set_density(bench, weights[i]);
        hard_check_step(finding, bench, 3);
        check_densities(finding, bench, 0.0, 0.0);
        hard_check_rendering(finding, bench);
        float *params = test_read(bench->field.params);
        hard_same_bits(finding, "params that no light met", params, bench->params, bench->model.param_bytes);
    }
}

// Checks 8,192 trips through the loops of backward_rays, of the 65,535 that lavapipe allows; jitter of 12 bits within a
// stratum.
static void many_samples(struct hard_finding *finding) {
    struct step_case long_rays = setup;
    long_rays.rays = 2;
    long_rays.samples = 4096;
    struct step_bench *bench = step_bench_open(&long_rays);
    hard_check_step(finding, bench, 3);
    hard_check_rendering(finding, bench);
}

// ---- Divergence -----------------------------------------------------------------------------------------------------

// Checks that a finite step moves every param as the reference's optimiser does from the same gradients, and that one
// that is not finite is flagged and moves none. Returns how many were flagged.
static uint32_t follow_steps(struct hard_finding *finding, struct step_bench *bench, uint64_t steps) {
    uint32_t flagged = 0;
    for (uint64_t number = 1; number <= steps; number++) {
        struct hard_gradients gradients = hard_take_gradients(bench, number);
        struct hard_state before = hard_state_read(bench);
        step_bench_step(bench, number);
        struct hard_state after = hard_state_read(bench);
        hard_check_update(finding, bench, number, &gradients, &before, &after);
        flagged += after.scalars.z != 0.0f;
    }
    return flagged;
}

static uint32_t diverge(struct hard_finding *finding, enum vw_optimizer optimizer, double learning_rate) {
    struct step_case wild = setup;
    wild.optimizer = optimizer;
    wild.learning_rate = learning_rate;
    struct step_bench *bench = step_bench_open(&wild);
    uint32_t flagged = follow_steps(finding, bench, 6);
    return flagged;
}

static void learning_rates_that_diverge(struct hard_finding *finding) {
    static const enum vw_optimizer optimizers[] = {VW_OPTIMIZER_LAZY_ADAM, VW_OPTIMIZER_DENSE_ADAM, VW_OPTIMIZER_SGD};
    uint32_t flagged = 0;
    for (size_t i = 0; i < VW_ARRAY_COUNT(optimizers); i++) {
        struct vw_config config = hard_run_config();
        config.optimizer = optimizers[i];
        config.learning_rate = 1e6; // the largest that a user may set
        open_scene();
        hard_train(finding, scene, &config);
        diverge(finding, optimizers[i], 1e6);
        flagged += diverge(finding, optimizers[i], 1e30);
    }
    hard_require(finding, flagged > 0, "a learning rate of 1e30 makes steps that are not finite");
}

static void scale_matrix(struct step_bench *bench, uint32_t matrix, uint32_t out, uint32_t in, float scale) {
    float *params = bench->params + bench->model.weights.offset_bytes / sizeof(float);
    for (uint32_t i = 0; i < out * in; i++)
        params[reference_block_index(&bench->model.specialization, matrix, i / in, i % in)] *= scale;
}

// Scales the first matrix by 10^-22 and the second by 10^22: the same field, but the first one's gradients are of order
// 10^22. Their squares leave the floats, and a second moment that is infinite would hold the weight in its place for
// ever.
static void gradients_with_infinite_squares(struct hard_finding *finding) {
    struct step_bench *bench = step_bench_open(&setup);
    scale_matrix(bench, 0, bench->config.width, bench->config.levels * bench->config.features, 1e-22f);
    scale_matrix(bench, 1, REFERENCE_GEO, bench->config.width, 1e22f);
    step_bench_write_params(bench);
    hard_equal(finding, "flagged steps", 0, follow_steps(finding, bench, 1), 1.0);
}

// ---- The fixed-point clamp ------------------------------------------------------------------------------------------

// Makes the activation rows that scatter_grid reads: the gradients of all samples are at the clamp or far beyond, all
// in the one entry of each level. Two thirds of the samples sit at corners of the box, lattice points of every level,
// so that each adds to one entry a whole number; the others at a cell's centre of level 0, where all weights are 1/8.
static float *clamped_rows(const struct step_bench *bench, float sign) {
    const struct vw_specialization *s = &bench->model.specialization;
    struct step_rows row = step_bench_rows(bench);
    uint32_t encoding = bench->config.levels * bench->config.features;
    size_t count;
    float *rows = step_bench_new_rows(bench, &count);
    for (uint32_t i = 0; i < s->chunk_samples; i++) {
        float *position = step_bench_row(bench, rows, row.position, i);
        position[3] = 1.0f; // the ray's weight
        for (uint32_t axis = 0; axis < 3; axis++) position[axis] = i % 3 == 1 ? 0.0625f : (float)(i >> axis & 1);
        for (uint32_t j = 0; j < encoding; j++)
            step_bench_row(bench, rows, row.d_encoding + j / 4, i)[j % 4] =
                sign * (j % 2 ? -1.0f : 1.0f) * (i % 3 ? s->gradient_clamp : 1e30f);
    }
    return rows;
}

// Checks the entry of level 0, whose sum is exact, after a step by its sum: one learning rate, as after any first
// gradient.
static void check_clamped_update(struct hard_finding *finding, struct step_bench *bench, double sum_quanta) {
    const struct vw_specialization *s = &bench->model.specialization;
    double moment1 = 0.0, moment2 = 0.0;
    double moved = reference_adam(s, sum_quanta * s->gradient_quantum * s->inverse_rays, 1, &moment1, &moment2);
    grid_update(bench, 1);
    struct grid_state after = grid_read(bench);
    hard_compare(finding, "step at the clamp", 0, bench->params[0] - (double)after.grid[0], moved, s->learning_rate,
                 STEP_TOLERANCE);
    hard_compare(finding, "second moment at the clamp", 0, after.moment2[0], moment2, moment2, 1e-6);
}

static void check_clamped_sums(struct hard_finding *finding, struct step_bench *bench, float sign) {
    const struct vw_specialization *s = &bench->model.specialization;
    float *rows = clamped_rows(bench, sign);
    struct vw_step_state flags;
    scatter_run(bench, rows, &flags);
    uint64_t *words = test_read(bench->volume->d_grid);
    int64_t *quanta = test_allocate(2 * (size_t)bench->layout->pair_count, sizeof *quanta);
    reference_unpack_grid(&bench->model, words, quanta);
    double samples = bench->padded_samples, sum = sign * samples * s->gradient_clamp / s->gradient_quantum;
    hard_require(finding, fabs(sum) < (s->wide_gradient ? 0x1p62 : 0x1p31), "the sum fits its word");
    for (uint32_t level = 0; level < s->levels; level++)
        for (uint32_t f = 0; f < bench->config.features; f++)
            hard_compare(finding, "sum at the clamp (quanta)", level, (double)quanta[2 * s->first_pair[level] + f],
                         f % 2 ? -sum : sum, 1.0, level ? 4.0 * samples + 32.0 * FLOAT_ROUNDING * fabs(sum) : 0.0);
    hard_equal(finding, "clamped contributions", 0, flags.clamped,
               (double)((bench->padded_samples + 2) / 3 * bench->config.levels * bench->config.features));
    hard_equal(finding, "flag", 0, flags.nonfinite, 0.0);
    check_clamped_update(finding, bench, sum);
}

// Checks 30,720 samples, about as many as narrow words take, and 61,440, which take wide ones.
static void gradients_at_the_clamp(struct hard_finding *finding) {
    for (uint32_t rays = 1024; rays <= 2048; rays *= 2) {
        struct step_case crowd = setup;
        crowd.rays = rays;
        crowd.samples = 30;
        crowd.one_entry = true;
        for (int negative = 0; negative < 2; negative++) {
            struct step_bench *bench = step_bench_open(&crowd);
            hard_require(finding, bench->model.specialization.wide_gradient == (rays > 1024),
                         "the larger crowd takes wide words");
            check_clamped_sums(finding, bench, negative ? -1.0f : 1.0f);
            test_release(bench);
        }
    }
}

// ---- Silence --------------------------------------------------------------------------------------------------------

enum { SPOKEN_STEPS = 20, SILENT_STEPS = 10000, SUBMISSION_STEPS = 500 };

static void stay_silent(struct step_bench *bench, uint32_t first_step) {
    for (uint32_t step = 0; step < SILENT_STEPS; step += SUBMISSION_STEPS) {
        vw_submission_begin(bench->submission);
        for (uint32_t i = 0; i < SUBMISSION_STEPS; i++) {
            struct vw_push_update push = {.count = bench->layout->pair_count,
                                          .step_low = first_step + step + i,
                                          .adam = vw_adam_of(&bench->model.specialization)};
            vw_submission_dispatch(bench->submission, bench->volume->update_grid[0], &push, sizeof push, push.count);
        }
        test_submit(bench->submission);
    }
}

// Three features of different pairs: one is touched again as usual, one with a small gradient the other way, and one
// for the first time.
enum { VOICES = 3 };
static const struct {
    uint64_t feature;
    int64_t usual_quanta, last_quanta;
} voices[VOICES] = {{0, 100000, 100000}, {8, 100000, -30}, {16, 0, -100000}};

struct reference_entry {
    uint64_t visits;
    double moment1, moment2;
};

// Takes one step in which the voices have these gradients and all else is silent; each moves as its reference does.
static void speak(struct hard_finding *finding, struct step_bench *bench, const int64_t gradients[VOICES],
                  uint32_t step, struct reference_entry references[VOICES]) {
    const struct vw_specialization *s = &bench->model.specialization;
    int64_t *quanta = test_allocate(2 * (size_t)bench->layout->pair_count, sizeof *quanta);
    struct grid_state before = grid_read(bench);
    for (int v = 0; v < VOICES; v++) quanta[voices[v].feature] = gradients[v];
    grid_write_gradient(bench, quanta);
    grid_update(bench, step);
    struct grid_state after = grid_read(bench);
    for (int v = 0; v < VOICES; v++) {
        if (!gradients[v]) continue;
        double gradient = (double)gradients[v] * s->gradient_quantum * s->inverse_rays, rate = s->learning_rate;
        double expected =
            reference_adam(s, gradient, ++references[v].visits, &references[v].moment1, &references[v].moment2);
        double moved = (double)before.grid[voices[v].feature] - after.grid[voices[v].feature];
        hard_compare(finding, step <= SPOKEN_STEPS ? "step of an entry" : "step after the silence", (uint64_t)v, moved,
                     expected, rate, STEP_TOLERANCE);
        hard_require(finding, fabs(moved) <= 1.1 * rate, "no step is longer than 1.1 learning rates (decision 4)");
    }
}

static void entry_long_silent(struct hard_finding *finding) {
    struct step_bench *bench = step_bench_open(&setup);
    struct reference_entry references[VOICES] = {0};
    int64_t usual[VOICES], last[VOICES];
    for (int v = 0; v < VOICES; v++) {
        usual[v] = voices[v].usual_quanta;
        last[v] = voices[v].last_quanta;
    }
    for (uint32_t step = 1; step <= SPOKEN_STEPS; step++) speak(finding, bench, usual, step, references);
    struct grid_state before = grid_read(bench);
    stay_silent(bench, SPOKEN_STEPS + 1);
    struct grid_state after = grid_read(bench);
    hard_same_bits(finding, "params in silence", after.grid, before.grid, bench->model.param_bytes);
    hard_same_bits(finding, "visits in silence", after.visits, before.visits, 4 * (size_t)bench->layout->pair_count);
    hard_same_bits(finding, "moments in silence", after.moment2, before.moment2, 8 * (size_t)bench->layout->pair_count);
    speak(finding, bench, last, SPOKEN_STEPS + SILENT_STEPS + 1, references);
}

// ---- Seeds and step numbers -----------------------------------------------------------------------------------------

static void extreme_seeds(struct hard_finding *finding) {
    static const uint64_t seeds[] = {0, INT64_MAX};
    struct vw_step_record last[2];
    for (int i = 0; i < 2; i++) {
        struct step_case seeded = setup;
        seeded.seed = seeds[i];
        struct step_bench *bench = step_bench_open(&seeded);
        for (uint64_t number = 1; number <= 2; number++) hard_check_step(finding, bench, number);
        test_release(bench);
        struct vw_config config = hard_run_config();
        config.seed = seeds[i];
        open_scene();
        last[i] = hard_train_well(finding, scene, &config).last;
    }
    hard_require(finding, last[0].val_l1 != last[1].val_l1, "the seeds make two runs");
}

// Numbers as vw_step_record_passes() gets them; jitter is keyed by 56 bits of the number. The optimisers count with 31
// bits and stay there.
static const uint64_t numbers[] = {INT32_MAX,         UINT64_C(1) << 31,       UINT32_MAX,
                                   UINT64_C(1) << 32, (UINT64_C(1) << 32) + 1, UINT64_C(0x123456789ab)};

static void set_visits(struct step_bench *bench, uint32_t visits) {
    uint32_t *all = test_allocate(bench->layout->pair_count, sizeof *all);
    for (uint32_t i = 0; i < bench->layout->pair_count; i++) all[i] = visits;
    test_write(bench->volume->grid_visits, all);
}

static void steps_past_2_31(struct hard_finding *finding) {
    struct step_case variants[3] = {setup, setup, setup};
    variants[1].optimizer = VW_OPTIMIZER_DENSE_ADAM;
    variants[2].beta1 = 0.9;
    variants[2].beta2 = 0.999;
    for (int v = 0; v < 3; v++) {
        struct step_bench *bench = step_bench_open(&variants[v]);
        for (size_t i = 0; i < VW_ARRAY_COUNT(numbers); i++) {
            set_visits(bench, numbers[i] > UINT32_MAX ? UINT32_MAX
                                                      : (uint32_t)numbers[i]); // an entry that every step has touched
            hard_check_step(finding, bench, numbers[i]);
        }
        test_release(bench);
    }
}

static const struct hard_case cases[] = {
    {"density so high that exp overflows", "inf * 0 in the backward pass: NaN gradients", density_beyond_exp},
    {"zero density everywhere", "0/0 in Adam; background off by rounding", no_density_anywhere},
    {"4,096 samples on a ray", "loops cut short by the driver; sums that lose the small", many_samples},
    {"gradients at the fixed-point clamp", "the sum of all samples leaves its bits", gradients_at_the_clamp},
    {"diverging learning rates", "NaN in params or records that no flag tells", learning_rates_that_diverge},
    {"gradients whose squares are infinite", "an infinite second moment holds its weight for ever",
     gradients_with_infinite_squares},
    {"an entry silent for 10,000 steps, then touched", "a leap of many learning rates", entry_long_silent},
    {"seeds 0 and 2^63 - 1", "half of the key lost: runs alike", extreme_seeds},
    {"step counts past 2^31", "counts that wrap: jitter repeats, bias correction 0/0", steps_past_2_31},
};

HARD_CASES("training", cases)
