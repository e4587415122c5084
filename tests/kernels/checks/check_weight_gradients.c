// gradient_weights and reduce_weights against the reference, on random activation rows and slices.
#include "support/cmocka_test.h"
#include "train/fields/registry.h"

#include "base/memory.h"
#include "gpu/compute.h"
#include "kernels/checks/check.h"

static uint32_t slice_count(const struct step_bench *bench) {
    return bench->padded_samples / bench->model.specialization.slice_samples;
}

static void run_gradient_weights(struct step_bench *bench, float *rows) {
    struct vw_push_samples push = step_bench_push(bench, 1);
    step_bench_write_rows(bench, rows);
    step_bench_dispatch(bench, bench->volume->gradient.field.passes[HASH_GRADIENT], &push, sizeof push,
                        (uint64_t)slice_count(bench) * bench->layout->weight_tiles *
                            bench->model.specialization.slice_parts);
}

static void run_reduce_weights(struct step_bench *bench, uint32_t first_ray) {
    struct vw_push_samples push = step_bench_push(bench, 1);
    push.first_ray = first_ray;
    step_bench_dispatch(bench, bench->volume->gradient.field.passes[HASH_REDUCE], &push, sizeof push,
                        bench->model.weight_columns);
}

void weight_gradients_run(struct step_bench *bench, float *rows) {
    run_gradient_weights(bench, rows);
    run_reduce_weights(bench, 0);
}

// ---- One slice's sums -----------------------------------------------------------------------------------------------

// Sums the products of one slice; `magnitudes`: those of the absolute values.
static void sum_rows(const struct step_bench *bench, const float *rows, uint32_t first, bool magnitudes,
                     struct reference_weights *sums) {
    struct step_rows row = step_bench_rows(bench);
    uint32_t width = bench->config.width, encoding = bench->config.levels * bench->config.features;
    memset(sums, 0, sizeof *sums);
    for (uint32_t i = first; i < first + bench->model.specialization.slice_samples; i++) {
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
        for (size_t k = 0; k < VW_ARRAY_COUNT(operands); k++) {
            for (uint32_t j = 0; j < operands[k].count; j++) {
                double value = step_bench_row(bench, rows, operands[k].row + j / 4, i)[j % 4];
                operands[k].values[j] = magnitudes ? fabs(value) : value;
            }
        }
        reference_weights_gradient(&bench->model.specialization, &sample, &d, sums);
    }
}

// Checks the sums of a slice. A sum of n products is off by at most n roundings of the sum of all magnitudes, and n
// products may be flushed to 0.
static void check_slice(const struct step_bench *bench, const float *rows, uint32_t slice, const float *partials) {
    const struct vw_specialization *s = &bench->model.specialization;
    static struct reference_weights sums, magnitudes;
    struct reference_matrix sum[REFERENCE_MATRICES], magnitude[REFERENCE_MATRICES];
    sum_rows(bench, rows, slice * s->slice_samples, false, &sums);
    sum_rows(bench, rows, slice * s->slice_samples, true, &magnitudes);
    reference_matrices(s, &sums, sum);
    reference_matrices(s, &magnitudes, magnitude);
    for (uint32_t m = 0; m < REFERENCE_MATRICES; m++)
        for (uint32_t i = 0; i < sum[m].out * sum[m].in; i++)
            check_value(bench->where, sum[m].name, i,
                        partials[reference_block_index(s, m, i / sum[m].in, i % sum[m].in)], sum[m].values[i],
                        s->slice_samples * (FLOAT_ROUNDING * magnitude[m].values[i] + 3.0 * FLOAT_LEAST));
}

void check_gradient_weights(struct step_bench *bench, enum input_kind kind) {
    size_t count, columns = bench->model.weight_columns;
    struct test_random random = {.seed = bench->config.seed + 1};
    float *rows = step_bench_new_rows(bench, &count);
    input_fill(kind, &random, rows, count);
    run_gradient_weights(bench, rows);
    float *partials = test_read(bench->volume->weight_partials);
    for (uint32_t slice = 0; slice < slice_count(bench); slice++)
        check_slice(bench, rows, slice, partials + 4 * columns * slice);
}

// ---- The sum of the slices ------------------------------------------------------------------------------------------

// Checks that the first chunk of a step overwrites and the second adds.
void check_reduce_weights(struct step_bench *bench, enum input_kind kind) {
    uint32_t slices = slice_count(bench);
    size_t weights = 4 * (size_t)bench->model.weight_columns;
    struct test_random random = {.seed = bench->config.seed + 2};
    float *partials = test_allocate(weights * slices, sizeof *partials);
    input_fill(kind, &random, partials, weights * slices);
    test_write(bench->volume->weight_partials, partials);
    test_write(bench->field.step_state, &(struct vw_step_state){0});
    for (uint32_t chunk = 0; chunk < 2; chunk++) {
        run_reduce_weights(bench, chunk * bench->step.padded_rays);
        float *d_weights = test_read(bench->step.d_weights);
        for (size_t i = 0; i < weights; i++) {
            double sum = 0.0, magnitude = 0.0, terms = (1.0 + chunk) * slices;
            for (uint32_t slice = 0; slice < slices; slice++) sum += partials[weights * slice + i];
            for (uint32_t slice = 0; slice < slices; slice++) magnitude += fabs((double)partials[weights * slice + i]);
            check_value(bench->where, chunk ? "d_weights, two chunks" : "d_weights", i, d_weights[i],
                        (1.0 + chunk) * sum, terms * (FLOAT_ROUNDING * (1.0 + chunk) * magnitude + FLOAT_LEAST));
        }
    }
    struct vw_step_state *flags = test_read(bench->field.step_state);
    assert_int_equal(flags->nonfinite, 0);
}
