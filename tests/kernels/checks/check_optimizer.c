// update_grid and update_weights against the reference, on hand-made gradients and moments.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "gpu/compute.h"
#include "kernels/checks/check.h"

// Tolerance relative to a step's length: the device's exp2 and log2 in the bias correction may be off by 2^-21
// (Vulkan's bound), and 1 - beta^n magnifies that at the first visits by 1 / (1 - beta).
static const double STEP_TOLERANCE = 5e-4;
static const double MOMENT_TOLERANCE = 1e-6; // relative to the terms: 1 - beta in float, and a few roundings
enum { UPDATES = 4 };

// ---- The grid's state -----------------------------------------------------------------------------------------------

struct grid_state grid_read(struct step_bench *bench) {
    bool momentum = bench->model.specialization.momentum;
    return (struct grid_state){test_read(bench->field.params), momentum ? test_read(bench->volume->grid_moment1) : NULL,
                               test_read(bench->volume->grid_moment2), test_read(bench->volume->grid_visits)};
}

static uint64_t pack_pair(int64_t first, int64_t second) { return (uint64_t)first + ((uint64_t)second << 32); }

void grid_write_gradient(struct step_bench *bench, const int64_t *quanta) {
    uint64_t pairs = bench->layout->pair_count;
    uint64_t *words = test_allocate(2 * pairs, sizeof *words);
    for (uint64_t i = 0; i < 2 * pairs; i++) {
        if (bench->model.specialization.wide_gradient) words[i] = (uint64_t)quanta[i];
        else words[i / 2] = pack_pair(quanta[i / 2 * 2], quanta[i / 2 * 2 + 1]);
    }
    test_write(bench->volume->d_grid, words);
}

void grid_update(struct step_bench *bench, uint32_t number) {
    struct vw_push_update push = {.count = bench->layout->windows[0].pair_count,
                                  .step_low = number,
                                  .adam = vw_adam_of(&bench->model.specialization)};
    assert_int_equal(bench->layout->window_count, 1);
    step_bench_dispatch(bench, bench->volume->update_grid[0], &push, sizeof push, push.count);
}

static int64_t draw_quanta(enum input_kind kind, struct test_random *random, bool wide) {
    int64_t most = wide ? INT64_C(1) << 62 : INT32_MAX;
    float drawn = test_random_next(random), octaves = (wide ? 40.0f : 24.0f) * fabsf(test_random_next(random));
    switch (kind) {
    case INPUT_LARGE: return (int64_t)(drawn * (float)(most / 2));
    case INPUT_TINY: return lrintf(1.4f * drawn); // one quantum or none
    case INPUT_ZERO:
    case INPUT_NEGATIVE_ZERO: return 0;
    case INPUT_SATURATING: return drawn < 0.0f ? -most : most;
    default: return (int64_t)(drawn * exp2f(octaves));
    }
}

// Draws a gradient with a third of the pairs silent and some others with one silent feature.
static void grid_random_gradient(const struct step_bench *bench, enum input_kind kind, struct test_random *random,
                                 int64_t *quanta) {
    for (uint64_t i = 0; i < 2 * (uint64_t)bench->layout->pair_count; i++) {
        quanta[i] = draw_quanta(kind, random, bench->model.specialization.wide_gradient);
        if (i / 2 % 3 == 1 || i % 17 == 3) quanta[i] = 0;
    }
}

// Returns the tolerance of a step's length: the bias correction, and what moments and gradients flushed to 0 would have
// moved.
static double step_error(const struct vw_specialization *s, double moved) {
    double epsilon = (double)s->gradient_quantum * s->inverse_rays;
    return STEP_TOLERANCE * fabs(moved) + 4.0 * s->learning_rate * FLOAT_LEAST / ((1.0 - s->beta1) * epsilon);
}

// ---- update_grid ----------------------------------------------------------------------------------------------------

static void expect_pair(const struct step_bench *bench, const int64_t *quanta, uint32_t number, uint64_t pair,
                        struct grid_state *reference, double moved[2]) {
    const struct vw_specialization *s = &bench->model.specialization;
    bool silent = quanta[2 * pair] == 0 && quanta[2 * pair + 1] == 0;
    moved[0] = moved[1] = 0.0;
    if (silent && s->optimizer != OPTIMIZER_DENSE_ADAM) return;
    uint32_t visits = s->optimizer == OPTIMIZER_DENSE_ADAM            ? number
                      : reference->visits[pair] < (uint32_t)INT32_MAX ? reference->visits[pair] + 1
                                                                      : INT32_MAX; // saturated
    double moment1[2] = {0.0, 0.0}, moment2[2];
    for (int f = 0; f < 2; f++) {
        uint64_t i = 2 * pair + (uint64_t)f;
        if (reference->moment1) moment1[f] = reference->moment1[i];
        moment2[f] = reference->moment2[i];
        moved[f] = reference_adam(s, (double)quanta[i] * s->gradient_quantum * s->inverse_rays, visits, &moment1[f],
                                  &moment2[f]);
    }
    for (int f = 0; f < 2; f++) {
        reference->moment2[2 * pair + (uint64_t)f] = (float)moment2[f];
        if (reference->moment1) reference->moment1[2 * pair + (uint64_t)f] = (float)moment1[f];
    }
    reference->visits[pair] = visits;
}

// Checks a feature after a step. One that is not touched may not change by a bit.
static void check_feature(const struct step_bench *bench, uint64_t index, double before, double moved, double after) {
    double value = before - moved,
           error = step_error(&bench->model.specialization, moved) + FLOAT_ROUNDING * 2.0 * fabs(value);
    if (moved == 0.0) check_value(bench->where, "grid", index, after, before, 0.0);
    else check_value(bench->where, "grid", index, after, value, error);
}

static void check_pair(const struct step_bench *bench, const int64_t *quanta, uint64_t pair,
                       const struct grid_state *before, const struct grid_state *expected, const double moved[2],
                       const struct grid_state *after) {
    const struct vw_specialization *s = &bench->model.specialization;
    for (uint64_t i = 2 * pair; i < 2 * pair + 2; i++) {
        check_feature(bench, i, before->grid[i], moved[i % 2], after->grid[i]);
        check_value(bench->where, "moment2", i, after->moment2[i], expected->moment2[i],
                    MOMENT_TOLERANCE * expected->moment2[i] + 2.0 * FLOAT_LEAST);
        double terms = fabs(before->moment1 ? before->moment1[i] : 0.0) +
                       fabs((double)quanta[i] * s->gradient_quantum * s->inverse_rays);
        if (after->moment1)
            check_value(bench->where, "moment1", i, after->moment1[i], expected->moment1[i],
                        MOMENT_TOLERANCE * terms + 2.0 * FLOAT_LEAST);
    }
    check_value(bench->where, "visits", pair, after->visits[pair], expected->visits[pair], 0.0);
}

static void grid_check_update(struct step_bench *bench, const int64_t *quanta, uint32_t number) {
    uint64_t features = 2 * (uint64_t)bench->layout->pair_count;
    struct grid_state before = grid_read(bench), expected = grid_read(bench);
    grid_write_gradient(bench, quanta);
    grid_update(bench, number);
    struct grid_state after = grid_read(bench);
    for (uint64_t pair = 0; pair < bench->layout->pair_count; pair++) {
        double moved[2];
        expect_pair(bench, quanta, number, pair, &expected, moved);
        check_pair(bench, quanta, pair, &before, &expected, moved, &after);
    }
    check_same_bits(bench->where, "weights", after.grid + features, before.grid + features,
                    bench->model.param_bytes - bench->layout->grid.size_bytes);
}

static void grid_check_cleared(struct step_bench *bench) {
    uint64_t *words = test_read(bench->volume->d_grid);
    for (uint64_t i = 0; i < vw_buffer_size_bytes(bench->volume->d_grid) / 8; i++)
        if (words[i]) fail_msg("%s: gradient word %llu was not cleared", bench->where, (unsigned long long)i);
}

static void write_drawn(struct vw_buffer *buffer, enum input_kind kind, struct test_random *random, bool positive) {
    size_t count = vw_buffer_size_bytes(buffer) / sizeof(float);
    float *values = test_allocate(count, sizeof *values);
    input_fill(kind, random, values, count);
    for (size_t i = 0; i < count && positive; i++) values[i] = fabsf(values[i]);
    test_write(buffer, values);
}

static void write_visits(struct step_bench *bench, uint32_t visits) {
    uint32_t *values = test_allocate(bench->layout->pair_count, sizeof *values);
    for (uint32_t i = 0; i < bench->layout->pair_count; i++) values[i] = visits;
    test_write(bench->volume->grid_visits, values);
}

// Returns the number of steps before the first: none, some, or nearly 2^31 - 1, where the host's count saturates.
static uint32_t steps_before(enum input_kind kind) {
    return kind == INPUT_SATURATING ? INT32_MAX - UPDATES : kind == INPUT_LARGE ? 1000000 : 0;
}

void check_update_grid(struct step_bench *bench, enum input_kind kind) {
    struct test_random random = {.seed = bench->config.seed};
    int64_t *quanta = test_allocate(2 * (size_t)bench->layout->pair_count, sizeof *quanta);
    enum input_kind moments = kind == INPUT_ORDINARY ? INPUT_ZERO : kind;
    step_bench_write_params(bench);
    test_write(bench->field.step_state, &(struct vw_step_state){0});
    write_drawn(bench->volume->grid_moment1, moments, &random, false);
    write_drawn(bench->volume->grid_moment2, moments, &random, true);
    write_visits(bench, steps_before(kind) +
                            (kind == INPUT_SATURATING) * UPDATES / 2); // and so does the device's, here half-way
    for (uint32_t i = 1; i <= UPDATES; i++) {
        grid_random_gradient(bench, kind, &random, quanta);
        grid_check_update(bench, quanta, steps_before(kind) + i);
        grid_check_cleared(bench);
    }
    step_bench_write_params(bench);
}

// ---- update_weights -------------------------------------------------------------------------------------------------

static void weights_check_update(struct step_bench *bench, const float *d_weights, uint32_t number) {
    const struct vw_specialization *s = &bench->model.specialization;
    uint32_t count = 4 * bench->model.moved_columns, offset = (uint32_t)(bench->model.weights.offset_bytes / 4);
    float *before = test_read(bench->field.params), *moments_before = test_read(bench->step.weight_moments);
    struct vw_push_update push = {
        .count = bench->model.moved_columns, .step_low = number, .adam = vw_adam_of(&bench->model.specialization)};
    test_write(bench->step.d_weights, d_weights);
    step_bench_dispatch(bench, bench->step.update_weights, &push, sizeof push, push.count);
    float *after = test_read(bench->field.params), *moments = test_read(bench->step.weight_moments);
    for (uint32_t i = 0; i < count; i++) {
        double moment1 = moments_before[i], moment2 = moments_before[count + i],
               gradient = (double)d_weights[i] * s->inverse_rays;
        double moved = reference_adam(s, gradient, number, &moment1, &moment2), expected = before[offset + i] - moved;
        check_value(bench->where, "weights", i, after[offset + i], expected,
                    step_error(s, moved) + 2.0 * FLOAT_ROUNDING * fabs(expected));
        double terms = fabs(moments_before[i]) + fabs(gradient);
        if (s->momentum)
            check_value(bench->where, "weight moment1", i, moments[i], moment1,
                        MOMENT_TOLERANCE * terms + 2.0 * FLOAT_LEAST);
        if (s->optimizer != OPTIMIZER_SGD)
            check_value(bench->where, "weight moment2", i, moments[count + i], moment2,
                        MOMENT_TOLERANCE * moment2 + 2.0 * FLOAT_LEAST);
    }
    check_same_bits(bench->where, "grid", after, before, bench->layout->grid.size_bytes);
}

// Writes moments of the kind, of which the second are not below 0. For ordinary inputs all are 0, as before the first
// step.
static void write_weight_moments(struct step_bench *bench, enum input_kind kind, struct test_random *random) {
    size_t count = 4 * (size_t)bench->model.moved_columns;
    float *moments = test_allocate(2 * count, sizeof *moments);
    if (kind != INPUT_ORDINARY) input_fill(kind, random, moments, 2 * count);
    for (size_t i = count; i < 2 * count; i++) moments[i] = fabsf(moments[i]);
    test_write(bench->step.weight_moments, moments);
}

void check_update_weights(struct step_bench *bench, enum input_kind kind) {
    uint32_t count = 4 * bench->model.moved_columns;
    float *d_weights = test_allocate(count, sizeof *d_weights);
    struct test_random random = {.seed = bench->config.seed};
    step_bench_write_params(bench);
    test_write(bench->field.step_state, &(struct vw_step_state){0});
    write_weight_moments(bench, kind, &random);
    for (uint32_t i = 1; i <= UPDATES; i++) {
        for (uint32_t j = 0; j < count; j++) d_weights[j] = j % 7 == 3 ? 0.0f : 16.0f * input_draw(kind, &random);
        weights_check_update(bench, d_weights, steps_before(kind) + i);
    }
    weights_check_update(bench, d_weights, 100000); // long after
    step_bench_write_params(bench);
}
