// forward_field against the reference. In training, stage by stage: each stage of the reference starts from what the
// device found before it, so that a tolerance is the rounding of few stages. In validation, where stages leave nothing
// behind, from the rays to the end.
#include "support/cmocka_test.h"
#include "train/fields/registry.h"

#include "base/memory.h"
#include "kernels/checks/check.h"

static const double POSITION_TOLERANCE = 1e-6;      // box edges: a few roundings of ray parameters up to 4 edges
static const double ENCODING_ROUNDINGS = 16.0;      // relative to the largest: weights of three factors, eight terms
static const double HARMONICS_TOLERANCE = 1e-6;     // a few roundings at values up to 1.1
static const double SIGMOID_TOLERANCE = 4e-6;       // the device's exp and division, at values up to 1
static const uint64_t STEP = UINT64_C(0x300000005); // needs both words

struct outputs {
    struct vw_ray *rays;
    float *rows, *samples;
    vw_uint4 *relu;
};

struct reference {
    struct reference_params *params;
    struct reference_matrix matrices[REFERENCE_MATRICES];
    double mix_error[REFERENCE_WIDTH_MAX]; // by the photo's code
    double grid_largest;
};

struct errors {
    double encoding[REFERENCE_ENCODING_MAX], hidden1[REFERENCE_WIDTH_MAX], geo[REFERENCE_GEO],
        colour_in[REFERENCE_COLOUR_IN], hidden2[REFERENCE_WIDTH_MAX], logit[REFERENCE_RGB];
};

// Finds the errors of all outputs from errors->encoding on.
static void find_errors(const struct reference *reference, const struct reference_sample *sample,
                        struct errors *errors) {
    product_errors(&reference->matrices[0], false, sample->encoding, errors->encoding, errors->hidden1);
    product_errors(&reference->matrices[1], false, sample->hidden1, errors->hidden1, errors->geo);
    for (int i = 0; i < REFERENCE_COLOUR_IN; i++)
        errors->colour_in[i] = i > 0 && i < REFERENCE_GEO ? errors->geo[i] : HARMONICS_TOLERANCE;
    product_errors(&reference->matrices[2], false, sample->colour_in, errors->colour_in, errors->hidden2);
    for (uint32_t i = 0; i < reference->matrices[2].out; i++) errors->hidden2[i] += reference->mix_error[i];
    product_errors(&reference->matrices[3], false, sample->hidden2, errors->hidden2, errors->logit);
}

// Returns Vulkan's bound for exp, relative.
static double exp_error(double x) { return (3.0 + 2.0 * fabs(x)) * 0x1p-23; }

static double sigmoid(double x) { return 1.0 / (1.0 + exp(-x)); }

static void check_sample(const struct step_bench *bench, const struct reference *reference,
                         const struct reference_sample *sample, const struct errors *errors, const float *rgb_density,
                         uint32_t index) {
    double raw = sample->geo[0], most = log(reference_density_max), lowest = fmin(raw - errors->geo[0], most),
           highest = fmin(raw + errors->geo[0], most);
    check_between(bench->where, "density", index, rgb_density[3], exp(lowest) * (1.0 - exp_error(lowest)) - FLOAT_LEAST,
                  fmin(exp(highest) * (1.0 + exp_error(highest)) + FLOAT_LEAST, reference_density_max));
    for (uint32_t c = 0; c < REFERENCE_RGB; c++) {
        double logit = 0.0;
        for (uint32_t i = 0; i < reference->matrices[3].in; i++)
            logit += reference->matrices[3].values[c * reference->matrices[3].in + i] * sample->hidden2[i];
        check_between(bench->where, "rgb", index, rgb_density[c], sigmoid(logit - errors->logit[c]) - SIGMOID_TOLERANCE,
                      sigmoid(logit + errors->logit[c]) + SIGMOID_TOLERANCE);
    }
}

// ---- Training -------------------------------------------------------------------------------------------------------

static void copy_row(const struct step_bench *bench, const float *rows, uint32_t first_row, uint32_t sample,
                     uint32_t count, double *values) {
    for (uint32_t i = 0; i < count; i++) values[i] = step_bench_row(bench, rows, first_row + i / 4, sample)[i % 4];
}

static void check_gates(const struct step_bench *bench, const char *what, uint32_t sample, uint32_t low, uint32_t high,
                        const double *before, const double *errors) {
    for (uint32_t i = 0; i < bench->config.width; i++) {
        bool on = (i < 32 ? low >> i : high >> (i - 32)) & 1;
        if (on != (before[i] > 0.0) && fabs(before[i]) > errors[i])
            fail_msg("%s: %s: unit %u of sample %u is %s at %g", bench->where, what, i, sample, on ? "on" : "off",
                     before[i]);
    }
}

static void check_training_sample(const struct step_bench *bench, const struct reference *reference,
                                  const struct outputs *out, uint32_t slot) {
    const struct vw_specialization *s = &bench->model.specialization;
    struct step_rows rows = step_bench_rows(bench);
    uint32_t encoding = bench->config.levels * bench->config.features, width = bench->config.width;
    struct reference_ray ray = reference_ray_of(&out->rays[slot / s->samples]);
    struct reference_sample sample;
    struct errors errors = {0};
    reference_sample_position(
        s, &ray, slot % s->samples,
        reference_stratum_offset(s, slot / s->samples, slot % s->samples, vw_model_key_of_step(&bench->model, STEP)),
        sample.position);
    for (uint32_t axis = 0; axis < 3; axis++)
        check_value(bench->where, "position", slot, step_bench_row(bench, out->rows, rows.position, slot)[axis],
                    sample.position[axis], POSITION_TOLERANCE);

    copy_row(bench, out->rows, rows.position, slot, 3, sample.position);
    memcpy(sample.direction, ray.direction, sizeof sample.direction);
    reference_grid_encode(s, reference->params->grid, sample.position, sample.encoding);
    for (uint32_t i = 0; i < encoding; i++)
        errors.encoding[i] = ENCODING_ROUNDINGS * (FLOAT_ROUNDING * reference->grid_largest + FLOAT_LEAST);
    check_row(bench, out->rows, "encoding", rows.encoding, slot, encoding, sample.encoding, errors.encoding);

    reference_networks_forward(s, &reference->params->weights, &sample);
    find_errors(reference, &sample, &errors);
    check_row(bench, out->rows, "hidden1", rows.hidden1, slot, width, sample.hidden1, errors.hidden1);
    check_row(bench, out->rows, "colour_in", rows.colour_in, slot, REFERENCE_COLOUR_IN, sample.colour_in,
              errors.colour_in);
    check_row(bench, out->rows, "hidden2", rows.hidden2, slot, width, sample.hidden2, errors.hidden2);
    check_gates(bench, "relu 1", slot, out->relu[slot].x, out->relu[slot].y, sample.before1, errors.hidden1);
    check_gates(bench, "relu 2", slot, out->relu[slot].z, out->relu[slot].w, sample.before2, errors.hidden2);
    check_sample(bench, reference, &sample, &errors, out->samples + 4 * (size_t)slot, slot);
}

static void check_training(struct step_bench *bench, const struct reference *reference) {
    step_bench_gradients(bench, STEP);
    struct outputs out = {test_read(bench->step.ray_buffer), step_bench_read_rows(bench),
                          test_read(bench->volume->samples), step_bench_read_active(bench)};
    for (uint32_t sample = 0; sample < bench->padded_samples; sample++)
        check_training_sample(bench, reference, &out, sample);
}

// ---- Validation -----------------------------------------------------------------------------------------------------

static void check_validation_sample(const struct step_bench *bench, const struct reference *reference,
                                    const struct vw_ray *rays, const float *samples, uint32_t index) {
    const struct vw_specialization *s = &bench->model.specialization;
    struct reference_ray ray = reference_ray_of(&rays[index / s->samples]);
    struct reference_sample sample;
    struct errors errors;
    reference_sample_position(s, &ray, index % s->samples, 0.5, sample.position);
    memcpy(sample.direction, ray.direction, sizeof sample.direction);
    reference_grid_encode(s, reference->params->grid, sample.position, sample.encoding);
    // Within a cell an encoding changes by at most 2 entries per cell and axis.
    for (uint32_t i = 0; i < REFERENCE_ENCODING_MAX; i++)
        errors.encoding[i] = reference->grid_largest *
                                 (6.0 * POSITION_TOLERANCE * s->resolution[i / (2 * s->feature_pairs) % VW_LEVELS_MAX] +
                                  ENCODING_ROUNDINGS * FLOAT_ROUNDING) +
                             ENCODING_ROUNDINGS * FLOAT_LEAST;
    reference_networks_forward(s, &reference->params->weights, &sample);
    find_errors(reference, &sample, &errors);
    check_sample(bench, reference, &sample, &errors, samples + 4 * (size_t)index, index);
}

static void check_validation(struct step_bench *bench, const struct reference *reference) {
    struct vw_evaluator *evaluator = step_bench_evaluator(bench);
    struct vw_push_samples push = {.ray_count = evaluator->ray_count};
    assert_true(vw_volume_evaluation_of(evaluator)->chunk_rays == evaluator->ray_count);
    assert_int_equal(vw_evaluator_set_pixels(evaluator, bench->pixels, bench->config.rays), VW_OK);
    step_bench_dispatch(bench, vw_volume_evaluation_of(evaluator)->passes.passes[HASH_FORWARD], &push, sizeof push,
                        (uint64_t)push.ray_count * bench->config.samples);
    struct vw_ray *rays = test_read(evaluator->rays);
    float *samples = test_read(vw_volume_evaluation_of(evaluator)->samples);
    for (uint32_t i = 0; i < push.ray_count * bench->config.samples; i++)
        check_validation_sample(bench, reference, rays, samples, i);
}

// ---- The check ------------------------------------------------------------------------------------------------------

// Makes params whose grid holds inputs of the kind; the weights do as well where the kind is a zero.
static float *make_params(const struct step_bench *bench, enum input_kind kind) {
    struct test_random random = {.seed = bench->config.seed};
    float *params = test_allocate(bench->model.param_bytes, 1);
    memcpy(params, bench->params, bench->model.param_bytes);
    if (kind == INPUT_ORDINARY) return params;
    size_t features = 2 * (size_t)bench->layout->pair_count,
           rest = (bench->model.param_bytes - bench->layout->grid.size_bytes) / sizeof *params;
    input_fill(kind, &random, params, features);
    if (kind == INPUT_ZERO || kind == INPUT_NEGATIVE_ZERO)
        input_fill(kind, &random, params + bench->model.weights.offset_bytes / sizeof *params, rest);
    return params;
}

// Adds what the code of the photo does in training, or takes it away again.
static void mix(const struct step_bench *bench, struct reference *reference, double sign) {
    uint32_t width = bench->config.width;
    double shift[REFERENCE_WIDTH_MAX];
    if (!bench->model.ranges[VW_SLOT_CODES].size_bytes) return;
    const double *code = reference->params->photos[bench->view].code;
    reference_mix_code(width, reference->params->code_weights, code, shift);
    for (uint32_t i = 0; i < width; i++) {
        double magnitude = 0.0;
        for (uint32_t k = 0; k < REFERENCE_CODE; k++)
            magnitude += fabs(reference->params->code_weights[i * REFERENCE_CODE + k] * code[k]);
        reference->params->weights.colour1[i * REFERENCE_COLOUR_IN] += sign * shift[i];
        reference->mix_error[i] = sign > 0.0 ? (REFERENCE_CODE + 2.0) * FLOAT_ROUNDING * (magnitude + 1.0) : 0.0;
    }
}

void check_forward_field(struct step_bench *bench, enum input_kind kind) {
    const struct vw_specialization *s = &bench->model.specialization;
    const vw_uint4 key = vw_model_key_of_step(&bench->model, STEP); // key of the jitter
    assert_true(((uint64_t)key.y << 32 | key.x) == bench->config.seed && ((uint64_t)key.w << 32 | key.z) == STEP);
    float *params = make_params(bench, kind);
    struct reference reference = {.params = reference_params_create(&bench->model, params)};
    reference_matrices(s, &reference.params->weights, reference.matrices);
    reference.grid_largest = largest(reference.params->grid, 2 * (size_t)bench->layout->pair_count);
    test_write(bench->field.params, params);
    mix(bench, &reference, 1.0);
    check_training(bench, &reference);
    mix(bench, &reference, -1.0);
    check_validation(bench, &reference);
    step_bench_write_params(bench);
}
