// backward_field against the reference, on random gradients of the samples. check_forward_field holds the device's
// activations and decisions against the reference; here the reference starts from them.
#include "support/cmocka_test.h"
#include "train/fields/registry.h"

#include "base/memory.h"
#include "kernels/checks/check.h"

struct device {
    float *rows, *samples, *d_samples;
    vw_uint4 *relu;
};

static void take_gates(uint32_t width, uint32_t low, uint32_t high, bool *active) {
    for (uint32_t i = 0; i < width; i++) active[i] = (i < 32 ? low >> i : high >> (i - 32)) & 1;
}

// Runs the forward pass from the device's position on, with the device's decisions and colours.
static void go_forward(const struct step_bench *bench, const struct reference_params *params,
                       const struct device *device, uint32_t index, struct reference_sample *sample) {
    uint32_t width = bench->config.width;
    const float *position = step_bench_row(bench, device->rows, step_bench_rows(bench).position, index);
    const double at[3] = {position[0], position[1], position[2]};
    reference_grid_encode(&bench->model.specialization, params->grid, at, sample->encoding);
    reference_networks_forward(&bench->model.specialization, &params->weights, sample);
    take_gates(width, device->relu[index].x, device->relu[index].y, sample->active1);
    take_gates(width, device->relu[index].z, device->relu[index].w, sample->active2);
    sample->saturated = device->samples[4 * (size_t)index + 3] >= (float)reference_density_max;
    for (int c = 0; c < 3; c++) sample->rgb[c] = device->samples[4 * (size_t)index + (size_t)c];
}

static void check_sample(const struct step_bench *bench, struct reference_params *params, const struct device *device,
                         uint32_t index) {
    const struct vw_specialization *s = &bench->model.specialization;
    struct step_rows row = step_bench_rows(bench);
    const float *d_field = device->d_samples + 4 * (size_t)index;
    const double d_rgb[3] = {d_field[0], d_field[1], d_field[2]};
    struct reference_matrix matrices[REFERENCE_MATRICES];
    struct reference_sample sample = {0};
    struct reference_d_sample d;
    double logit[REFERENCE_RGB], hidden2[REFERENCE_WIDTH_MAX], colour_in[REFERENCE_COLOUR_IN],
        hidden1[REFERENCE_WIDTH_MAX],
        encoding[REFERENCE_ENCODING_MAX]; // how far they may be off
    go_forward(bench, params, device, index, &sample);
    reference_networks_backward(s, &params->weights, &sample, d_rgb, d_field[3], &d);
    reference_matrices(s, &params->weights, matrices);
    for (int c = 0; c < REFERENCE_RGB; c++)
        logit[c] = 4.0 * (FLOAT_ROUNDING * fabs(d_rgb[c] * sample.rgb[c]) + FLOAT_LEAST);
    product_errors(&matrices[3], true, d.logit, logit, hidden2);
    product_errors(&matrices[2], true, d.hidden2, hidden2, colour_in);
    colour_in[0] = FLOAT_LEAST; // the raw density's gradient stands there, as it came
    product_errors(&matrices[1], true, d.geo, colour_in, hidden1);
    product_errors(&matrices[0], true, d.hidden1, hidden1, encoding);
    check_row(bench, device->rows, "d_logit", row.d_logit, index, REFERENCE_RGB, d.logit, logit);
    assert_true(step_bench_row(bench, device->rows, row.d_logit, index)[3] == 0.0f); // the padding output
    check_row(bench, device->rows, "d_hidden2", row.d_hidden2, index, bench->config.width, d.hidden2, hidden2);
    check_row(bench, device->rows, "d_geo", row.d_geo, index, REFERENCE_GEO, d.geo, colour_in);
    check_row(bench, device->rows, "d_hidden1", row.d_hidden1, index, bench->config.width, d.hidden1, hidden1);
    for (uint32_t i = 0; i < bench->config.levels * bench->config.features; i++)
        check_value(bench->where, "d_encoding", index,
                    step_bench_row(bench, device->rows, row.d_encoding + i / 4, index)[i % 4], d.encoding[i],
                    encoding[i]);
}

// Sets some densities to their maximum, where their gradient is cut.
static void saturate_some(struct step_bench *bench, float *samples) {
    for (uint32_t i = 3; i < bench->padded_samples; i += 16) samples[4 * (size_t)i + 3] = (float)reference_density_max;
    test_write(bench->volume->samples, samples);
}

void check_backward_field(struct step_bench *bench, enum input_kind kind) {
    struct test_random random = {.seed = bench->config.seed + 1};
    struct device device = {.d_samples = test_allocate(4 * (size_t)bench->padded_samples, sizeof(float))};
    step_bench_gradients(bench, 1);
    input_fill(kind, &random, device.d_samples, 4 * (size_t)bench->padded_samples);
    test_write(bench->volume->d_samples, device.d_samples);
    device.samples = test_read(bench->volume->samples);
    saturate_some(bench, device.samples);
    step_bench_dispatch(bench, bench->volume->gradient.field.passes[HASH_BACKWARD], NULL, 0, bench->padded_samples);
    device.rows = step_bench_read_rows(bench);
    device.relu = step_bench_read_active(bench);
    struct reference_params *params = reference_params_create(&bench->model, bench->params);
    for (uint32_t i = 0; i < bench->padded_samples; i++) check_sample(bench, params, &device, i);
}
