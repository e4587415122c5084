// Decision 4 in update_grid and update_weights: what lazy Adam promises of silent entries, and that params stay finite.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "gpu/compute.h"
#include "kernels/checks/check.h"
#include "support/gpu_fixture.h"

enum { SILENT_STEPS = 10000, USUAL_QUANTA = 100000 };

static float entry(struct step_bench *bench, uint64_t feature) {
    struct grid_state now = grid_read(bench);
    float value = now.grid[feature];
    return value;
}

static void stay_silent(struct step_bench *bench, uint32_t first_step) {
    for (uint32_t step = 0; step < SILENT_STEPS;) {
        vw_submission_begin(bench->submission);
        for (uint32_t i = 0; i < 500; i++, step++) {
            struct vw_push_update push = {.count = bench->model.pair_count, .step_low = first_step + step};
            vw_submission_dispatch(bench->submission, bench->step.update_grid[0], &push, sizeof push, push.count);
        }
        assert_int_equal(vw_submission_submit(bench->submission), VW_OK);
        assert_int_equal(vw_submission_wait(bench->submission), VW_OK);
    }
}

// Feature 0 speaks for 20 steps, is silent for 10,000, and speaks again; feature 8 speaks then for the first time.
TEST(a_long_silence_does_not_lengthen_the_next_step) {
    static const struct step_case lazy = {
        .name = "a long silence", .seed = 71, .levels = 2, .log2_table = 6, .width = 16};
    struct step_bench *bench = step_bench_open(&lazy);
    double rate = bench->model.specialization.learning_rate;
    int64_t *quanta = test_allocate(2 * (size_t)bench->model.pair_count, sizeof *quanta);
    quanta[0] = USUAL_QUANTA;
    for (uint64_t number = 1; number <= 20; number++) {
        grid_write_gradient(bench, quanta);
        grid_update(bench, number);
    }
    struct grid_state before = grid_read(bench);
    stay_silent(bench, 21);
    struct grid_state after = grid_read(bench);
    check_same_bits(bench->where, "params of silent entries", after.grid, before.grid, bench->model.param_bytes);
    check_same_bits(bench->where, "moment2 of silent entries", after.moment2, before.moment2,
                    8 * (size_t)bench->model.pair_count);
    check_same_bits(bench->where, "visits of silent entries", after.visits, before.visits,
                    4 * (size_t)bench->model.pair_count);

    quanta[8] = -USUAL_QUANTA;
    grid_write_gradient(bench, quanta);
    grid_update(bench, 21 + SILENT_STEPS);
    double again = before.grid[0] - (double)entry(bench, 0), first = (double)entry(bench, 8) - before.grid[8];
    assert_true(again > 0.9 * rate && again <= 1.1 * rate);
    check_value(bench->where, "first step", 8, first / rate, 1.0,
                2.0 / USUAL_QUANTA + 1e-4); // epsilon is one quantum; params round to 1e-7
}

TEST_CASES(a_step_flagged_nonfinite_only_clears_the_gradient, i, step_case_count) {
    struct step_bench *bench = step_bench_open(&step_cases[i]);
    int64_t *quanta = test_allocate(2 * (size_t)bench->model.pair_count, sizeof *quanta);
    float *d_weights = test_allocate(4 * (size_t)bench->model.moved_columns, sizeof *d_weights);
    struct test_random random = {.seed = step_cases[i].seed};
    grid_random_gradient(bench, INPUT_ORDINARY, &random, quanta);
    for (uint32_t j = 0; j < 4 * bench->model.moved_columns; j++) d_weights[j] = test_random_next(&random);
    grid_check_update(bench, quanta, 1); // so that the moments are not all 0
    weights_check_update(bench, d_weights, 1);
    grid_write_gradient(bench, quanta);
    step_bench_write(bench, bench->field.step_state, &(struct vw_step_state){.nonfinite = 1});
    struct grid_state before = grid_read(bench);
    float *moments_before = step_bench_read(bench, bench->step.weight_moments);
    grid_update(bench, 2);
    weights_update(bench, 2);
    struct grid_state after = grid_read(bench);
    float *moments = step_bench_read(bench, bench->step.weight_moments);
    size_t pairs = bench->model.pair_count;
    check_same_bits(bench->where, "params", after.grid, before.grid, bench->model.param_bytes);
    check_same_bits(bench->where, "moment2", after.moment2, before.moment2, 8 * pairs);
    if (after.moment1) check_same_bits(bench->where, "moment1", after.moment1, before.moment1, 8 * pairs);
    check_same_bits(bench->where, "visits", after.visits, before.visits, 4 * pairs);
    check_same_bits(bench->where, "weight moments", moments, moments_before,
                    vw_buffer_size_bytes(bench->step.weight_moments));
    grid_check_cleared(bench);
}

static void check_finite(struct step_bench *bench) {
    float *params = step_bench_read(bench, bench->field.params);
    for (uint64_t i = 0; i < bench->model.param_bytes / 4; i++)
        if (!isfinite(params[i])) fail_msg("%s: parameter %llu is %g", bench->where, (unsigned long long)i, params[i]);
    assert_true(memcmp(params, bench->params, bench->model.param_bytes) != 0);
}

static struct step_bench *open_wild(double learning_rate, enum vw_optimizer optimizer) {
    struct step_case wild = {
        .name = "wild learning rate", .seed = 80, .levels = 2, .log2_table = 6, .width = 16, .loss = VW_LOSS_L2};
    wild.learning_rate = learning_rate;
    wild.optimizer = optimizer;
    return step_bench_open(&wild);
}

static const enum vw_optimizer optimizers[] = {VW_OPTIMIZER_LAZY_ADAM, VW_OPTIMIZER_DENSE_ADAM, VW_OPTIMIZER_SGD};

TEST(params_stay_finite_at_a_learning_rate_of_1e30) {
    for (int i = 0; i < 3; i++) {
        struct step_bench *bench = open_wild(1e30, optimizers[i]);
        for (uint64_t number = 1; number <= 5; number++) step_bench_step(bench, number);
        check_finite(bench);
        test_release(bench);
    }
}

// The same gradient three times at a learning rate near the largest float: the second step would already leave the
// floats.
TEST(a_step_beyond_the_floats_is_not_taken) {
    for (int i = 0; i < 3; i++) {
        struct step_bench *bench = open_wild(3e38, optimizers[i]);
        int64_t *quanta = test_allocate(2 * (size_t)bench->model.pair_count, sizeof *quanta);
        float *d_weights = test_allocate(4 * (size_t)bench->model.moved_columns, sizeof *d_weights);
        float size = 0.9f / bench->model.specialization.inverse_rays; // a mean gradient of 0.9
        for (uint64_t k = 0; k < 2 * (uint64_t)bench->model.pair_count; k++)
            quanta[k] = llrintf(size / bench->model.specialization.gradient_quantum);
        for (uint64_t k = 0; k < 4 * (uint64_t)bench->model.moved_columns; k++) d_weights[k] = k % 2 ? size : -size;
        for (uint32_t number = 1; number <= 3; number++) {
            struct vw_push_update push = {.count = bench->model.moved_columns, .step_low = number};
            grid_write_gradient(bench, quanta);
            grid_update(bench, number);
            step_bench_write(bench, bench->step.d_weights, d_weights);
            step_bench_dispatch(bench, bench->step.update_weights, &push, sizeof push, push.count);
        }
        check_finite(bench);
        assert_int_equal(step_bench_take_overflows(bench), 1 + bench->model.window_count); // and the flags say so
        test_release(bench);
    }
}

TEST_GROUP(NULL, test_gpu_close)
