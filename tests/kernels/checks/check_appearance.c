// The passes of photos with numbers of their own against the reference: fit_views, mix_code, update_appearance and
// update_code.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "gpu/compute.h"
#include "kernels/checks/check.h"

static const double STEP_TOLERANCE = 5e-4; // relative to a step's length: see check_optimizer.c
static const double MOMENT_TOLERANCE = 1e-6;
enum {
    UPDATES = 3,
    AFFINE = 8,
    MOMENT_WORDS = sizeof(struct vw_appearance_moments) / 4,
    CODE_WORDS = sizeof(struct vw_code_moments) / 4
};

static uint32_t count_of(const struct vw_param_range *range) { return (uint32_t)(range->size_bytes / sizeof(float)); }
static const float *values_of(const struct vw_param_range *range, const float *params) {
    return params + range->offset_bytes / sizeof(float);
}

// Returns whether the effect is off, and checks that it then has nothing of its own.
static bool is_off(const struct vw_pass *pass, const struct vw_param_range *range, const struct vw_buffer *buffer) {
    if (pass) return false;
    assert_int_equal(range->size_bytes, 0);
    assert_null(buffer);
    return true;
}

// ---- fit_views ------------------------------------------------------------------------------------------------------

// The worst that rounding does to a fit: of sums of products of numbers measured from means that are themselves
// rounded.
static const double FIT_ROUNDINGS = 200.0;

static void check_channel(const char *where, uint32_t view, const double *rendered, const double *target,
                          uint32_t count, float gain, float bias) {
    double expected_gain, expected_bias, size = 0.0, missing_size = 0.0, mean = 0.0, squares = reference_fit_ridge;
    reference_fit_channel(rendered, target, count, &expected_gain, &expected_bias);
    for (uint32_t i = 0; i < count; i++) {
        size = fmax(size, fabs(rendered[i]));
        missing_size = fmax(missing_size, fabs(target[i]) + fabs(rendered[i]));
        mean += rendered[i] / count;
    }
    for (uint32_t i = 0; i < count; i++) squares += (rendered[i] - mean) * (rendered[i] - mean);
    double rounding = FIT_ROUNDINGS * FLOAT_ROUNDING,
           gain_error = rounding * count * size * (missing_size + fabs(expected_gain) * size) / squares +
                        rounding * fabs(expected_gain),
           bias_error = rounding * (missing_size + fabs(expected_gain) * size) + gain_error * fabs(mean) + FLOAT_LEAST;
    check_value(where, "fitted gain", view, gain, expected_gain, gain_error + FLOAT_LEAST);
    check_value(where, "fitted bias", view, bias, expected_bias, bias_error);
}

static void check_fits(const char *where, const struct view_reduction *r, const struct vw_appearance *fits) {
    static double rendered[REDUCED_RAYS], target[REDUCED_RAYS];
    for (uint32_t view = 0; view < REDUCED_VIEWS; view++)
        for (int c = 0; c < 3; c++) {
            uint32_t count = 0;
            for (uint32_t i = reduced_ranges[view].first; i < reduced_ranges[view].first + reduced_ranges[view].count;
                 i++) {
                if (r->ray_data[i].target_weight.w == 0.0f) continue;
                rendered[count] = (&r->colour_data[i].x)[c];
                target[count++] = (&r->ray_data[i].target_weight.x)[c];
            }
            check_channel(where, view, rendered, target, count, (&fits[view].gain.x)[c], (&fits[view].bias.x)[c]);
        }
}

static void check_fitted_errors(const char *where, struct view_reduction *r, const struct vw_appearance *fits) {
    vw_float4 sums[REDUCED_VIEWS];
    reduction_run(r, sums);
    for (uint32_t view = 0; view < REDUCED_VIEWS; view++) {
        double squared = 0.0, absolute = 0.0, squared_error = 0.0, absolute_error = 0.0;
        for (uint32_t i = reduced_ranges[view].first; i < reduced_ranges[view].first + reduced_ranges[view].count; i++)
            for (int c = 0; c < 3 && r->ray_data[i].target_weight.w != 0.0f; c++) {
                double seen = (1.0 + (&fits[view].gain.x)[c]) * (&r->colour_data[i].x)[c],
                       bias = (&fits[view].bias.x)[c], target = (&r->ray_data[i].target_weight.x)[c],
                       error = seen + bias - target,
                       rounding = 4.0 * FLOAT_ROUNDING * (fabs(seen) + fabs(bias) + fabs(target)) + FLOAT_LEAST;
                squared += error * error;
                absolute += fabs(error);
                squared_error += (2.0 * fabs(error) + rounding) * rounding + FLOAT_LEAST;
                absolute_error += rounding;
            }
        check_value(where, "squared error after the fit", view, (double)sums[view].x + sums[view].y, squared,
                    squared_error);
        check_value(where, "absolute error after the fit", view, (double)sums[view].z + sums[view].w, absolute,
                    absolute_error);
    }
}

void check_fit_views(struct step_bench *bench, enum input_kind kind) {
    struct vw_appearance fits[REDUCED_VIEWS];
    struct vw_push_reduce push = {.count = REDUCED_VIEWS};
    struct view_reduction *r = reduction_open(bench->gpu, true);
    reduction_fill(r, kind, bench->config.seed);
    step_bench_write(bench, r->rays, r->ray_data);
    step_bench_write(bench, r->colours, r->colour_data);
    step_bench_dispatch(bench, r->fit_pass, &push, sizeof push, 64 * REDUCED_VIEWS);
    assert_int_equal(vw_buffer_read(r->fits, 0, fits, sizeof fits), VW_OK);
    check_fits(bench->where, r, fits);
    check_fitted_errors(bench->where, r, fits);
}

// ---- mix_code -------------------------------------------------------------------------------------------------------

// Puts numbers of the kind into a range of the params on the device.
static float *write_range(struct step_bench *bench, const struct vw_param_range *range, enum input_kind kind,
                          struct test_random *random) {
    float *params = step_bench_read(bench, bench->field.params);
    input_fill(kind, random, params + range->offset_bytes / sizeof *params, count_of(range));
    step_bench_write(bench, bench->field.params, params);
    return params;
}

void check_mix_code(struct step_bench *bench, enum input_kind kind) {
    const struct vw_model *model = &bench->model;
    if (is_off(step_bench_effect_pass(bench, "mix_code"), &model->ranges[VW_SLOT_CODES],
               bench->step.effect_buffers[VW_SLOT_CODE_SHIFT]))
        return;
    struct test_random random = {.seed = bench->config.seed};
    step_bench_write_params(bench);
    float *params = write_range(bench, &model->ranges[VW_SLOT_CODES], kind, &random);
    step_bench_write(bench, bench->field.step_state, &(struct vw_step_state){.view = bench->view});
    step_bench_dispatch(bench, step_bench_effect_pass(bench, "mix_code"), NULL, 0, bench->config.width);
    float *shift = step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_CODE_SHIFT]);
    const float *weights = values_of(&model->ranges[VW_SLOT_CODE_WEIGHTS], params),
                *code = values_of(&model->ranges[VW_SLOT_CODES], params) + REFERENCE_CODE * bench->view;
    for (uint32_t i = 0; i < bench->config.width; i++) {
        double sum = 0.0, magnitude = 0.0;
        for (uint32_t k = 0; k < REFERENCE_CODE; k++) {
            sum += (double)weights[i * REFERENCE_CODE + k] * code[k];
            magnitude += fabs((double)weights[i * REFERENCE_CODE + k] * code[k]) + FLOAT_LEAST / FLOAT_ROUNDING;
        }
        check_value(bench->where, "code shift", i, shift[i], sum, (REFERENCE_CODE + 1.0) * FLOAT_ROUNDING * magnitude);
    }
    step_bench_write_params(bench);
}

// ---- Updates --------------------------------------------------------------------------------------------------------

// One number as it was and as it is.
struct number {
    const char *name;
    uint64_t index, visits;
    double gradient, gradient_error, rate; // gradient of the mean loss; rate: times the learning rate
    float value, moment1, moment2, value_after, moment1_after, moment2_after;
};

static void check_number(const struct step_bench *bench, const struct number *it) {
    const struct vw_specialization *s = &bench->model.specialization;
    double moment1 = it->moment1, moment2 = it->moment2, epsilon = (double)s->gradient_quantum * s->inverse_rays;
    double moved = it->rate * reference_adam(s, it->gradient, it->visits, &moment1, &moment2),
           expected = it->value - moved;
    // A gradient that is off by so much moves the number by at most so much of a step.
    double direction_error = it->gradient_error / (sqrt(moment2 / (1.0 - pow(s->beta2, (double)it->visits))) + epsilon);
    if (s->optimizer == OPTIMIZER_SGD) direction_error = it->gradient_error;
    double tolerance = STEP_TOLERANCE * fabs(moved) +
                       4.0 * it->rate * s->learning_rate * (direction_error + FLOAT_LEAST / epsilon) +
                       2.0 * FLOAT_ROUNDING * fabs(expected);
    check_value(bench->where, it->name, it->index, it->value_after, expected, tolerance);
    if (s->optimizer == OPTIMIZER_SGD) return;
    check_value(bench->where, "second moment", it->index, it->moment2_after, moment2,
                MOMENT_TOLERANCE * moment2 + 4.0 * it->gradient_error * (fabs(it->gradient) + it->gradient_error) +
                    2.0 * FLOAT_LEAST);
    if (s->momentum)
        check_value(bench->where, "first moment", it->index, it->moment1_after, moment1,
                    MOMENT_TOLERANCE * (fabs(it->moment1) + fabs(it->gradient)) + it->gradient_error +
                        2.0 * FLOAT_LEAST);
}

static void check_untouched(const struct step_bench *bench, const char *what, const void *after, const void *before,
                            uint32_t photos, size_t photo_bytes) {
    for (uint32_t view = 0; view < photos; view++)
        if (view != bench->view)
            check_same_bits(bench->where, what, (const char *)after + view * photo_bytes,
                            (const char *)before + view * photo_bytes, photo_bytes);
}

// ---- update_appearance ----------------------------------------------------------------------------------------------

static void check_photo(const struct step_bench *bench, const float *shares, const float *before, const float *after,
                        const float *moments, const float *moments_after) {
    const float *own = moments + MOMENT_WORDS * bench->view, *own_after = moments_after + MOMENT_WORDS * bench->view;
    uint32_t visits, visits_after;
    memcpy(&visits, own + 16, 4);
    memcpy(&visits_after, own_after + 16, 4);
    check_value(bench->where, "visits", bench->view, visits_after, visits < INT32_MAX ? visits + 1.0 : INT32_MAX, 0.0);
    for (uint32_t i = 0; i < AFFINE; i++) {
        double sum = 0.0, magnitude = 0.0, inverse_rays = bench->model.specialization.inverse_rays,
               value = before[AFFINE * bench->view + i];
        for (uint32_t ray = 0; ray < bench->step.padded_rays; ray++) {
            sum += shares[AFFINE * ray + i];
            magnitude += fabs((double)shares[AFFINE * ray + i]);
        }
        uint32_t at = i / 4 * 8 + i % 4; // gain1, gain2, bias1, bias2
        check_number(
            bench, &(struct number){.name = i < 4 ? "gain" : "bias",
                                    .index = i,
                                    .visits = visits_after,
                                    .gradient = sum * inverse_rays + reference_photo_ridge * value,
                                    .gradient_error = (bench->step.padded_rays / 64.0 + 68.0) * FLOAT_ROUNDING *
                                                      (magnitude * inverse_rays + reference_photo_ridge * fabs(value)),
                                    .rate = reference_photo_rate(visits_after),
                                    .value = (float)value,
                                    .moment1 = own[at],
                                    .moment2 = own[at + 4],
                                    .value_after = after[AFFINE * bench->view + i],
                                    .moment1_after = own_after[at],
                                    .moment2_after = own_after[at + 4]});
    }
}

static uint32_t visits_before(enum input_kind kind) {
    return kind == INPUT_SATURATING ? INT32_MAX - 1 : kind == INPUT_LARGE ? 1000000 : 0;
}

static void write_visits(struct step_bench *bench, struct vw_buffer *moments, uint32_t words, uint32_t visits) {
    uint32_t *zeros = test_allocate(vw_buffer_size_bytes(moments), 1);
    for (uint32_t view = 0; view < reference_photo_count(&bench->model); view++)
        zeros[words * view + words - 1] = visits;
    step_bench_write(bench, moments, zeros);
}

static void update_photo(struct step_bench *bench, const float *shares) {
    const struct vw_param_range *range = &bench->model.ranges[VW_SLOT_APPEARANCE];
    struct vw_push_update push = {.count = bench->step.padded_rays};
    float *before = step_bench_read(bench, bench->field.params),
          *moments = step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_APPEARANCE_MOMENTS]);
    step_bench_write(bench, bench->step.effect_buffers[VW_SLOT_D_APPEARANCE], shares);
    step_bench_write(bench, bench->field.step_state, &(struct vw_step_state){.view = bench->view});
    step_bench_dispatch(bench, step_bench_effect_pass(bench, "update_appearance"), &push, sizeof push, 1);
    float *after = step_bench_read(bench, bench->field.params),
          *moments_after = step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_APPEARANCE_MOMENTS]);
    uint32_t photos = reference_photo_count(&bench->model);
    check_photo(bench, shares, values_of(range, before), values_of(range, after), moments, moments_after);
    check_same_bits(bench->where, "grid and weights", after, before, range->offset_bytes);
    check_untouched(bench, "other photos", values_of(range, after), values_of(range, before), photos,
                    sizeof(struct vw_appearance));
    check_untouched(bench, "other photos' moments", moments_after, moments, photos,
                    sizeof(struct vw_appearance_moments));
}

void check_update_appearance(struct step_bench *bench, enum input_kind kind) {
    if (is_off(step_bench_effect_pass(bench, "update_appearance"), &bench->model.ranges[VW_SLOT_APPEARANCE],
               bench->step.effect_buffers[VW_SLOT_APPEARANCE_MOMENTS]))
        return;
    struct test_random random = {.seed = bench->config.seed};
    float *shares = test_allocate(AFFINE * (size_t)bench->step.padded_rays, sizeof *shares);
    step_bench_write_params(bench);
    write_visits(bench, bench->step.effect_buffers[VW_SLOT_APPEARANCE_MOMENTS], MOMENT_WORDS, visits_before(kind));
    for (int i = 0; i < UPDATES; i++) {
        for (uint32_t k = 0; k < AFFINE * bench->step.padded_rays; k++)
            shares[k] = k % 4 == 3 ? 0.0f : input_draw(kind, &random);
        update_photo(bench, shares);
    }
    // A value that is not finite moves nothing, and the flag says so.
    float *before = step_bench_read(bench, bench->field.params);
    shares[AFFINE + 1] = NAN;
    struct vw_push_update push = {.count = bench->step.padded_rays};
    step_bench_write(bench, bench->step.effect_buffers[VW_SLOT_D_APPEARANCE], shares);
    step_bench_dispatch(bench, step_bench_effect_pass(bench, "update_appearance"), &push, sizeof push, 1);
    float *after = step_bench_read(bench, bench->field.params);
    struct vw_step_state *flags = step_bench_read(bench, bench->field.step_state);
    check_same_bits(bench->where, "params of a skipped step", after, before, bench->model.param_bytes);
    assert_true(flags->nonfinite);
    step_bench_write(bench, bench->field.step_state, &(struct vw_step_state){0});
    step_bench_write_params(bench);
}

// ---- update_code ----------------------------------------------------------------------------------------------------

// All the pass reads and writes.
struct code_state {
    float *params, *weight_moments, *moments;
};

static struct code_state read_code(struct step_bench *bench) {
    return (struct code_state){step_bench_read(bench, bench->field.params),
                               step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_CODE_WEIGHT_MOMENTS]),
                               step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_CODE_MOMENTS])};
}

static void check_code_weights(const struct step_bench *bench, const double *d_shift, uint32_t step,
                               const struct code_state *before, const struct code_state *after) {
    const struct vw_param_range *range = &bench->model.ranges[VW_SLOT_CODE_WEIGHTS];
    const float *code = values_of(&bench->model.ranges[VW_SLOT_CODES], before->params) + REFERENCE_CODE * bench->view;
    uint32_t count = count_of(range);
    for (uint32_t i = 0; i < count; i++) {
        double gradient = d_shift[i / REFERENCE_CODE] * code[i % REFERENCE_CODE];
        check_number(bench, &(struct number){.name = "code weight",
                                             .index = i,
                                             .visits = step,
                                             .gradient = gradient,
                                             .gradient_error = 3.0 * FLOAT_ROUNDING * fabs(gradient) + FLOAT_LEAST,
                                             .rate = 1.0,
                                             .value = values_of(range, before->params)[i],
                                             .moment1 = before->weight_moments[i],
                                             .moment2 = before->weight_moments[count + i],
                                             .value_after = values_of(range, after->params)[i],
                                             .moment1_after = after->weight_moments[i],
                                             .moment2_after = after->weight_moments[count + i]});
    }
}

static void check_code(const struct step_bench *bench, const double *d_shift, const struct code_state *before,
                       const struct code_state *after) {
    const float *own = before->moments + CODE_WORDS * bench->view,
                *own_after = after->moments + CODE_WORDS * bench->view;
    const float *weights = values_of(&bench->model.ranges[VW_SLOT_CODE_WEIGHTS], before->params);
    uint32_t visits, visits_after;
    memcpy(&visits, own + 2 * REFERENCE_CODE, 4);
    memcpy(&visits_after, own_after + 2 * REFERENCE_CODE, 4);
    check_value(bench->where, "visits of the code", bench->view, visits_after,
                visits < INT32_MAX ? visits + 1.0 : INT32_MAX, 0.0);
    for (uint32_t k = 0; k < REFERENCE_CODE; k++) {
        uint32_t at = REFERENCE_CODE * bench->view + k;
        double value = values_of(&bench->model.ranges[VW_SLOT_CODES], before->params)[at],
               gradient = reference_photo_ridge * value, magnitude = fabs(gradient);
        for (uint32_t i = 0; i < bench->config.width; i++) {
            gradient += d_shift[i] * weights[i * REFERENCE_CODE + k];
            magnitude += fabs(d_shift[i] * weights[i * REFERENCE_CODE + k]);
        }
        check_number(bench,
                     &(struct number){.name = "code",
                                      .index = k,
                                      .visits = visits_after,
                                      .gradient = gradient,
                                      .gradient_error = 70.0 * FLOAT_ROUNDING * magnitude + 64.0 * FLOAT_LEAST,
                                      .rate = reference_photo_rate(visits_after),
                                      .value = (float)value,
                                      .moment1 = own[k],
                                      .moment2 = own[REFERENCE_CODE + k],
                                      .value_after = values_of(&bench->model.ranges[VW_SLOT_CODES], after->params)[at],
                                      .moment1_after = own_after[k],
                                      .moment2_after = own_after[REFERENCE_CODE + k]});
    }
}

static void update_code(struct step_bench *bench, const float *d_weights, uint32_t step) {
    const struct vw_param_range *codes = &bench->model.ranges[VW_SLOT_CODES];
    struct vw_push_update push = {.step_low = step};
    double d_shift[REFERENCE_WIDTH_MAX];
    for (uint32_t i = 0; i < bench->config.width; i++)
        d_shift[i] = (double)d_weights[reference_block_index(&bench->model.specialization, 2, i, 0)] *
                     bench->model.specialization.inverse_rays;
    struct code_state before = read_code(bench);
    step_bench_write(bench, bench->step.d_weights, d_weights);
    step_bench_write(bench, bench->field.step_state, &(struct vw_step_state){.view = bench->view});
    step_bench_dispatch(bench, step_bench_effect_pass(bench, "update_code"), &push, sizeof push, 1);
    struct code_state after = read_code(bench);
    uint32_t photos = reference_photo_count(&bench->model);
    check_code_weights(bench, d_shift, step, &before, &after);
    check_code(bench, d_shift, &before, &after);
    check_same_bits(bench->where, "what comes before the codes", after.params, before.params,
                    bench->model.ranges[VW_SLOT_CODE_WEIGHTS].offset_bytes);
    check_untouched(bench, "other photos' codes", values_of(codes, after.params), values_of(codes, before.params),
                    photos, 4 * REFERENCE_CODE);
    check_untouched(bench, "other codes' moments", after.moments, before.moments, photos,
                    sizeof(struct vw_code_moments));
}

void check_update_code(struct step_bench *bench, enum input_kind kind) {
    if (is_off(step_bench_effect_pass(bench, "update_code"), &bench->model.ranges[VW_SLOT_CODE_WEIGHTS],
               bench->step.effect_buffers[VW_SLOT_CODE_MOMENTS]))
        return;
    struct test_random random = {.seed = bench->config.seed};
    uint32_t count = 4 * bench->model.weight_columns;
    float *d_weights = test_allocate(vw_buffer_size_bytes(bench->step.d_weights), 1);
    float *zeros = test_allocate(2 * bench->model.ranges[VW_SLOT_CODE_WEIGHTS].size_bytes, 1);
    step_bench_write_params(bench);
    step_bench_write(bench, bench->step.effect_buffers[VW_SLOT_CODE_WEIGHT_MOMENTS], zeros);
    write_visits(bench, bench->step.effect_buffers[VW_SLOT_CODE_MOMENTS], CODE_WORDS, visits_before(kind));
    for (uint32_t i = 1; i <= UPDATES; i++) {
        for (uint32_t k = 0; k < count; k++) d_weights[k] = k % 7 == 3 ? 0.0f : 16.0f * input_draw(kind, &random);
        update_code(bench, d_weights, i);
    }
    struct code_state before = read_code(bench);
    struct vw_push_update push = {.step_low = 9};
    step_bench_write(bench, bench->field.step_state, &(struct vw_step_state){.nonfinite = 1, .view = bench->view});
    step_bench_dispatch(bench, step_bench_effect_pass(bench, "update_code"), &push, sizeof push, 1);
    struct code_state after = read_code(bench);
    check_same_bits(bench->where, "params of a skipped step", after.params, before.params, bench->model.param_bytes);
    step_bench_write(bench, bench->field.step_state, &(struct vw_step_state){0});
    step_bench_write_params(bench);
}
