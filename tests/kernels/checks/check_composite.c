// composite_rays and backward_rays against the reference, on hand-made samples: nothing, thin air, fog,
// walls, and the density's maximum.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "kernels/checks/check.h"

enum { SAMPLES_MAX = 64 };
static const double SKY_TOLERANCE = 2e-6; // relative, from the device's exp
// Tolerance of every sample's share of the colour: the device's exp near an optical thickness of 0.03 and its
// roundings.
static const double SHARE_TOLERANCE = 6e-6;
// Light that passes more than an optical thickness of 87 is cut to 1e-38.
static const double LEAST_LIGHT = 1e-36;
static const uint64_t STEP = 1;

struct inputs {
    uint32_t ray_count, samples;
    struct vw_ray *rays;
    vw_float4 *field;
};

static float unit(struct test_random *random) { return 0.5f + 0.5f * test_random_next(random); }

// Selects empty rays before a black target, so that the loss is exactly 0 on black.
static bool is_empty(uint32_t ray) { return ray % 13 == 5; }

// Draws a density: whole rays of nothing, thin air, fog or wall, and every third ray of all of them.
static float ordinary_density(uint32_t ray, struct test_random *random) {
    static const float densities[] = {1.0f, 30.0f, 0.01f, 1e-4f, 1e-6f, 1e-9f, 0.0f, 1e3f, 3e6f};
    if (ray % 3 == 0) return densities[(uint32_t)(9.0f * unit(random)) % 9];
    return densities[ray % 9] * unit(random);
}

// Colours and densities as the field can make them: not below 0, colours up to 1.
static vw_float4 draw_sample(enum input_kind kind, uint32_t ray, struct test_random *random) {
    vw_float4 sample = {unit(random), unit(random), unit(random), ordinary_density(ray, random)};
    if (kind != INPUT_ORDINARY) sample.w = fminf(fabsf(input_draw(kind, random)), (float)reference_density_max);
    if (is_empty(ray)) sample.w = 0.0f;
    if (kind == INPUT_ORDINARY || kind == INPUT_LARGE || kind == INPUT_SATURATING || ray % 2) return sample;
    return (vw_float4){fabsf(input_draw(kind, random)), input_draw(kind, random) * 0.0f,
                       fabsf(input_draw(kind, random)), sample.w};
}

// Draws a direction along an axis, or anywhere.
static vw_float4 draw_direction(uint32_t ray, struct test_random *random) {
    float axis[3] = {test_random_next(random), test_random_next(random), test_random_next(random)}, length = 0.0f;
    if (ray % 4 == 1)
        for (uint32_t i = 0; i < 3; i++) axis[i] = ray / 4 % 3 == i ? (ray / 12 % 2 ? -1.0f : 1.0f) : 0.0f;
    for (int i = 0; i < 3; i++) length += axis[i] * axis[i];
    length = sqrtf(length);
    return (vw_float4){axis[0] / length, axis[1] / length, axis[2] / length, 0.0f};
}

static struct inputs make_inputs(const struct step_bench *bench, enum input_kind kind, uint32_t ray_count) {
    static const float strides[] = {0.03f, 0.005f, 1e-7f, 0.0f, 0.05f};
    static const float distances[][2] = {
        {0.1f, 1e3f}, {0.4f, 0.8f}, {2.0f, 2.000001f}, {0.5f, 0.5f}, {0.06f, 1e6f}}; // unbounded: near and far
    struct test_random random = {.seed = bench->config.seed};
    struct inputs in = {.ray_count = ray_count, .samples = bench->config.samples};
    in.rays = test_allocate(in.ray_count, sizeof *in.rays);
    in.field = test_allocate((size_t)in.ray_count * in.samples, sizeof *in.field);
    assert_true(in.samples <= SAMPLES_MAX);
    for (uint32_t ray = 0; ray < in.ray_count; ray++) {
        in.rays[ray].direction_stride = draw_direction(ray, &random);
        in.rays[ray].direction_stride.w = strides[ray % 5];
        if (bench->model.specialization.effect_unbounded) {
            in.rays[ray].origin_near.w = distances[ray % 5][0];
            in.rays[ray].direction_stride.w = distances[ray % 5][1];
        }
        in.rays[ray].target_weight = (vw_float4){unit(&random), unit(&random), unit(&random), ray % 11 != 3};
        if (is_empty(ray)) in.rays[ray].target_weight = (vw_float4){.w = 1.0f};
        for (uint32_t i = 0; i < in.samples; i++) in.field[ray * in.samples + i] = draw_sample(kind, ray, &random);
    }
    return in;
}

// A ray by the reference, with what the device may be off.
struct reference {
    struct reference_point points[SAMPLES_MAX];
    double tau_before[SAMPLES_MAX], weight[SAMPLES_MAX],
        share_error[SAMPLES_MAX]; // share_error: relative, of the weight
    double backdrop[3], backdrop_error[3], colour[3], colour_error[3], left, left_error;
};

// Finds the backdrop and its error. Colours of the sky are good to the device's exp and, relative to the terms of their
// logit, its roundings; others are exact.
static void stand_behind(const struct step_bench *bench, const struct inputs *in, uint32_t ray, bool training,
                         struct reference *reference) {
    struct vw_specialization s = bench->model.specialization;
    double sky[VW_SKY_COLUMNS][3] = {{0.0}};
    struct reference_ray line = reference_ray_of(&in->rays[ray]);
    s.training = training;
    reference_sky_read(&bench->model, bench->params, sky);
    reference_backdrop(&s, sky, line.direction, ray, vw_model_key_of_step(&bench->model, STEP), reference->backdrop);
    for (int c = 0; c < 3; c++) {
        double terms = 0.0;
        for (int k = 0; k < VW_SKY_COLUMNS; k++) terms += fabs(sky[k][c]);
        reference->backdrop_error[c] = reference->backdrop[c] * (SKY_TOLERANCE + 16.0 * FLOAT_ROUNDING * terms);
    }
}

// Composites a ray. The thickness so far is a sum of floats, so that the light that passes it is off by as many
// roundings of it, relatively.
static void composite(const struct step_bench *bench, const struct inputs *in, uint32_t ray, bool training,
                      struct reference *reference) {
    double tau = 0.0;
    struct reference_ray line = reference_ray_of(&in->rays[ray]);
    stand_behind(bench, in, ray, training, reference);
    for (int c = 0; c < 3; c++) reference->colour_error[c] = 0.0;
    for (uint32_t i = 0; i < in->samples; i++) {
        const vw_float4 *sample = &in->field[ray * in->samples + i];
        struct reference_point *point = &reference->points[i];
        *point = (struct reference_point){{sample->x, sample->y, sample->z},
                                          sample->w,
                                          reference_stratum_length(&bench->model.specialization, &line, i)};
        reference->tau_before[i] = tau;
        reference->weight[i] = exp(-tau) * -expm1(-point->density * point->length);
        reference->share_error[i] = SHARE_TOLERANCE + (i + 2.0) * FLOAT_ROUNDING * tau;
        tau += point->density * point->length;
        for (int c = 0; c < 3; c++)
            reference->colour_error[c] +=
                reference->weight[i] * reference->share_error[i] * point->rgb[c] + 3.0 * FLOAT_LEAST;
    }
    reference->left = reference_composite(reference->points, in->samples, reference->backdrop, reference->colour);
    reference->left_error = reference->left * (SHARE_TOLERANCE + in->samples * FLOAT_ROUNDING * tau) + LEAST_LIGHT;
    for (int c = 0; c < 3; c++)
        reference->colour_error[c] += reference->left_error * reference->backdrop[c] +
                                      reference->left * reference->backdrop_error[c] +
                                      in->samples * (FLOAT_ROUNDING * reference->colour[c] + LEAST_LIGHT);
}

// ---- composite_rays -------------------------------------------------------------------------------------------------

void check_composite_rays(struct step_bench *bench, enum input_kind kind) {
    struct vw_evaluator *evaluator = step_bench_evaluator(bench);
    struct inputs in = make_inputs(bench, kind, evaluator->ray_count);
    struct vw_push_samples push = {.ray_count = evaluator->ray_count};
    test_write(evaluator->rays, in.rays);
    test_write(vw_volume_evaluation_of(evaluator)->samples, in.field);
    step_bench_dispatch(bench, vw_volume_evaluation_of(evaluator)->composite, &push, sizeof push,
                        step_bench_lanes(bench, push.ray_count));
    vw_float4 *colours = test_read(evaluator->colours);
    for (uint32_t ray = 0; ray < in.ray_count; ray++) {
        struct reference reference;
        const double device[3] = {colours[ray].x, colours[ray].y, colours[ray].z};
        composite(bench, &in, ray, false, &reference);
        check_value(bench->where, "transmittance", ray, colours[ray].w, reference.left, reference.left_error);
        for (int c = 0; c < 3; c++)
            check_value(bench->where, "colour", ray, device[c], reference.colour[c], reference.colour_error[c]);
    }
}

// ---- backward_rays --------------------------------------------------------------------------------------------------

struct reference_loss {
    double loss, loss_error, d_visible, d_colour[3], d_colour_error[3];
};

// Returns how much the slope of a loss changes per error.
static double curvature(const struct vw_specialization *s) {
    return s->loss == LOSS_L2 ? 2.0 : s->loss == LOSS_HUBER ? 1.0 / s->huber_length : 0.0;
}

// Returns how visible a ray is: hidden, seen, and all between.
static float visible_of(uint32_t ray) { return ray % 5 < 2 ? (float)(ray % 5) : 0.3f + 0.1f * (float)(ray % 7); }

static bool weighs_rays(const struct step_bench *bench) {
    return bench->model.specialization.effect_visibility || bench->model.specialization.effect_uncertainty;
}

// Leaves a part of the ray out of the loss, its gradients and their errors, as visibility and uncertainty do.
static void leave_out(const struct step_bench *bench, uint32_t ray, double weight, struct reference_loss *taken) {
    if (!weighs_rays(bench)) return;
    double visible = visible_of(ray), hidden = 1.0 - visible, certain = fmax(visible, 1e-30),
           size_weight = weight * reference_size_weight(&bench->model.specialization, STEP),
           certain_loss = weight * reference_certain_loss(&bench->model.specialization, STEP);
    bool by_doubt = bench->model.specialization.effect_uncertainty;
    taken->d_visible = taken->loss - (by_doubt ? certain_loss / certain : 2.0 * size_weight * hidden);
    taken->loss = visible * taken->loss + (by_doubt ? -certain_loss * log(certain) : size_weight * hidden * hidden);
    taken->loss_error += by_doubt ? 8.0 * FLOAT_ROUNDING * certain_loss * (1.0 - log(certain)) : 0.0;
    for (int c = 0; c < 3; c++) {
        taken->d_colour[c] *= visible;
        taken->d_colour_error[c] = visible * taken->d_colour_error[c] + FLOAT_ROUNDING * fabs(taken->d_colour[c]);
    }
}

static struct reference_loss take_loss(const struct step_bench *bench, const struct inputs *in, uint32_t index,
                                       const struct reference *reference) {
    struct reference_ray ray = reference_ray_of(&in->rays[index]);
    struct reference_loss taken = {0};
    double share = ray.weight / 3.0;
    for (int c = 0; c < 3; c++) {
        double error = reference->colour[c] - ray.target[c], slope,
               error_error = reference->colour_error[c] + FLOAT_ROUNDING;
        if (bench->config.loss == VW_LOSS_L1 && error != 0.0 && ray.weight > 0.0 && fabs(error) < error_error &&
            ray.target[c] > 0.0)
            fail_msg("%s: ray %u stands at the kink of the loss; choose another seed", bench->where, index);
        taken.loss += share * reference_loss(&bench->model.specialization, error, &slope);
        taken.loss_error += share * error_error * 2.0 + 4.0 * FLOAT_ROUNDING;
        taken.d_colour[c] = share * slope;
        taken.d_colour_error[c] =
            share * (curvature(&bench->model.specialization) * error_error + 4.0 * FLOAT_ROUNDING);
    }
    leave_out(bench, index, ray.weight, &taken);
    return taken;
}

static void check_sample(const struct step_bench *bench, const struct reference *reference,
                         const struct reference_loss *taken, uint32_t i, const struct reference_d_point *expected,
                         const vw_float4 *device, uint64_t index) {
    const double rgb[3] = {device->x, device->y, device->z};
    double tau = reference->points[i].density * reference->points[i].length,
           light = exp(-reference->tau_before[i] - tau) + LEAST_LIGHT, raw_error = FLOAT_LEAST,
           least_tau = reference->points[i].length * FLOAT_LEAST; // a density below it may be 0
    for (int c = 0; c < 3; c++) {
        double slope = fabs(taken->d_colour[c]), slope_error = taken->d_colour_error[c];
        check_value(bench->where, "d_rgb", index, rgb[c], expected->rgb[c],
                    reference->weight[i] * (slope_error + (reference->share_error[i] + 3.0 * FLOAT_ROUNDING) * slope) +
                        slope * (LEAST_LIGHT + least_tau) + 3.0 * FLOAT_LEAST);
        // Both the sample and what lies beyond it are seen through `light`; their difference may be much smaller.
        double seen = light * (reference->points[i].rgb[c] + 1.0);
        raw_error += slope * seen * least_tau;
        raw_error += tau * slope * LEAST_LIGHT;
        raw_error += tau * seen *
                     (slope_error +
                      slope * (2.0 * SHARE_TOLERANCE + 64.0 * FLOAT_ROUNDING * (1.0 + reference->tau_before[i] + tau)));
    }
    check_value(bench->where, "d_raw", index, device->w, expected->raw, raw_error);
}

// Checks the gradient by the sky's logit: rgb (1 - rgb) is as far off as rgb, relative to what it would be without the
// second factor.
static void check_d_logit(const struct step_bench *bench, uint32_t ray, const struct reference *reference,
                          const struct reference_loss *taken, const vw_float4 *device) {
    const double found[3] = {device->x, device->y, device->z};
    double expected[3];
    reference_sky_d_logit(reference->backdrop, reference->left, taken->d_colour, expected);
    for (int c = 0; c < 3; c++) {
        double slope = fabs(taken->d_colour[c]) + taken->d_colour_error[c], colour = reference->backdrop[c];
        double error =
            slope * (reference->left_error * colour * (1.0 - colour) +
                     (reference->left + reference->left_error) * (reference->backdrop_error[c] + FLOAT_ROUNDING)) +
            taken->d_colour_error[c] * reference->left * colour * (1.0 - colour);
        check_value(bench->where, "gradient by the sky's logit", 3 * ray + (uint32_t)c, found[c], expected[c],
                    error + FLOAT_LEAST);
    }
    check_value(bench->where, "padding of the sky's logit", ray, device->w, 0.0, 0.0);
}

// Checks what is kept of a ray for fit_photo: its weight is that of the pixel, times how visible it is.
static void check_rendered(const struct step_bench *bench, const struct inputs *in, const struct reference *reference,
                           uint32_t ray, const vw_float4 *device) {
    for (int c = 0; c < 3; c++)
        check_value(bench->where, "rendered", ray, (&device->x)[c], reference->colour[c], reference->colour_error[c]);
    double weight = in->rays[ray].target_weight.w * (weighs_rays(bench) ? visible_of(ray) : 1.0);
    check_value(bench->where, "weight of what is rendered", ray, device->w, weight, 3.0 * FLOAT_ROUNDING * weight);
}

// Checks a ray. `d_sky`, `rendered` and `visibility` are NULL without their effects.
static void check_ray(const struct step_bench *bench, const struct inputs *in, uint32_t ray, float device_loss,
                      const vw_float4 *d_field, const vw_float4 *d_sky, const vw_float4 *rendered,
                      const float *visibility) {
    struct reference reference;
    struct reference_d_point expected[SAMPLES_MAX];
    composite(bench, in, ray, true, &reference);
    struct reference_loss taken = take_loss(bench, in, ray, &reference);
    if (rendered) check_rendered(bench, in, &reference, ray, &rendered[ray]);
    if (visibility)
        check_value(bench->where, "gradient by how visible", ray, visibility[2 * ray + 1], taken.d_visible,
                    taken.loss_error + 4.0 * FLOAT_ROUNDING * fabs(taken.d_visible));
    check_value(bench->where, "ray_loss", ray, device_loss, taken.loss, taken.loss_error);
    reference_composite_gradient(reference.points, in->samples, reference.backdrop, taken.d_colour, expected);
    if (d_sky) check_d_logit(bench, ray, &reference, &taken, &d_sky[ray]);
    for (uint32_t i = 0; i < in->samples; i++) {
        uint64_t index = (uint64_t)ray * in->samples + i;
        check_sample(bench, &reference, &taken, i, &expected[i], &d_field[index], index);
    }
}

void check_backward_rays(struct step_bench *bench, enum input_kind kind) {
    struct inputs in = make_inputs(bench, kind, bench->step.padded_rays);
    struct vw_push_samples push = step_bench_push(bench, STEP);
    test_write(bench->step.ray_buffer, in.rays);
    test_write(bench->volume->samples, in.field);
    step_bench_write_params(bench);
    test_write(bench->field.step_state, &(struct vw_step_state){.view = bench->view});
    float *visibility = bench->step.effect_buffers[VW_SLOT_VISIBILITY]
                            ? test_read(bench->step.effect_buffers[VW_SLOT_VISIBILITY])
                            : NULL;
    for (uint32_t ray = 0; visibility && ray < in.ray_count; ray++) visibility[2 * ray] = visible_of(ray);
    if (visibility) test_write(bench->step.effect_buffers[VW_SLOT_VISIBILITY], visibility);
    step_bench_dispatch(bench, bench->volume->gradient.backward_rays, &push, sizeof push,
                        step_bench_lanes(bench, push.ray_count));
    visibility = bench->step.effect_buffers[VW_SLOT_VISIBILITY]
                     ? test_read(bench->step.effect_buffers[VW_SLOT_VISIBILITY])
                     : NULL;
    float *losses = test_read(bench->step.ray_loss);
    vw_float4 *d_field = test_read(bench->volume->d_samples);
    vw_float4 *d_sky =
        bench->step.effect_buffers[VW_SLOT_D_SKY] ? test_read(bench->step.effect_buffers[VW_SLOT_D_SKY]) : NULL;
    vw_float4 *rendered =
        bench->step.effect_buffers[VW_SLOT_RENDERED] ? test_read(bench->step.effect_buffers[VW_SLOT_RENDERED]) : NULL;
    assert_int_equal(rendered != NULL, bench->model.specialization.effect_appearance == APPEARANCE_FITTED);
    for (uint32_t ray = 0; ray < in.ray_count; ray++)
        check_ray(bench, &in, ray, losses[ray], d_field, d_sky, rendered, visibility);
}
