// scatter_grid against the reference: sums of fixed-point gradients, and what is clamped is counted.
#include "support/cmocka_test.h"
#include "train/fields/registry.h"

#include "base/memory.h"
#include "gpu/compute.h"
#include "kernels/checks/check.h"

// A contribution is rounded to a whole quantum, and its weight (three float factors) and product carry four float
// roundings.
static const double ROUNDING_QUANTA = 0.5;
static const double RELATIVE_ROUNDING = 4.0 * 0x1p-24;

// Draws a gradient as training has them, of many sizes, a few beyond the clamp; or of the kind.
static float draw_gradient(enum input_kind kind, struct test_random *random, uint32_t sample, uint32_t part) {
    if (kind != INPUT_ORDINARY) return input_draw(kind, random);
    float value = test_random_next(random) * exp2f(12.0f * test_random_next(random) - 6.0f);
    return sample % 97 == 5 && part % 3 == 0 ? 1e6f * value : value;
}

// Positions everywhere, on faces and lattice planes.
float *scatter_rows(const struct step_bench *bench, enum input_kind kind) {
    static const float special[] = {0.0f, 1.0f, 0.5f, 0.25f, 0x1p-24f, 1.0f - 0x1p-24f};
    size_t chunk = bench->model.specialization.chunk_samples, encoding = bench->config.levels * bench->config.features;
    struct step_rows row = step_bench_rows(bench);
    struct test_random random = {.seed = bench->config.seed};
    size_t count;
    float *rows = step_bench_new_rows(bench, &count);
    for (uint32_t i = 0; i < chunk; i++) {
        float *position = step_bench_row(bench, rows, row.position, i);
        position[3] = 1.0f; // the ray's weight
        for (int axis = 0; axis < 3; axis++) {
            float drawn = test_random_next(&random);
            position[axis] = drawn > 0.8f ? special[(uint32_t)(drawn * 1e6f) % VW_ARRAY_COUNT(special)]
                                          : 0.5f + 0.5f * test_random_next(&random);
        }
        for (uint32_t j = 0; j < encoding; j++) {
            float *value = step_bench_row(bench, rows, row.d_encoding + j / 4, i) + j % 4;
            *value = draw_gradient(kind, &random, i, j);
        }
    }
    return rows;
}

static void clear_gradient(struct step_bench *bench) {
    void *zeros = test_allocate(vw_buffer_size_bytes(bench->volume->d_grid), 1);
    test_write(bench->volume->d_grid, zeros);
}

void scatter_run(struct step_bench *bench, float *rows, struct vw_step_state *flags) {
    uint32_t samples = bench->padded_samples;
    clear_gradient(bench);
    step_bench_write_rows(bench, rows);
    test_write(bench->field.step_state, &(struct vw_step_state){0});
    vw_submission_begin(bench->submission);
    vw_hash_record_scatter(&bench->model, &bench->volume->gradient.field, bench->submission, samples);
    test_submit(bench->submission);
    struct vw_step_state *after = test_read(bench->field.step_state);
    *flags = *after;
}

struct expected {
    double *quanta, *magnitudes, *contributions; // per feature: sum, sum of sizes, how many
    uint64_t clamped;
};

static void expect_sample(const struct step_bench *bench, const float *rows, uint32_t index,
                          struct expected *expected) {
    const struct vw_specialization *s = &bench->model.specialization;
    struct step_rows row = step_bench_rows(bench);
    const float *at = step_bench_row(bench, rows, row.position, index);
    double quanta[REFERENCE_ENCODING_MAX], sizes[REFERENCE_ENCODING_MAX], clamp = s->gradient_clamp;
    uint32_t encoding = bench->config.levels * bench->config.features;
    for (uint32_t j = 0; j < encoding; j++) {
        double gradient = step_bench_row(bench, rows, row.d_encoding + j / 4, index)[j % 4];
        expected->clamped += fabs(gradient) > clamp;
        quanta[j] = fmin(fmax(gradient, -clamp), clamp) / s->gradient_quantum;
        sizes[j] = fabs(quanta[j]);
    }
    const double position[3] = {at[0], at[1], at[2]};
    reference_grid_scatter(s, position, quanta, expected->quanta);
    reference_grid_scatter(s, position, sizes, expected->magnitudes);
    for (uint32_t level = 0; level < s->levels; level++) {
        struct reference_corner corners[8];
        reference_grid_corners(s, position, level, corners);
        for (int i = 0; i < 8; i++)
            for (uint32_t f = 0; f < bench->config.features; f++)
                expected->contributions[corners[i].first_feature + f] += 1.0;
    }
}

void scatter_check(const struct step_bench *bench, const float *rows, const uint64_t *words, uint32_t clamped) {
    uint64_t features = 2 * (uint64_t)bench->layout->pair_count;
    struct expected expected = {test_allocate(features, sizeof(double)), test_allocate(features, sizeof(double)),
                                test_allocate(features, sizeof(double)), 0};
    int64_t *quanta = test_allocate(features, sizeof *quanta);
    for (uint32_t i = 0; i < bench->padded_samples; i++) expect_sample(bench, rows, i, &expected);
    reference_unpack_grid(&bench->model, words, quanta);
    for (uint64_t i = 0; i < features; i++)
        check_value(bench->where, "d_grid", i, (double)quanta[i], expected.quanta[i],
                    ROUNDING_QUANTA * expected.contributions[i] + RELATIVE_ROUNDING * expected.magnitudes[i]);
    assert_int_equal(clamped, expected.clamped);
}

void check_scatter_grid(struct step_bench *bench, enum input_kind kind) {
    float *rows = scatter_rows(bench, kind);
    struct vw_step_state flags;
    scatter_run(bench, rows, &flags);
    uint64_t *words = test_read(bench->volume->d_grid);
    assert_int_equal(flags.nonfinite, 0);
    scatter_check(bench, rows, words, flags.clamped);
    if (kind == INPUT_ORDINARY || kind == INPUT_SATURATING) assert_true(flags.clamped > 0);
    clear_gradient(bench); // other passes find it as update_grid leaves it
}
