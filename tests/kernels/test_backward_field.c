// backward_field and the weight gradients against the twin, on random gradients of the samples.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "reference/reference.h"
#include "reference/step_bench.h"

static const double FLOAT_EPSILON = 0x1p-24;
static const double LAYER_ROUNDINGS = 64.0; // of the largest value of a layer: up to 64 terms, layer by layer
// Sums over slices of 128 samples, then over slices: up to 128 + 32 roundings, each of at most the sum of all magnitudes so far.
static const double SUM_ROUNDINGS = 160.0;

static void copy_row(const struct step_bench *bench, const float *rows, uint32_t first_row, uint32_t sample, uint32_t count,
                     double *values) {
    for (uint32_t i = 0; i < count; i++) values[i] = step_bench_row(bench, rows, first_row + i / 4, sample)[i % 4];
}

static void check_row(const struct step_bench *bench, const float *rows, const char *what, uint32_t row, uint32_t sample, uint32_t count,
                      const double *expected, double scale) {
    for (uint32_t i = 0; i < count; i++)
        check_value(bench->where, what, sample, step_bench_row(bench, rows, row + i / 4, sample)[i % 4], expected[i],
                    LAYER_ROUNDINGS * FLOAT_EPSILON * scale);
}

static void take_gates(uint32_t width, uint32_t low, uint32_t high, bool *active) {
    for (uint32_t i = 0; i < width; i++) active[i] = (i < 32 ? low >> i : high >> (i - 32)) & 1;
}

// test_forward_field holds the device's activations and ReLU decisions against the twin; here the twin starts from them.
static void check_sample(const struct step_bench *bench, const struct reference_params *params, const float *rows, const vw_uint4 *relu,
                         const float *rgb_density, const float *d_field, uint32_t index) {
    const struct vw_specialization *s = &bench->model.specialization;
    struct step_rows row = step_bench_rows(bench);
    uint32_t width = bench->config.width, encoding = bench->config.levels * bench->config.features;
    struct reference_sample twin = {0};
    struct reference_d_sample d;
    copy_row(bench, rows, row.encoding, index, encoding, twin.encoding);
    reference_networks_forward(s, &params->weights, &twin);
    if (fabs(twin.geo[0] - log(reference_density_max)) < LAYER_ROUNDINGS * FLOAT_EPSILON * largest(twin.geo, REFERENCE_GEO))
        fail_msg("%s: sample %u stands at the kink of the density; choose another seed", bench->where, index);
    take_gates(width, relu[index].x, relu[index].y, twin.active1);
    take_gates(width, relu[index].z, relu[index].w, twin.active2);
    for (int c = 0; c < 3; c++) twin.rgb[c] = rgb_density[4 * index + c];
    const double d_rgb[3] = {d_field[4 * index], d_field[4 * index + 1], d_field[4 * index + 2]};
    reference_networks_backward(s, &params->weights, &twin, d_rgb, d_field[4 * index + 3], &d);
    double scale2 = largest(d.hidden2, width), scale_geo = largest(d.geo, REFERENCE_GEO) + scale2,
           scale1 = largest(d.hidden1, width) + scale_geo;
    check_row(bench, rows, "d_logit", row.d_logit, index, 3, d.logit, largest(d.logit, 3));
    assert_true(step_bench_row(bench, rows, row.d_logit, index)[3] == 0.0f); // the padding output
    check_row(bench, rows, "d_hidden2", row.d_hidden2, index, width, d.hidden2, scale2);
    check_row(bench, rows, "d_geo", row.d_geo, index, REFERENCE_GEO, d.geo, scale_geo);
    check_row(bench, rows, "d_hidden1", row.d_hidden1, index, width, d.hidden1, scale1);
    check_row(bench, rows, "d_encoding", row.d_encoding, index, encoding, d.encoding, largest(d.encoding, encoding) + scale1);
}

static void fill(const struct step_bench *bench, float *values, size_t count) {
    struct test_random random = {.seed = bench->config.seed + 1};
    for (size_t i = 0; i < count; i++) values[i] = test_random_next(&random);
}

static void backward_field_matches_the_twin(void **state) {
    (void)state;
    uint32_t saturated = 0;
    for (uint32_t i = 0; i < step_case_count; i++) {
        struct step_bench *bench = step_bench_open(&step_cases[i]);
        step_bench_gradients(bench, 1);
        float *d_field = calloc(4 * bench->padded_samples, sizeof *d_field);
        fill(bench, d_field, 4 * (size_t)bench->padded_samples);
        step_bench_write(bench, bench->step.d_samples, d_field);
        step_bench_dispatch(bench, bench->step.backward_field, NULL, 0, bench->padded_samples);
        float *rows = step_bench_read(bench, bench->field.rows), *samples = step_bench_read(bench, bench->step.samples);
        vw_uint4 *relu = step_bench_read(bench, bench->field.relu);
        struct reference_params *params = reference_params_create(&bench->model, bench->params);
        for (uint32_t sample = 0; sample < bench->padded_samples; sample++) {
            check_sample(bench, params, rows, relu, samples, d_field, sample);
            saturated += samples[4 * sample + 3] >= (float)reference_density_max;
        }
        reference_params_destroy(params);
        free(d_field);
        free(rows);
        free(samples);
        free(relu);
        step_bench_close(bench);
    }
    assert_true(saturated >= 10); // the cut of their gradient was put to the test
}

static void sum_rows(const struct step_bench *bench, const float *rows, bool magnitudes, struct reference_weights *sums) {
    struct step_rows row = step_bench_rows(bench);
    uint32_t width = bench->config.width, encoding = bench->config.levels * bench->config.features;
    memset(sums, 0, sizeof *sums);
    for (uint32_t i = 0; i < bench->padded_samples; i++) {
        struct reference_sample sample = {0};
        struct reference_d_sample d = {0};
        const struct {
            double *values;
            uint32_t row, count;
        } operands[] = {
            {sample.encoding, row.encoding, encoding},
            {sample.hidden1, row.hidden1, width},
            {sample.colour_in, row.colour_in, REFERENCE_COLOUR_IN},
            {sample.hidden2, row.hidden2, width},
            {d.hidden1, row.d_hidden1, width},
            {d.geo, row.d_geo, REFERENCE_GEO},
            {d.hidden2, row.d_hidden2, width},
            {d.logit, row.d_logit, REFERENCE_RGB},
        };
        for (size_t k = 0; k < sizeof operands / sizeof *operands; k++) {
            copy_row(bench, rows, operands[k].row, i, operands[k].count, operands[k].values);
            for (uint32_t j = 0; j < operands[k].count && magnitudes; j++) operands[k].values[j] = fabs(operands[k].values[j]);
        }
        reference_weights_gradient(&bench->model.specialization, &sample, &d, sums);
    }
}

static void check_weight_gradients(const struct step_bench *bench, const float *rows, const float *d_weights) {
    const struct vw_specialization *s = &bench->model.specialization;
    static struct reference_weights sums, magnitudes;
    struct reference_matrix sum[REFERENCE_MATRICES], magnitude[REFERENCE_MATRICES];
    sum_rows(bench, rows, false, &sums);
    sum_rows(bench, rows, true, &magnitudes);
    reference_matrices(s, &sums, sum);
    reference_matrices(s, &magnitudes, magnitude);
    for (uint32_t m = 0; m < REFERENCE_MATRICES; m++)
        for (uint32_t i = 0; i < sum[m].out * sum[m].in; i++)
            check_value(bench->where, sum[m].name, i, d_weights[reference_block_index(s, m, i / sum[m].in, i % sum[m].in)],
                        sum[m].values[i],
                        0.1 * SUM_ROUNDINGS * FLOAT_EPSILON * magnitude[m].values[i]); // 0.1: roundings go both ways
}

static void reduce(struct step_bench *bench, const float *rows) {
    struct vw_push_samples push = step_bench_push(bench, 1);
    uint64_t slices = bench->padded_samples / VW_SLICE_SAMPLES;
    step_bench_write(bench, bench->field.rows, rows);
    step_bench_dispatch(bench, bench->step.gradient_weights, &push, sizeof push, slices * bench->model.weight_tiles);
    step_bench_dispatch(bench, bench->step.reduce_weights, &push, sizeof push, bench->model.weight_columns);
}

static bool is_marked(struct step_bench *bench) {
    struct vw_step_state *flags = step_bench_read(bench, bench->field.step_state);
    bool marked = flags->nonfinite != 0;
    free(flags);
    return marked;
}

// One NaN in the last sample's rows, of the gradients and of the activations, marks the step by itself.
static void a_weight_gradient_that_is_not_finite_marks_the_step(void **state) {
    (void)state;
    struct step_bench *bench = step_bench_open(&step_cases[0]);
    size_t count = 4 * (size_t)bench->model.row_count * bench->padded_samples;
    struct step_rows row = step_bench_rows(bench);
    const uint32_t poisoned[] = {row.encoding, row.hidden2 + 1, row.d_geo, row.d_logit};
    float *rows = calloc(count, sizeof *rows);
    fill(bench, rows, count);
    reduce(bench, rows);
    assert_false(is_marked(bench));
    for (size_t i = 0; i < sizeof poisoned / sizeof *poisoned; i++) {
        float *value = (float *)step_bench_row(bench, rows, poisoned[i], bench->padded_samples - 1) + i % 3, kept = *value;
        *value = NAN;
        step_bench_write(bench, bench->field.step_state, &(struct vw_step_state){0});
        reduce(bench, rows);
        if (!is_marked(bench)) fail_msg("%s: NaN in row %u did not mark the step", bench->where, poisoned[i]);
        *value = kept;
    }
    free(rows);
    step_bench_close(bench);
}

static void weight_gradients_match_the_twin(void **state) {
    (void)state;
    for (uint32_t i = 0; i < step_case_count; i++) {
        struct step_bench *bench = step_bench_open(&step_cases[i]);
        size_t count = 4 * (size_t)bench->model.row_count * bench->padded_samples;
        float *rows = calloc(count, sizeof *rows);
        fill(bench, rows, count);
        reduce(bench, rows);
        float *d_weights = step_bench_read(bench, bench->step.d_weights);
        check_weight_gradients(bench, rows, d_weights);
        free(rows);
        free(d_weights);
        step_bench_close(bench);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(backward_field_matches_the_twin), cmocka_unit_test(weight_gradients_match_the_twin),
                                       cmocka_unit_test(a_weight_gradient_that_is_not_finite_marks_the_step)};
    return cmocka_run_group_tests_name("backward_field", tests, NULL, step_bench_teardown);
}
