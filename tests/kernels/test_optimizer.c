// update_grid and update_weights: a flagged step moves nothing, and params stay finite. (Decision 4 and learning rates
// of 1e30: test_hard_training.)
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "gpu/compute.h"
#include "kernels/checks/check.h"
#include "support/gpu_fixture.h"

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

// The same gradient three times at a learning rate near the largest float: the second step would already leave the
// floats.
TEST(a_step_beyond_the_floats_is_not_taken) {
    for (enum vw_optimizer optimizer = VW_OPTIMIZER_LAZY_ADAM; optimizer <= VW_OPTIMIZER_SGD; optimizer++) {
        const struct step_case wild = {.name = "wild learning rate",
                                       .seed = 80,
                                       .levels = 2,
                                       .log2_table = 6,
                                       .width = 16,
                                       .loss = VW_LOSS_L2,
                                       .learning_rate = 3e38,
                                       .optimizer = optimizer};
        struct step_bench *bench = step_bench_open(&wild);
        int64_t *quanta = test_allocate(2 * (size_t)bench->model.pair_count, sizeof *quanta);
        float *d_weights = test_allocate(4 * (size_t)bench->model.moved_columns, sizeof *d_weights);
        float size = 0.9f / bench->model.specialization.inverse_rays; // a mean gradient of 0.9
        for (uint64_t k = 0; k < 2 * (uint64_t)bench->model.pair_count; k++)
            quanta[k] = llrintf(size / bench->model.specialization.gradient_quantum);
        for (uint64_t k = 0; k < 4 * (uint64_t)bench->model.moved_columns; k++) d_weights[k] = k % 2 ? size : -size;
        for (uint32_t number = 1; number <= 3; number++) {
            struct vw_push_update push = {.count = bench->model.moved_columns,
                                          .step_low = number,
                                          .adam = vw_adam_of(&bench->model.specialization)};
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
