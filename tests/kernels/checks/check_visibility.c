// The passes of the effects `visibility` and `uncertainty` against the reference: how visible or certain rays are, the
// backward pass through the network, group by group, their sum, and the step of a photo's code.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "kernels/checks/check.h"

// Three layers of up to 40 products, each of order 1 to 10, and the encoding's sines, good to 1e-6 at 16 pi.
static const double VISIBLE_TOLERANCE = 2e-5;
static const double GRADIENT_TOLERANCE = 5e-4; // relative to the largest: a unit near the kink may fall to either side
static const double STEP_TOLERANCE = 5e-4;     // relative to a step's length: see check_optimizer.c
enum { CODE_WORDS = sizeof(struct vw_visibility_moments) / 4, UPDATES = 3 };

static bool is_off(const struct step_bench *bench) {
    if (step_bench_effect_pass(bench, "predict_visibility")) return false;
    assert_int_equal(
        vw_visibility_network(&bench->model).size_bytes + bench->model.ranges[VW_SLOT_VISIBILITY_CODES].size_bytes, 0);
    assert_null(bench->step.effect_buffers[VW_SLOT_VISIBILITY]);
    assert_null(bench->step.effect_buffers[VW_SLOT_VISIBILITY_PARTIALS]);
    assert_null(bench->step.effect_buffers[VW_SLOT_VISIBILITY_MOMENTS]);
    assert_null(bench->field.effect_buffers[VW_SLOT_PHOTO_SCALES]);
    assert_null(bench->step.effect_buffers[VW_SLOT_FEATURES]);
    assert_int_equal(vw_uncertainty_network(&bench->model).size_bytes, 0);
    return true;
}

// Returns the numbers of the network of the effect that is on.
static uint32_t network_size(const struct step_bench *bench) {
    return bench->model.specialization.effect_uncertainty ? REFERENCE_UNCERTAINTY : REFERENCE_VISIBILITY;
}

static struct vw_push_rays push_of(const struct step_bench *bench) {
    return (struct vw_push_rays){.ray_count = bench->config.rays, .key = vw_model_key_of_step(&bench->model, 1)};
}

// Draws a code of the kind into the device's params. Returns the network with that code, in double.
static struct reference_params *draw_code(struct step_bench *bench, enum input_kind kind) {
    struct test_random random = {.seed = bench->config.seed};
    const struct vw_param_range codes = bench->model.ranges[VW_SLOT_VISIBILITY_CODES];
    step_bench_write_params(bench);
    float *params = step_bench_read(bench, bench->field.params);
    if (codes.size_bytes)
        input_fill(kind, &random, params + codes.offset_bytes / 4 + REFERENCE_VISIBILITY_CODE * bench->view,
                   REFERENCE_VISIBILITY_CODE);
    step_bench_write(bench, bench->field.params, params);
    step_bench_write(bench, bench->field.step_state, &(struct vw_step_state){.view = bench->view});
    struct reference_params *reference = reference_params_create(&bench->model, params);
    return reference;
}

// Returns how much a ray counts.
static double weight_of(const struct step_bench *bench, const struct reference_params *params, uint32_t ray) {
    double place[2], features[REFERENCE_FEATURES];
    step_bench_place(bench, ray, place);
    step_bench_features(bench, ray, features);
    return params->uncertainty ? reference_certainty(params->uncertainty, features)
                               : reference_visibility(params->visibility, params->visibility_codes[bench->view], place);
}

static void add_gradient(const struct step_bench *bench, const struct reference_params *params, uint32_t ray,
                         double d_weight, double *d_network) {
    double place[2], features[REFERENCE_FEATURES], d_code[REFERENCE_VISIBILITY_CODE] = {0};
    step_bench_place(bench, ray, place);
    step_bench_features(bench, ray, features);
    if (params->uncertainty) reference_certainty_gradient(params->uncertainty, features, d_weight, d_network);
    else
        reference_visibility_gradient(params->visibility, params->visibility_codes[bench->view], place, d_weight,
                                      d_network, d_code);
}

void check_predict_visibility(struct step_bench *bench, enum input_kind kind) {
    if (is_off(bench)) return;
    struct reference_params *params = draw_code(bench, kind);
    const struct vw_push_rays push = push_of(bench);
    double size = params->uncertainty ? 0.0 : largest(params->visibility_codes[bench->view], REFERENCE_VISIBILITY_CODE);
    step_bench_dispatch(bench, step_bench_effect_pass(bench, "predict_visibility"), &push, sizeof push,
                        bench->step.padded_rays);
    float *found = step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_VISIBILITY]);
    for (uint32_t ray = 0; ray < bench->step.padded_rays; ray++) {
        check_value(bench->where, "visibility", ray, found[2 * ray], weight_of(bench, params, ray),
                    VISIBLE_TOLERANCE * (1.0 + size));
        check_value(bench->where, "its gradient, before the loss", ray, found[2 * ray + 1], 0.0, 0.0);
    }
    step_bench_write_params(bench);
}

void check_gradient_visibility(struct step_bench *bench, enum input_kind kind) {
    if (is_off(bench)) return;
    struct test_random random = {.seed = bench->config.seed + 3};
    struct reference_params *params = draw_code(bench, INPUT_ORDINARY);
    const struct vw_push_rays push = push_of(bench);
    float *of_rays = step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_VISIBILITY]);
    uint32_t groups = (bench->step.padded_rays + VISIBILITY_GROUP - 1) / VISIBILITY_GROUP, size = network_size(bench);
    for (uint32_t ray = 0; ray < bench->step.padded_rays; ray++) of_rays[2 * ray + 1] = input_draw(kind, &random);
    step_bench_write(bench, bench->step.effect_buffers[VW_SLOT_VISIBILITY], of_rays);
    step_bench_dispatch(bench, step_bench_effect_pass(bench, "gradient_visibility"), &push, sizeof push,
                        bench->step.padded_rays);
    float *partials = step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_VISIBILITY_PARTIALS]);
    for (uint32_t group = 0; group < groups; group++) {
        double expected[REFERENCE_VISIBILITY] = {0};
        for (uint32_t ray = group * VISIBILITY_GROUP;
             ray < (group + 1) * VISIBILITY_GROUP && ray < bench->step.padded_rays; ray++)
            add_gradient(bench, params, ray, of_rays[2 * ray + 1], expected);
        for (uint32_t i = 0; i < size; i++)
            check_value(bench->where, "gradient of the network", i, partials[group * size + i], expected[i],
                        GRADIENT_TOLERANCE * largest(expected, size) + FLOAT_LEAST);
    }
    step_bench_write_params(bench);
}

// Checks the sums in the order of the groups, to the bit.
void check_reduce_visibility(struct step_bench *bench, enum input_kind kind) {
    if (is_off(bench)) return;
    struct test_random random = {.seed = bench->config.seed + 4};
    size_t count = vw_buffer_size_bytes(bench->step.effect_buffers[VW_SLOT_VISIBILITY_PARTIALS]) / sizeof(float);
    const uint32_t size = network_size(bench);
    const struct vw_push_reduce push = {.count = (uint32_t)count / size};
    float *partials = test_allocate(count, sizeof *partials), *before = step_bench_read(bench, bench->step.d_weights);
    uint32_t first = 4 * bench->model.specialization.visibility_column;
    input_fill(kind, &random, partials, count);
    step_bench_write(bench, bench->step.effect_buffers[VW_SLOT_VISIBILITY_PARTIALS], partials);
    step_bench_write(bench, bench->field.step_state, &(struct vw_step_state){.view = bench->view});
    step_bench_dispatch(bench, step_bench_effect_pass(bench, "reduce_visibility"), &push, sizeof push, size / 4);
    float *d_weights = step_bench_read(bench, bench->step.d_weights);
    struct vw_step_state *flags = step_bench_read(bench, bench->field.step_state);
    for (uint32_t i = 0; i < size; i++) {
        float sum = 0.0f;
        for (size_t k = i; k < count; k += size) sum += partials[k];
        check_value(bench->where, "sum over groups", i, d_weights[first + i], sum,
                    kind == INPUT_DENORMAL ? 64.0 * FLOAT_LEAST : 0.0);
    }
    check_same_bits(bench->where, "other gradients", d_weights, before, first * sizeof *before);
    assert_int_equal(flags->nonfinite, 0);
}

static void update_code(struct step_bench *bench, const float *d_weights) {
    const struct vw_specialization *s = &bench->model.specialization;
    struct vw_push_update push = {.adam = vw_adam_of(&bench->model.specialization)};
    float *before = step_bench_read(bench, bench->field.params),
          *moments = step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_VISIBILITY_MOMENTS]);
    struct reference_params *params = reference_params_create(&bench->model, before);
    step_bench_write(bench, bench->step.d_weights, d_weights);
    step_bench_write(bench, bench->field.step_state, &(struct vw_step_state){.view = bench->view});
    step_bench_dispatch(bench, step_bench_effect_pass(bench, "update_visibility"), &push, sizeof push, 1);
    float *after = step_bench_read(bench, bench->field.params),
          *moments_after = step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_VISIBILITY_MOMENTS]);
    const float *own = moments + CODE_WORDS * bench->view, *own_after = moments_after + CODE_WORDS * bench->view;
    uint32_t visits, visits_after, first = (uint32_t)(bench->model.ranges[VW_SLOT_VISIBILITY_CODES].offset_bytes / 4);
    memcpy(&visits, own + 2 * REFERENCE_VISIBILITY_CODE, 4);
    memcpy(&visits_after, own_after + 2 * REFERENCE_VISIBILITY_CODE, 4);
    check_value(bench->where, "visits", bench->view, visits_after, visits < INT32_MAX ? visits + 1.0 : INT32_MAX, 0.0);
    for (uint32_t k = 0; k < REFERENCE_VISIBILITY_CODE; k++) {
        double gradient = 0.0, magnitude = 0.0, moment1 = own[k], moment2 = own[REFERENCE_VISIBILITY_CODE + k];
        for (uint32_t unit = 0; unit < 4 * VISIBILITY4; unit++) { // blocks of the first layer, rows of 40 inputs
            uint32_t row = 16 * (unit / 4) * VISIBILITY_INPUT4 + unit % 4, in4 = VISIBILITY_PLACE4 + k / 4;
            double d_sum = (double)d_weights[4 * s->visibility_column + row + 4 * 2] * s->inverse_rays,
                   weight = params->visibility[row + 16 * in4 + 4 * (k % 4)];
            gradient += d_sum * weight;
            magnitude += fabs(d_sum * weight);
        }
        uint32_t at = first + REFERENCE_VISIBILITY_CODE * bench->view + k;
        double rate = reference_photo_rate(visits_after), epsilon = (double)s->gradient_quantum * s->inverse_rays,
               moved = rate * reference_adam(s, gradient, visits_after, &moment1, &moment2),
               error = 24.0 * FLOAT_ROUNDING * magnitude + 64.0 * FLOAT_LEAST,
               size = sqrt(moment2 / (1.0 - pow(s->beta2, (double)visits_after))) + epsilon;
        if (s->optimizer == OPTIMIZER_SGD) size = 1.0;
        check_value(bench->where, "code", k, after[at], before[at] - moved,
                    STEP_TOLERANCE * fabs(moved) +
                        4.0 * rate * s->learning_rate * (error / size + FLOAT_LEAST / epsilon) +
                        2.0 * FLOAT_ROUNDING * fabs(after[at]));
        after[at] = before[at];
    }
    check_same_bits(bench->where, "all other params", after, before, bench->model.param_bytes);
    memcpy(moments_after + CODE_WORDS * bench->view, own, CODE_WORDS * sizeof *own);
    check_same_bits(bench->where, "other codes' moments", moments_after, moments,
                    vw_buffer_size_bytes(bench->step.effect_buffers[VW_SLOT_VISIBILITY_MOMENTS]));
}

void check_update_visibility(struct step_bench *bench, enum input_kind kind) {
    if (is_off(bench) || !bench->model.specialization.effect_visibility) return;
    struct test_random random = {.seed = bench->config.seed};
    float *d_weights = test_allocate(vw_buffer_size_bytes(bench->step.d_weights), 1);
    uint32_t *zeros = test_allocate(vw_buffer_size_bytes(bench->step.effect_buffers[VW_SLOT_VISIBILITY_MOMENTS]), 1);
    zeros[CODE_WORDS * bench->view + CODE_WORDS - 1] = kind == INPUT_SATURATING ? INT32_MAX - 1 : 0;
    step_bench_write_params(bench);
    step_bench_write(bench, bench->step.effect_buffers[VW_SLOT_VISIBILITY_MOMENTS], zeros);
    for (int i = 0; i < UPDATES; i++) {
        input_fill(kind, &random, d_weights + 4 * bench->model.specialization.visibility_column, REFERENCE_VISIBILITY);
        update_code(bench, d_weights);
    }
    float *before = step_bench_read(bench, bench->field.params);
    struct vw_push_update push = {.adam = vw_adam_of(&bench->model.specialization)};
    step_bench_write(bench, bench->field.step_state, &(struct vw_step_state){.nonfinite = 1, .view = bench->view});
    step_bench_dispatch(bench, step_bench_effect_pass(bench, "update_visibility"), &push, sizeof push, 1);
    float *after = step_bench_read(bench, bench->field.params);
    check_same_bits(bench->where, "params of a skipped step", after, before, bench->model.param_bytes);
    step_bench_write(bench, bench->field.step_state, &(struct vw_step_state){0});
    step_bench_write_params(bench);
}
