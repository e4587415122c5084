// Hard halves: grids in float16 at the ends of what halves hold. Where gradient, learning rate and params are such that
// every number on the way is exact, what is stored must be the half that the reference names, to the bit.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "hard_cases/hard_run.h"
#include "hard_cases/hard_step.h"
#include "support/synthetic_scene.h"

static const struct step_case setup = {.name = "halves",
                                       .seed = 361,
                                       .rays = 64,
                                       .samples = 16,
                                       .levels = 4,
                                       .log2_table = 10,
                                       .width = 16,
                                       .loss = VW_LOSS_L2,
                                       .half_grid = true};
static const double QUANTUM = 0x1p-22; // quantum of the mean gradient, with these rays and samples

static struct vw_scene *scene;

static size_t feature_count(const struct step_bench *bench) { return 2 * (size_t)bench->model.pair_count; }

// Opens plain gradient descent, so that a feature moves by quanta * QUANTUM * learning_rate.
static struct step_bench *open_plain(struct hard_finding *finding, double learning_rate) {
    struct step_case plain = setup;
    plain.optimizer = VW_OPTIMIZER_SGD;
    plain.learning_rate = learning_rate;
    struct step_bench *bench = step_bench_open(&plain);
    const struct vw_specialization *s = &bench->model.specialization;
    hard_require(finding, s->gradient_quantum * s->inverse_rays == QUANTUM && !s->wide_gradient,
                 "one quantum is a power of two");
    return bench;
}

static void set_features(struct step_bench *bench, const float *features) {
    step_bench_put_grid(bench, features, bench->params);
    step_bench_write_params(bench);
}

// Checks one update from these features, which must be halves. A pair of which one would leave the halves stays,
// uncounted, and the flag says so.
static void check_exactly(struct hard_finding *finding, struct step_bench *bench, const float *features,
                          const int64_t *quanta) {
    bool any_left = false;
    double unit = QUANTUM * bench->model.specialization.learning_rate;
    set_features(bench, features);
    grid_write_gradient(bench, quanta);
    step_bench_take_overflows(bench);
    grid_update(bench, 1);
    struct grid_state after = grid_read(bench);
    for (size_t pair = 0; pair < bench->model.pair_count; pair++) {
        const size_t i = 2 * pair;
        double moved[2] = {reference_half(features[i] - (double)quanta[i] * unit),
                           reference_half(features[i + 1] - (double)quanta[i + 1] * unit)};
        bool leaves = !isfinite(moved[0]) || !isfinite(moved[1]), silent = !quanta[i] && !quanta[i + 1];
        for (size_t f = 0; f < 2; f++)
            hard_equal(finding, "stored half", i + f, after.grid[i + f], leaves || silent ? features[i + f] : moved[f]);
        hard_equal(finding, "visits", pair, after.visits[pair], !leaves && !silent);
        any_left |= leaves;
    }
    hard_equal(finding, "flag", 0, step_bench_take_overflows(bench), any_left);
}

// ---- Rounding -------------------------------------------------------------------------------------------------------

// Draws eleven digits, as a half has, and up to 12 more: just below the middle between two halves, in it, just beyond,
// or anywhere.
static int64_t draw_near_middle(struct test_random *random, size_t index) {
    int64_t digits = 1024 + (int64_t)(1023.0f * fabsf(test_random_next(random))), shift = 1 + (int64_t)(index / 4 % 12);
    int64_t middle = INT64_C(1) << (shift - 1),
            anywhere = (int64_t)((float)(2 * middle - 1) * fabsf(test_random_next(random)));
    const int64_t tails[] = {middle - 1, middle, middle + (shift > 1), anywhere};
    return ((digits << shift) + tails[index % 4]) * (index % 3 ? 1 : -1);
}

// Checks the rounding at three scales: halves that are subnormal, usual ones, and the largest ones.
static void rounding_to_halves(struct hard_finding *finding) {
    static const double learning_rates[] = {0x1p-16, 0x1p-12, 0x1p-6, 1.0, 0x1p12, 0x1p15};
    for (size_t k = 0; k < VW_ARRAY_COUNT(learning_rates); k++) {
        struct step_bench *bench = open_plain(finding, learning_rates[k]);
        struct test_random random = {.seed = setup.seed + k};
        float *zeros = test_allocate(feature_count(bench), sizeof *zeros);
        int64_t *quanta = test_allocate(feature_count(bench), sizeof *quanta);
        for (size_t i = 0; i < feature_count(bench); i++) quanta[i] = draw_near_middle(&random, i);
        check_exactly(finding, bench, zeros, quanta);
        test_release(bench);
    }
}

// ---- The largest ----------------------------------------------------------------------------------------------------

// Checks entries that move from the largest half by up to 64 either way, where neighbours are 32 apart: 65520 would
// round to infinity.
static void entries_near_the_largest(struct hard_finding *finding) {
    struct step_bench *bench = open_plain(finding, 1.0);
    float *features = test_allocate(feature_count(bench), sizeof *features);
    int64_t *quanta = test_allocate(feature_count(bench), sizeof *quanta);
    for (size_t i = 0; i < feature_count(bench); i++) {
        features[i] = i % 2 ? -65504.0f : 65504.0f;
        quanta[i] = i % 11 == 4 ? 0 : ((int64_t)(i % 257) - 128) * (INT64_C(1) << 21); // halves of 1
    }
    check_exactly(finding, bench, features, quanta);
}

// ---- The smallest steps ---------------------------------------------------------------------------------------------

enum { SMALL_STEPS = 40 };

// Checks steps of 0.0001: less than half of what lies between 1 and its neighbours (0.00049 below), and many times that
// at 0.01. The former entries never move, while their moments and visits go on; the latter do as the reference says.
static void steps_below_half_a_unit(struct hard_finding *finding) {
    struct step_case slow = setup;
    slow.learning_rate = 1e-4;
    struct step_bench *bench = step_bench_open(&slow);
    float *features = test_allocate(feature_count(bench), sizeof *features);
    int64_t *quanta = test_allocate(feature_count(bench), sizeof *quanta);
    for (size_t i = 0; i < feature_count(bench); i++) {
        features[i] = i / 2 % 2 ? 0.01f : 1.0f;
        quanta[i] = i % 2 ? 100000 : -100000;
    }
    set_features(bench, features);
    struct grid_state before = grid_read(bench);
    for (uint32_t number = 1; number <= SMALL_STEPS; number++) grid_check_update(bench, quanta, number);
    struct grid_state after = grid_read(bench);
    for (size_t i = 0; i < feature_count(bench); i++) {
        if (i / 2 % 2 == 0) hard_equal(finding, "entry of 1", i, after.grid[i], 1.0);
        else
            hard_compare(finding, "way of a small entry", i, before.grid[i] - after.grid[i], i % 2 ? 0.004 : -0.004,
                         0.004, 0.05);
        hard_equal(finding, "visits", i / 2, after.visits[i / 2], SMALL_STEPS);
    }
    hard_equal(finding, "flag", 0, step_bench_take_overflows(bench), 0.0);
}

// ---- Whole steps and trainings --------------------------------------------------------------------------------------

static void steps_of_halves(struct hard_finding *finding) {
    struct step_bench *bench = step_bench_open(&setup);
    for (uint64_t number = 1; number <= 3; number++) {
        struct hard_gradients gradients = hard_take_gradients(bench, number);
        hard_check_gradients(finding, bench, number, &gradients);
        step_bench_step(bench, number);
    }
    hard_check_rendering(finding, bench);
}

static void trainings_on_halves(struct hard_finding *finding) {
    struct vw_config config = hard_run_config();
    config.table_precision = VW_TABLE_FLOAT16;
    scene = synthetic_scene(
        &(struct synthetic_scene_params){.train_views = 5, .val_views = 2, .width_px = 12, .height_px = 8});
    hard_require(finding, !hard_train_well(finding, scene, &config).still, "training moves the params");
    config.learning_rate = 1e6; // the largest that a user may set: no entry's step fits a half
    hard_require(finding, hard_train(finding, scene, &config).flagged_steps > 0, "steps beyond the halves are flagged");
}

static const struct hard_case cases[] = {
    {"middles between halves, subnormal to beyond", "a driver's rounding, not the nearest", rounding_to_halves},
    {"halves near 65504", "infinity is stored, which every sample then sees", entries_near_the_largest},
    {"steps below half a unit of a half", "drift, or moments that stop with the entry", steps_below_half_a_unit},
    {"whole steps on halves", "gradients of other features than those that are stored", steps_of_halves},
    {"trainings on halves", "params that are not finite; steps that no flag tells", trainings_on_halves},
};

int main(void) { return hard_cases_run("halves", cases, VW_ARRAY_COUNT(cases)); }
