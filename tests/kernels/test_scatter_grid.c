// scatter_grid against the twin, and decision 3: sums of fixed-point gradients are exact, never wrap, and what is clamped is counted.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "reference/reference.h"
#include "reference/step_bench.h"
#include "support/gpu_fixture.h"
#include "viewworth/memory.h"

// A contribution is rounded to a whole quantum, and its weight (three float factors) and product carry four float roundings.
static const double ROUNDING_QUANTA = 0.5;
static const double RELATIVE_ROUNDING = 4.0 * 0x1p-24;

static const struct step_case cases[] = {
    {.name = "pairs in narrow words", .seed = 41},
    {.name = "four features, small table, narrow", .seed = 42, .features = 4, .log2_table = 8},
    {.name = "pairs in wide words", .seed = 43, .levels = 16, .wide = true},
    {.name = "four features, dense levels, wide", .seed = 44, .features = 4, .levels = 2, .base_resolution = 4, .wide = true},
    {.name = "one entry per level", .seed = 45, .one_entry = true, .levels = 4},
};

// Positions everywhere, on faces and lattice planes; gradients of many sizes, a few beyond the clamp.
static float *random_rows(const struct step_bench *bench) {
    static const float special[] = {0.0f, 1.0f, 0.5f, 0.25f, 0x1p-24f, 1.0f - 0x1p-24f};
    size_t chunk = bench->model.specialization.chunk_samples, encoding = bench->config.levels * bench->config.features;
    struct step_rows row = step_bench_rows(bench);
    struct test_random random = {.seed = bench->config.seed};
    float *rows = vw_allocate(4 * chunk * bench->model.row_count, sizeof *rows);
    for (uint32_t i = 0; i < chunk; i++) {
        float *position = (float *)step_bench_row(bench, rows, row.position, i);
        for (int axis = 0; axis < 3; axis++) {
            float drawn = test_random_next(&random);
            position[axis] =
                drawn > 0.8f ? special[(uint32_t)(drawn * 1e6f) % VW_ARRAY_COUNT(special)] : 0.5f + 0.5f * test_random_next(&random);
        }
        for (uint32_t j = 0; j < encoding; j++) {
            float *value = (float *)step_bench_row(bench, rows, row.d_encoding + j / 4, i) + j % 4;
            *value = test_random_next(&random) * exp2f(12.0f * test_random_next(&random) - 6.0f);
            if (i % 97 == 5 && j % 3 == 0) *value *= 1e6f;
        }
    }
    return rows;
}

static void scatter(struct step_bench *bench, const float *rows, struct vw_step_state *state) {
    uint32_t samples = bench->padded_samples;
    *state = (struct vw_step_state){0};
    step_bench_write(bench, bench->field.rows, rows);
    step_bench_write(bench, bench->field.step_state, state);
    for (uint32_t i = 0; i < bench->model.window_count; i++) {
        const struct grid_window *window = &bench->model.windows[i];
        struct vw_push_scatter push = {.sample_count = samples,
                                       .first_level = window->first_level,
                                       .level_count = window->level_count,
                                       .first_pair = window->first_pair};
        step_bench_dispatch(bench, bench->step.scatter[i], &push, sizeof push, (uint64_t)samples * window->level_count);
    }
    struct vw_step_state *after = step_bench_read(bench, bench->field.step_state);
    *state = *after;
    free(after);
}

struct expected {
    double *quanta, *magnitudes, *contributions; // per feature: sum, sum of sizes, how many
    uint64_t clamped;
};

static void expect_sample(const struct step_bench *bench, const float *rows, uint32_t index, struct expected *expected) {
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
            for (uint32_t f = 0; f < bench->config.features; f++) expected->contributions[corners[i].first_feature + f] += 1.0;
    }
}

static void check_sums(const struct step_bench *bench, const float *rows, const uint64_t *words, uint32_t clamped) {
    uint64_t features = 2 * (uint64_t)bench->model.pair_count;
    struct expected expected = {vw_allocate(features, sizeof(double)), vw_allocate(features, sizeof(double)),
                                vw_allocate(features, sizeof(double)), 0};
    int64_t *quanta = vw_allocate(features, sizeof *quanta);
    for (uint32_t i = 0; i < bench->padded_samples; i++) expect_sample(bench, rows, i, &expected);
    reference_unpack_grid(&bench->model, words, quanta);
    for (uint64_t i = 0; i < features; i++)
        check_value(bench->where, "d_grid", i, (double)quanta[i], expected.quanta[i],
                    ROUNDING_QUANTA * expected.contributions[i] + RELATIVE_ROUNDING * expected.magnitudes[i]);
    assert_true(expected.clamped > 0);
    assert_int_equal(clamped, expected.clamped);
    free(expected.quanta);
    free(expected.magnitudes);
    free(expected.contributions);
    free(quanta);
}

static void scatter_matches_the_twin(void **state) {
    (void)state;
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        struct step_bench *bench = step_bench_open(&cases[i]);
        float *rows = random_rows(bench);
        struct vw_step_state flags;
        scatter(bench, rows, &flags);
        uint64_t *words = step_bench_read(bench, bench->step.d_grid);
        assert_int_equal(flags.nonfinite, 0);
        check_sums(bench, rows, words, flags.clamped);
        free(words);
        free(rows);
        step_bench_close(bench);
    }
}

// It marks the step by itself, whatever other passes find, and adds nothing: the sums are those of the gradient without it.
static void a_gradient_that_is_not_finite_marks_the_step(void **state) {
    (void)state;
    static const float poison[] = {NAN, INFINITY, -INFINITY};
    for (size_t i = 0; i < VW_ARRAY_COUNT(poison); i++) {
        struct step_bench *bench = step_bench_open(&cases[i]);
        float *rows = random_rows(bench), *gradient = (float *)step_bench_row(bench, rows, step_bench_rows(bench).d_encoding, 9) + i;
        struct vw_step_state flags;
        *gradient = poison[i];
        scatter(bench, rows, &flags);
        uint64_t *words = step_bench_read(bench, bench->step.d_grid);
        assert_true(flags.nonfinite != 0);
        *gradient = 0.0f;
        check_sums(bench, rows, words, flags.clamped);
        free(words);
        free(rows);
        step_bench_close(bench);
    }
}

// Two 32-bit atomics with a carry instead of one of 64 bits.
static void split_atomics_give_the_same_bits(void **state) {
    (void)state;
    struct vw_gpu_limits clamp = *vw_gpu_get_limits(test_gpu());
    clamp.int64_atomics = false;
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        struct step_bench *whole = step_bench_open(&cases[i]), *split = step_bench_open_clamped(&cases[i], &clamp);
        assert_true(vw_gpu_get_limits(whole->gpu)->int64_atomics);
        assert_false(vw_gpu_get_limits(split->gpu)->int64_atomics);
        float *rows = random_rows(whole);
        struct vw_step_state whole_flags, split_flags;
        scatter(whole, rows, &whole_flags);
        scatter(split, rows, &split_flags);
        uint64_t *whole_words = step_bench_read(whole, whole->step.d_grid), *split_words = step_bench_read(split, split->step.d_grid);
        check_same_bits(whole->where, "d_grid with split atomics", split_words, whole_words, vw_buffer_size_bytes(whole->step.d_grid));
        assert_int_equal(split_flags.clamped, whole_flags.clamped);
        free(rows);
        free(whole_words);
        free(split_words);
        step_bench_close(split);
        step_bench_close(whole);
    }
}

// ---- Decision 3 ----------------------------------------------------------------------------------------------------------

// As many samples as narrow words take, in the number that leaves the least room above the sum.
static const struct step_case crowds[] = {
    {.name = "narrow crowd", .seed = 51, .rays = 1024, .samples = 30, .levels = 2, .one_entry = true, .width = 16, .base_resolution = 8},
    {.name = "wide crowd", .seed = 52, .rays = 2048, .samples = 30, .levels = 2, .one_entry = true, .width = 16, .base_resolution = 8},
};

// Every sample in the one entry of its level, with the largest gradient there is: +, -, and beyond the clamp. The samples sit at cell
// centres of both levels' lattices or at lattice points, so that the weights are powers of two and the sum is known to the last bit.
static void crowd_sums_exactly(const struct step_case *crowd, bool wide, float sign) {
    struct step_bench *bench = step_bench_open(crowd);
    const struct vw_specialization *s = &bench->model.specialization;
    assert_int_equal(s->wide_gradient, wide);
    size_t chunk = s->chunk_samples;
    struct step_rows row = step_bench_rows(bench);
    float *rows = vw_allocate(4 * chunk * bench->model.row_count, sizeof *rows);
    for (uint32_t i = 0; i < chunk; i++) {
        float *position = (float *)step_bench_row(bench, rows, row.position, i),
              *d = (float *)step_bench_row(bench, rows, row.d_encoding, i);
        for (int axis = 0; axis < 3; axis++) position[axis] = i % 2 ? 1.0f : 0.0625f; // the last corner; a cell centre of level 0
        for (int j = 0; j < 4; j++) d[j] = sign * (j % 2 ? -1.0f : 1.0f) * (i % 3 ? s->gradient_clamp : 1e30f);
    }
    struct vw_step_state flags;
    scatter(bench, rows, &flags);
    assert_int_equal(flags.nonfinite, 0);
    assert_int_equal(flags.clamped, 4 * ((chunk + 2) / 3));
    uint64_t *words = step_bench_read(bench, bench->step.d_grid);
    int64_t *quanta = vw_allocate(2 * (size_t)bench->model.pair_count, sizeof *quanta);
    reference_unpack_grid(&bench->model, words, quanta);
    int64_t sum = (int64_t)llround(sign * (double)chunk * s->gradient_clamp / s->gradient_quantum);
    assert_true(llabs(sum) < (wide ? INT64_C(1) << 62 : INT32_MAX));
    for (int f = 0; f < 2; f++) // level 0, where all weights are powers of two
        if (quanta[f] != (f ? -sum : sum))
            fail_msg("%s: feature %d sums to %lld, not %lld", bench->where, f, (long long)quanta[f], (long long)(f ? -sum : sum));
    for (int f = 0; f < 2; f++) // level 1: each of eight corners is rounded
        check_value(bench->where, "level 1", f, (double)quanta[2 * s->first_pair[1] + f], f ? -(double)sum : (double)sum,
                    4.0 * (double)chunk + 8.0 * RELATIVE_ROUNDING * fabs((double)sum));
    free(quanta);
    free(words);
    free(rows);
    step_bench_close(bench);
}

static void all_samples_in_one_entry_at_the_clamp_sum_exactly(void **state) {
    (void)state;
    for (int i = 0; i < 2; i++) {
        crowd_sums_exactly(&crowds[i], i == 1, 1.0f);
        crowd_sums_exactly(&crowds[i], i == 1, -1.0f);
    }
}

// The bound itself, for every step size: samples x (largest contribution + 4 for the rounding of eight corners) stays within the bits.
static void no_step_size_can_wrap(void **state) {
    (void)state;
    static const uint32_t sample_counts[] = {1, 7, 30, 31, 32, 48, 127, 4096};
    struct vw_config config = vw_config_default;
    struct vw_effect_verdict none[VW_EFFECT_COUNT_MAX] = {0};
    struct vw_scene scene = {0};
    for (size_t i = 0; i < VW_ARRAY_COUNT(sample_counts); i++) {
        for (config.rays = 1; config.rays <= 65536; config.rays += 1 + config.rays / 7) {
            struct model model;
            config.samples = sample_counts[i];
            if (vw_config_check(&config) != VW_OK) continue;
            assert_int_equal(model_create(&config, &scene, none, &(struct vw_gpu_info){.kind = VW_GPU_CPU}, &vw_gpu_floor_limits, &model),
                             VW_OK);
            const struct vw_specialization *s = &model.specialization;
            double samples = (double)model_pad_rays(&model, config.rays) * config.samples,
                   most = s->gradient_clamp / (double)s->gradient_quantum;
            if (!(samples * (most * (1.0 + 8.0 * RELATIVE_ROUNDING) + 4.0) < (s->wide_gradient ? 0x1p63 : 0x1p31)))
                fail_msg("%u rays of %u samples may wrap", config.rays, config.samples);
            assert_true(most >= 0x1p15); // and 16 bits are left
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(scatter_matches_the_twin),
        cmocka_unit_test(a_gradient_that_is_not_finite_marks_the_step),
        cmocka_unit_test(split_atomics_give_the_same_bits),
        cmocka_unit_test(all_samples_in_one_entry_at_the_clamp_sum_exactly),
        cmocka_unit_test(no_step_size_can_wrap),
    };
    return cmocka_run_group_tests_name("scatter_grid", tests, NULL, step_bench_teardown);
}
