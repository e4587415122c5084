// update_grid and update_weights against the twin, on hand-made gradients, and decision 4: what lazy Adam promises of silent entries.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "reference/reference.h"
#include "reference/step_bench.h"
#include "viewworth/memory.h"

// Of a step's length: the device's exp2 and log2 in the bias correction may be off by 2^-21 (Vulkan's bound), and 1 - beta^n magnifies that
// at the first visits by 1 / (1 - beta).
static const double STEP_TOLERANCE = 5e-4;
static const double MOMENT_TOLERANCE = 1e-6; // of the terms: 1 - beta in float, and a few roundings
static const double FLOAT_EPSILON = 0x1p-24;

static const struct step_case cases[] = {
    {.name = "lazy Adam, narrow", .seed = 61, .levels = 2, .log2_table = 6, .width = 16},
    {.name = "lazy Adam, momentum, wide", .seed = 62, .levels = 2, .log2_table = 6, .width = 16, .beta1 = 0.9, .wide = true},
    {.name = "dense Adam, narrow", .seed = 63, .levels = 2, .log2_table = 6, .width = 16, .optimizer = VW_OPTIMIZER_DENSE_ADAM},
    {.name = "dense Adam, momentum, wide",
     .seed = 64,
     .levels = 2,
     .log2_table = 6,
     .width = 16,
     .optimizer = VW_OPTIMIZER_DENSE_ADAM,
     .beta1 = 0.8,
     .wide = true,
     .beta2 = 0.999},
    {.name = "gradient descent", .seed = 65, .levels = 2, .log2_table = 6, .width = 16, .optimizer = VW_OPTIMIZER_SGD},
};

// All that the optimiser may change of the grid.
struct grid_state {
    float *grid, *moment1, *moment2; // per feature; moment1 NULL without momentum
    uint32_t *visits;                // per pair
};

static struct grid_state read_grid(struct step_bench *bench) {
    bool momentum = bench->model.specialization.momentum;
    return (struct grid_state){step_bench_read(bench, bench->field.params),
                               momentum ? step_bench_read(bench, bench->step.grid_moment1) : NULL,
                               step_bench_read(bench, bench->step.grid_moment2), step_bench_read(bench, bench->step.grid_visits)};
}

static void free_grid(struct grid_state *state) {
    free(state->grid);
    free(state->moment1);
    free(state->moment2);
    free(state->visits);
}

static uint64_t pack_pair(int64_t first, int64_t second) { return (uint64_t)first + ((uint64_t)second << 32); }

static void write_quanta(struct step_bench *bench, const int64_t *quanta) {
    uint64_t pairs = bench->model.pair_count;
    uint64_t *words = vw_allocate(2 * pairs, sizeof *words);
    for (uint64_t i = 0; i < 2 * pairs; i++) {
        if (bench->model.specialization.wide_gradient) words[i] = (uint64_t)quanta[i];
        else words[i / 2] = pack_pair(quanta[i / 2 * 2], quanta[i / 2 * 2 + 1]);
    }
    step_bench_write(bench, bench->step.d_grid, words);
    free(words);
}

static void update_grid(struct step_bench *bench, uint64_t number) {
    struct vw_push_update push = {.count = bench->model.windows[0].pair_count, .step_low = (uint32_t)number};
    assert_int_equal(bench->model.window_count, 1);
    step_bench_dispatch(bench, bench->step.update_grid[0], &push, sizeof push, push.count);
}

// A third of the pairs silent, the others of many sizes; some with one silent feature.
static void random_quanta(const struct step_bench *bench, struct test_random *random, int64_t *quanta) {
    for (uint64_t i = 0; i < 2 * (uint64_t)bench->model.pair_count; i++) {
        float drawn = test_random_next(random), size = bench->model.specialization.wide_gradient ? 40.0f : 24.0f;
        quanta[i] = (int64_t)(test_random_next(random) * exp2f(size * fabsf(drawn)));
        if (i / 2 % 3 == 1 || i % 17 == 3) quanta[i] = 0;
    }
}

static void expect_pair(const struct step_bench *bench, const int64_t *quanta, uint64_t number, uint64_t pair, struct grid_state *twin,
                        double moved[2]) {
    const struct vw_specialization *s = &bench->model.specialization;
    bool silent = quanta[2 * pair] == 0 && quanta[2 * pair + 1] == 0;
    moved[0] = moved[1] = 0.0;
    if (silent && s->optimizer != OPTIMIZER_DENSE_ADAM) return;
    uint64_t visits = s->optimizer == OPTIMIZER_DENSE_ADAM ? number : twin->visits[pair] + 1;
    for (int f = 0; f < 2; f++) {
        uint64_t i = 2 * pair + (uint64_t)f;
        double moment1 = twin->moment1 ? twin->moment1[i] : 0.0, moment2 = twin->moment2[i];
        moved[f] = reference_adam(s, (double)quanta[i] * s->gradient_quantum * s->inverse_rays, visits, &moment1, &moment2);
        twin->moment2[i] = (float)moment2;
        if (twin->moment1) twin->moment1[i] = (float)moment1;
    }
    twin->visits[pair] = (uint32_t)visits;
}

static void check_update(struct step_bench *bench, const int64_t *quanta, uint64_t number) {
    const struct vw_specialization *s = &bench->model.specialization;
    struct grid_state before = read_grid(bench);
    write_quanta(bench, quanta);
    update_grid(bench, number);
    struct grid_state after = read_grid(bench);
    for (uint64_t pair = 0; pair < bench->model.pair_count; pair++) {
        double moved[2];
        expect_pair(bench, quanta, number, pair, &before, moved);
        for (uint64_t i = 2 * pair; i < 2 * pair + 2; i++) {
            double expected = before.grid[i] - moved[i % 2];
            bool still = moved[i % 2] == 0.0; // not touched: not a bit may change
            check_value(bench->where, "grid", i, after.grid[i], expected,
                        still ? 0.0 : STEP_TOLERANCE * fabs(moved[i % 2]) + FLOAT_EPSILON * 2.0 * fabs(expected));
            check_value(bench->where, "moment2", i, after.moment2[i], before.moment2[i], MOMENT_TOLERANCE * before.moment2[i]);
            double terms = fabs(before.moment1 ? before.moment1[i] : 0.0) + fabs((double)quanta[i] * s->gradient_quantum * s->inverse_rays);
            if (after.moment1) check_value(bench->where, "moment1", i, after.moment1[i], before.moment1[i], MOMENT_TOLERANCE * terms);
        }
        check_value(bench->where, "visits", pair, after.visits[pair], before.visits[pair], 0.0);
    }
    free_grid(&before);
    free_grid(&after);
}

static void check_cleared(struct step_bench *bench) {
    uint64_t *words = step_bench_read(bench, bench->step.d_grid);
    for (uint64_t i = 0; i < vw_buffer_size_bytes(bench->step.d_grid) / 8; i++)
        if (words[i]) fail_msg("%s: gradient word %llu was not cleared", bench->where, (unsigned long long)i);
    free(words);
}

static void update_grid_matches_the_twin(void **state) {
    (void)state;
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        struct step_bench *bench = step_bench_open(&cases[i]);
        int64_t *quanta = vw_allocate(2 * (size_t)bench->model.pair_count, sizeof *quanta);
        struct test_random random = {.seed = cases[i].seed};
        for (uint64_t number = 1; number <= 6; number++) {
            random_quanta(bench, &random, quanta);
            check_update(bench, quanta, number);
            check_cleared(bench);
        }
        free(quanta);
        step_bench_close(bench);
    }
}

static void check_weights(struct step_bench *bench, const float *d_weights, uint64_t number) {
    const struct vw_specialization *s = &bench->model.specialization;
    uint32_t count = 4 * bench->model.weight_columns, offset = (uint32_t)(bench->model.weights.offset_bytes / 4);
    struct vw_push_update push = {.count = bench->model.weight_columns, .step_low = (uint32_t)number};
    float *before = step_bench_read(bench, bench->field.params), *moments_before = step_bench_read(bench, bench->step.weight_moments);
    step_bench_write(bench, bench->step.d_weights, d_weights);
    step_bench_dispatch(bench, bench->step.update_weights, &push, sizeof push, push.count);
    float *after = step_bench_read(bench, bench->field.params), *moments = step_bench_read(bench, bench->step.weight_moments);
    for (uint32_t i = 0; i < count; i++) {
        double moment1 = moments_before[i], moment2 = moments_before[count + i];
        double moved = reference_adam(s, (double)d_weights[i] * s->inverse_rays, number, &moment1, &moment2);
        double expected = before[offset + i] - moved;
        check_value(bench->where, "weights", i, after[offset + i], expected,
                    STEP_TOLERANCE * fabs(moved) + 2.0 * FLOAT_EPSILON * fabs(expected));
        double terms = fabs(moments_before[i]) + fabs((double)d_weights[i] * s->inverse_rays);
        if (s->momentum) check_value(bench->where, "weight moment1", i, moments[i], moment1, MOMENT_TOLERANCE * terms);
        if (s->optimizer != OPTIMIZER_SGD)
            check_value(bench->where, "weight moment2", i, moments[count + i], moment2, MOMENT_TOLERANCE * moment2);
    }
    check_same_bits(bench->where, "grid", after, before, bench->model.grid.size_bytes);
    free(before);
    free(after);
    free(moments);
    free(moments_before);
}

static void update_weights_matches_the_twin(void **state) {
    (void)state;
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        struct step_bench *bench = step_bench_open(&cases[i]);
        uint32_t count = 4 * bench->model.weight_columns;
        float *d_weights = vw_allocate(count, sizeof *d_weights);
        struct test_random random = {.seed = cases[i].seed};
        for (uint64_t number = 1; number <= 6; number++) {
            for (uint32_t j = 0; j < count; j++)
                d_weights[j] = j % 7 == 3 ? 0.0f : test_random_next(&random) * exp2f(8.0f * test_random_next(&random));
            check_weights(bench, d_weights, number);
        }
        check_weights(bench, d_weights, 100000); // long after
        free(d_weights);
        step_bench_close(bench);
    }
}

// ---- Decision 4 ----------------------------------------------------------------------------------------------------------

enum { SILENT_STEPS = 10000, USUAL_QUANTA = 100000 };

static float entry(struct step_bench *bench, uint64_t feature) {
    struct grid_state now = read_grid(bench);
    float value = now.grid[feature];
    free_grid(&now);
    return value;
}

static void stay_silent(struct step_bench *bench, uint32_t first_step) {
    for (uint32_t step = 0; step < SILENT_STEPS;) {
        vw_batch_begin(bench->batch);
        for (uint32_t i = 0; i < 500; i++, step++) {
            struct vw_push_update push = {.count = bench->model.pair_count, .step_low = first_step + step};
            vw_batch_dispatch(bench->batch, bench->step.update_grid[0], &push, sizeof push, push.count);
        }
        assert_int_equal(vw_batch_submit(bench->batch), VW_OK);
        assert_int_equal(vw_batch_wait(bench->batch), VW_OK);
    }
}

// Feature 0 speaks for 20 steps, is silent for 10,000, and speaks again; feature 8 speaks then for the first time.
static void a_long_silence_does_not_lengthen_the_next_step(void **state) {
    (void)state;
    static const struct step_case lazy = {.name = "a long silence", .seed = 71, .levels = 2, .log2_table = 6, .width = 16};
    struct step_bench *bench = step_bench_open(&lazy);
    double rate = bench->model.specialization.learning_rate;
    int64_t *quanta = vw_allocate(2 * (size_t)bench->model.pair_count, sizeof *quanta);
    quanta[0] = USUAL_QUANTA;
    for (uint64_t number = 1; number <= 20; number++) {
        write_quanta(bench, quanta);
        update_grid(bench, number);
    }
    struct grid_state before = read_grid(bench);
    stay_silent(bench, 21);
    struct grid_state after = read_grid(bench);
    check_same_bits(bench->where, "params of silent entries", after.grid, before.grid, bench->model.param_bytes);
    check_same_bits(bench->where, "moment2 of silent entries", after.moment2, before.moment2, 8 * (size_t)bench->model.pair_count);
    check_same_bits(bench->where, "visits of silent entries", after.visits, before.visits, 4 * (size_t)bench->model.pair_count);

    quanta[8] = -USUAL_QUANTA;
    write_quanta(bench, quanta);
    update_grid(bench, 21 + SILENT_STEPS);
    double again = before.grid[0] - (double)entry(bench, 0), first = (double)entry(bench, 8) - before.grid[8];
    assert_true(again > 0.9 * rate && again <= 1.1 * rate);
    check_value(bench->where, "first step", 8, first / rate, 1.0,
                2.0 / USUAL_QUANTA + 1e-4); // epsilon is one quantum; params round to 1e-7
    free_grid(&before);
    free_grid(&after);
    free(quanta);
    step_bench_close(bench);
}

static void a_step_flagged_nonfinite_only_clears_the_gradient(void **state) {
    (void)state;
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        struct step_bench *bench = step_bench_open(&cases[i]);
        int64_t *quanta = vw_allocate(2 * (size_t)bench->model.pair_count, sizeof *quanta);
        float *d_weights = vw_allocate(4 * (size_t)bench->model.weight_columns, sizeof *d_weights);
        struct test_random random = {.seed = cases[i].seed};
        random_quanta(bench, &random, quanta);
        for (uint32_t j = 0; j < 4 * bench->model.weight_columns; j++) d_weights[j] = test_random_next(&random);
        check_update(bench, quanta, 1); // so that the moments are not all 0
        check_weights(bench, d_weights, 1);
        write_quanta(bench, quanta);
        step_bench_write(bench, bench->field.step_state, &(struct vw_step_state){.nonfinite = 1});
        struct grid_state before = read_grid(bench);
        float *moments_before = step_bench_read(bench, bench->step.weight_moments);
        update_grid(bench, 2);
        struct vw_push_update push = {.count = bench->model.weight_columns, .step_low = 2};
        step_bench_dispatch(bench, bench->step.update_weights, &push, sizeof push, push.count);
        struct grid_state after = read_grid(bench);
        float *moments = step_bench_read(bench, bench->step.weight_moments);
        size_t pairs = bench->model.pair_count;
        check_same_bits(bench->where, "params", after.grid, before.grid, bench->model.param_bytes);
        check_same_bits(bench->where, "moment2", after.moment2, before.moment2, 8 * pairs);
        if (after.moment1) check_same_bits(bench->where, "moment1", after.moment1, before.moment1, 8 * pairs);
        check_same_bits(bench->where, "visits", after.visits, before.visits, 4 * pairs);
        check_same_bits(bench->where, "weight moments", moments, moments_before, vw_buffer_size_bytes(bench->step.weight_moments));
        check_cleared(bench);
        free_grid(&before);
        free_grid(&after);
        free(moments);
        free(moments_before);
        free(d_weights);
        free(quanta);
        step_bench_close(bench);
    }
}

static void check_finite(struct step_bench *bench) {
    float *params = step_bench_read(bench, bench->field.params);
    for (uint64_t i = 0; i < bench->model.param_bytes / 4; i++)
        if (!isfinite(params[i])) fail_msg("%s: parameter %llu is %g", bench->where, (unsigned long long)i, params[i]);
    assert_true(memcmp(params, bench->params, bench->model.param_bytes) != 0);
    free(params);
}

static struct step_bench *open_wild(double learning_rate, enum vw_optimizer optimizer) {
    struct step_case wild = {.name = "wild learning rate", .seed = 80, .levels = 2, .log2_table = 6, .width = 16, .loss = VW_LOSS_L2};
    wild.learning_rate = learning_rate;
    wild.optimizer = optimizer;
    return step_bench_open(&wild);
}

static const enum vw_optimizer optimizers[] = {VW_OPTIMIZER_LAZY_ADAM, VW_OPTIMIZER_DENSE_ADAM, VW_OPTIMIZER_SGD};

static void params_stay_finite_at_a_learning_rate_of_1e30(void **state) {
    (void)state;
    for (int i = 0; i < 3; i++) {
        struct step_bench *bench = open_wild(1e30, optimizers[i]);
        for (uint64_t number = 1; number <= 5; number++) step_bench_step(bench, number);
        check_finite(bench);
        step_bench_close(bench);
    }
}

// The same gradient three times at a learning rate near the largest float: the second step would already leave the floats.
static void a_step_beyond_the_floats_is_not_taken(void **state) {
    (void)state;
    for (int i = 0; i < 3; i++) {
        struct step_bench *bench = open_wild(3e38, optimizers[i]);
        int64_t *quanta = vw_allocate(2 * (size_t)bench->model.pair_count, sizeof *quanta);
        float *d_weights = vw_allocate(4 * (size_t)bench->model.weight_columns, sizeof *d_weights);
        float size = 0.9f / bench->model.specialization.inverse_rays; // a mean gradient of 0.9
        for (uint64_t k = 0; k < 2 * (uint64_t)bench->model.pair_count; k++)
            quanta[k] = llrintf(size / bench->model.specialization.gradient_quantum);
        for (uint64_t k = 0; k < 4 * (uint64_t)bench->model.weight_columns; k++) d_weights[k] = k % 2 ? size : -size;
        for (uint32_t number = 1; number <= 3; number++) {
            struct vw_push_update push = {.count = bench->model.weight_columns, .step_low = number, .scalar_row = 1}; // the grid's is 0
            write_quanta(bench, quanta);
            update_grid(bench, number);
            step_bench_write(bench, bench->step.d_weights, d_weights);
            step_bench_dispatch(bench, bench->step.update_weights, &push, sizeof push, push.count);
        }
        check_finite(bench);
        vw_float4 *rows = step_bench_read(bench, bench->scalars);
        assert_true(rows[0].z == 1.0f && rows[1].z == 1.0f); // and the row says so
        free(rows);
        free(quanta);
        free(d_weights);
        step_bench_close(bench);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(update_grid_matches_the_twin),
        cmocka_unit_test(update_weights_matches_the_twin),
        cmocka_unit_test(a_long_silence_does_not_lengthen_the_next_step),
        cmocka_unit_test(a_step_flagged_nonfinite_only_clears_the_gradient),
        cmocka_unit_test(params_stay_finite_at_a_learning_rate_of_1e30),
        cmocka_unit_test(a_step_beyond_the_floats_is_not_taken),
    };
    return cmocka_run_group_tests_name("optimizer", tests, NULL, step_bench_teardown);
}
