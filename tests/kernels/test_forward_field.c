// forward_field against the twin, stage by stage: each stage of the twin starts from what the device found before it, so that a tolerance
// is the rounding of one stage.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "reference/reference.h"
#include "reference/step_bench.h"

static const double FLOAT_EPSILON = 0x1p-24;        // half a unit in the last place, relative
static const double POSITION_TOLERANCE = 1e-6;      // box edges: a few roundings of ray parameters up to 4 edges
static const double ENCODING_ROUNDINGS = 16.0;      // of the largest entry: weights of three factors each, eight terms
static const double LAYER_ROUNDINGS = 64.0;         // of the largest value of a layer: up to 64 terms, three layers deep
static const double RGB_TOLERANCE = 4e-6;           // the device's exp and division, at values up to 1
static const uint64_t STEP = UINT64_C(0x300000005); // needs both words

struct outputs {
    struct vw_ray *rays;
    float *rows, *samples;
    vw_uint4 *relu;
};

static void copy_row(const struct step_bench *bench, const float *rows, uint32_t first_row, uint32_t sample, uint32_t count,
                     double *values) {
    for (uint32_t i = 0; i < count; i++) values[i] = step_bench_row(bench, rows, first_row + i / 4, sample)[i % 4];
}

static void check_row(const struct step_bench *bench, const struct outputs *out, const char *what, uint32_t row, uint32_t sample,
                      uint32_t count, const double *expected, double tolerance) {
    for (uint32_t i = 0; i < count; i++)
        check_value(bench->where, what, sample, step_bench_row(bench, out->rows, row + i / 4, sample)[i % 4], expected[i], tolerance);
}

static void check_gates(const struct step_bench *bench, const char *what, uint32_t sample, uint32_t low, uint32_t high,
                        const double *before, double tolerance) {
    for (uint32_t i = 0; i < bench->config.width; i++) {
        bool on = (i < 32 ? low >> i : high >> (i - 32)) & 1;
        if (on != (before[i] > 0.0) && fabs(before[i]) > tolerance)
            fail_msg("%s: %s: unit %u of sample %u is %s at %g", bench->where, what, i, sample, on ? "on" : "off", before[i]);
    }
}

static void check_sample(const struct step_bench *bench, const struct reference_params *params, const struct outputs *out, uint32_t index) {
    const struct vw_specialization *s = &bench->model.specialization;
    struct step_rows rows = step_bench_rows(bench);
    struct reference_ray ray = reference_ray_of(&out->rays[index / s->samples]);
    struct reference_sample twin;
    double offset = reference_stratum_offset(s, index / s->samples, index % s->samples, STEP);
    reference_sample_position(&ray, index % s->samples, offset, twin.position);
    check_row(bench, out, "position", rows.position, index, 3, twin.position, POSITION_TOLERANCE);

    copy_row(bench, out->rows, rows.position, index, 3, twin.position);
    memcpy(twin.direction, ray.direction, sizeof twin.direction);
    reference_grid_encode(s, params->grid, twin.position, twin.encoding);
    uint32_t encoding = bench->config.levels * bench->config.features, width = bench->config.width;
    double grid_largest = largest(params->grid, 2 * bench->model.pair_count);
    check_row(bench, out, "encoding", rows.encoding, index, encoding, twin.encoding, ENCODING_ROUNDINGS * FLOAT_EPSILON * grid_largest);

    copy_row(bench, out->rows, rows.encoding, index, encoding, twin.encoding);
    reference_networks_forward(s, &params->weights, &twin);
    double tolerance1 = LAYER_ROUNDINGS * FLOAT_EPSILON * largest(twin.before1, width);
    double tolerance_geo = LAYER_ROUNDINGS * FLOAT_EPSILON * (largest(twin.geo, REFERENCE_GEO) + 1.0);
    double tolerance2 = LAYER_ROUNDINGS * FLOAT_EPSILON * (largest(twin.before2, width) + largest(twin.colour_in, REFERENCE_COLOUR_IN));
    check_row(bench, out, "hidden1", rows.hidden1, index, width, twin.hidden1, tolerance1);
    check_row(bench, out, "colour_in", rows.colour_in, index, REFERENCE_COLOUR_IN, twin.colour_in, tolerance_geo);
    check_row(bench, out, "hidden2", rows.hidden2, index, width, twin.hidden2, tolerance2);
    check_gates(bench, "relu 1", index, out->relu[index].x, out->relu[index].y, twin.before1, tolerance1);
    check_gates(bench, "relu 2", index, out->relu[index].z, out->relu[index].w, twin.before2, tolerance2);
    const float *rgb_density = out->samples + 4 * (size_t)index;
    double density_tolerance = twin.density * (expm1(tolerance_geo) + LAYER_ROUNDINGS * FLOAT_EPSILON); // exp turns absolute into relative
    check_value(bench->where, "density", index, rgb_density[3], twin.density, density_tolerance);
    for (int c = 0; c < 3; c++) {
        double tolerance_logit = 0.0;
        for (uint32_t i = 0; i < width; i++) tolerance_logit += fabs(params->weights.colour2[c * width + i]) * tolerance2;
        double slope = twin.rgb[c] * (1.0 - twin.rgb[c]);
        check_value(bench->where, "rgb", index, rgb_density[c], twin.rgb[c], RGB_TOLERANCE + slope * expm1(tolerance_logit));
    }
}

static void forward_field_matches_the_twin(void **state) {
    (void)state;
    for (uint32_t i = 0; i < step_case_count; i++) {
        struct step_bench *bench = step_bench_open(&step_cases[i]);
        step_bench_gradients(bench, STEP);
        struct outputs out = {step_bench_read(bench, bench->step.ray_buffer), step_bench_read(bench, bench->field.rows),
                              step_bench_read(bench, bench->step.samples), step_bench_read(bench, bench->field.relu)};
        struct reference_params *params = reference_params_create(&bench->model, bench->params);
        for (uint32_t sample = 0; sample < bench->padded_samples; sample++) check_sample(bench, params, &out, sample);
        reference_params_destroy(params);
        free(out.rays);
        free(out.rows);
        free(out.samples);
        free(out.relu);
        step_bench_close(bench);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(forward_field_matches_the_twin)};
    return cmocka_run_group_tests_name("forward_field", tests, NULL, step_bench_teardown);
}
