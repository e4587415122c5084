// composite_rays and backward_rays against the twin, on hand-made samples: nothing, thin air, fog, walls, and the density's maximum.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#include "kernels/check.h"
#include "viewworth/memory.h"

enum { SAMPLES_MAX = 64 };
// Of every sample's share of the colour: the device's exp near an optical thickness of 0.03 and its roundings.
static const double SHARE_TOLERANCE = 6e-6;
// Light that passes more than an optical thickness of 87 is cut to 1e-38.
static const double LEAST_LIGHT = 1e-36;

struct inputs {
    uint32_t ray_count, samples;
    struct vw_ray *rays;
    vw_float4 *field;
};

static float unit(struct test_random *random) { return 0.5f + 0.5f * test_random_next(random); }

// Before a black target, so that the loss is exactly 0 on black.
static bool is_empty(uint32_t ray) { return ray % 13 == 5; }

// Whole rays of nothing, thin air, fog or wall, and every third ray of all of them.
static float ordinary_density(uint32_t ray, struct test_random *random) {
    static const float densities[] = {1.0f, 30.0f, 0.01f, 1e-9f, 0.0f, 1e3f, 3e6f};
    if (ray % 3 == 0) return densities[(uint32_t)(7.0f * unit(random)) % 7];
    return densities[ray % 7] * unit(random);
}

// Colours and densities as the field can make them: not below 0, colours up to 1.
static vw_float4 draw_sample(enum input_kind kind, uint32_t ray, struct test_random *random) {
    vw_float4 sample = {unit(random), unit(random), unit(random), ordinary_density(ray, random)};
    if (kind != INPUT_ORDINARY) sample.w = fminf(fabsf(input_draw(kind, random)), (float)reference_density_max);
    if (is_empty(ray)) sample.w = 0.0f;
    if (kind == INPUT_ORDINARY || kind == INPUT_LARGE || kind == INPUT_SATURATING || ray % 2) return sample;
    return (vw_float4){fabsf(input_draw(kind, random)), input_draw(kind, random) * 0.0f, fabsf(input_draw(kind, random)), sample.w};
}

static struct inputs make_inputs(const struct step_bench *bench, enum input_kind kind, uint32_t ray_count) {
    static const float strides[] = {0.03f, 0.005f, 1e-7f, 0.0f, 0.05f};
    struct test_random random = {.seed = bench->config.seed};
    struct inputs in = {.ray_count = ray_count, .samples = bench->config.samples};
    in.rays = vw_allocate(in.ray_count, sizeof *in.rays);
    in.field = vw_allocate((size_t)in.ray_count * in.samples, sizeof *in.field);
    assert_true(in.samples <= SAMPLES_MAX);
    for (uint32_t ray = 0; ray < in.ray_count; ray++) {
        in.rays[ray].direction_stride.w = strides[ray % 5];
        in.rays[ray].target_weight = (vw_float4){unit(&random), unit(&random), unit(&random), ray % 11 != 3};
        if (is_empty(ray)) in.rays[ray].target_weight = (vw_float4){.w = 1.0f};
        for (uint32_t i = 0; i < in.samples; i++) in.field[ray * in.samples + i] = draw_sample(kind, ray, &random);
    }
    return in;
}

static void free_inputs(struct inputs *in) {
    free(in->rays);
    free(in->field);
}

// A ray by the twin, with what the device may be off.
struct twin {
    struct reference_point points[SAMPLES_MAX];
    double tau_before[SAMPLES_MAX], weight[SAMPLES_MAX], share_error[SAMPLES_MAX]; // share_error: relative, of the weight
    double background[3], stride, colour[3], colour_error[3], left, left_error;
};

// The thickness so far is a sum of floats, so that the light that passes it is off by as many roundings of it, relatively.
static void composite(const struct step_bench *bench, const struct inputs *in, uint32_t ray, struct twin *twin) {
    double tau = 0.0;
    twin->stride = in->rays[ray].direction_stride.w;
    reference_background(&bench->model.specialization, twin->background);
    for (int c = 0; c < 3; c++) twin->colour_error[c] = 0.0;
    for (uint32_t i = 0; i < in->samples; i++) {
        const vw_float4 *sample = &in->field[ray * in->samples + i];
        struct reference_point *point = &twin->points[i];
        *point = (struct reference_point){{sample->x, sample->y, sample->z}, sample->w};
        twin->tau_before[i] = tau;
        twin->weight[i] = exp(-tau) * -expm1(-point->density * twin->stride);
        twin->share_error[i] = SHARE_TOLERANCE + (i + 2.0) * FLOAT_ROUNDING * tau;
        tau += point->density * twin->stride;
        for (int c = 0; c < 3; c++) twin->colour_error[c] += twin->weight[i] * twin->share_error[i] * point->rgb[c] + 3.0 * FLOAT_LEAST;
    }
    twin->left = reference_composite(twin->points, in->samples, twin->stride, twin->background, twin->colour);
    twin->left_error = twin->left * (SHARE_TOLERANCE + in->samples * FLOAT_ROUNDING * tau) + LEAST_LIGHT;
    for (int c = 0; c < 3; c++)
        twin->colour_error[c] += twin->left_error * twin->background[c] + in->samples * (FLOAT_ROUNDING * twin->colour[c] + LEAST_LIGHT);
}

// ---- composite_rays --------------------------------------------------------------------------------------------------------

void check_composite_rays(struct step_bench *bench, enum input_kind kind) {
    struct evaluator *evaluator = step_bench_evaluator(bench);
    struct inputs in = make_inputs(bench, kind, evaluator->ray_count);
    struct vw_push_samples push = {.ray_count = evaluator->ray_count};
    step_bench_write(bench, evaluator->rays, in.rays);
    step_bench_write(bench, evaluator->samples, in.field);
    step_bench_dispatch(bench, evaluator->composite, &push, sizeof push, push.ray_count);
    vw_float4 *colours = step_bench_read(bench, evaluator->colours);
    for (uint32_t ray = 0; ray < in.ray_count; ray++) {
        struct twin twin;
        const double device[3] = {colours[ray].x, colours[ray].y, colours[ray].z};
        composite(bench, &in, ray, &twin);
        check_value(bench->where, "transmittance", ray, colours[ray].w, twin.left, twin.left_error);
        for (int c = 0; c < 3; c++) check_value(bench->where, "colour", ray, device[c], twin.colour[c], twin.colour_error[c]);
    }
    free(colours);
    free_inputs(&in);
}

// ---- backward_rays ---------------------------------------------------------------------------------------------------------

struct twin_loss {
    double loss, loss_error, d_colour[3], d_colour_error[3];
};

// How much the slope of a loss changes per error.
static double curvature(enum vw_loss loss) { return loss == VW_LOSS_L2 ? 2.0 : loss == VW_LOSS_HUBER ? 10.0 : 0.0; }

// `d_seen` are the gradients by the colours as the photo sees them.
static struct twin_loss take_loss(const struct step_bench *bench, const struct inputs *in, uint32_t index, const struct twin *twin,
                                  double d_seen[3]) {
    struct reference_ray ray = reference_ray_of(&in->rays[index]);
    struct reference_photo photo = reference_photo_of(&bench->model, bench->params, bench->view);
    struct twin_loss taken = {0};
    double share = ray.weight / 3.0, seen[3];
    reference_appear(&photo, twin->colour, seen);
    for (int c = 0; c < 3; c++) {
        double gain = 1.0 + photo.gain[c], error = seen[c] - ray.target[c], slope,
               error_error = gain * twin->colour_error[c] + (bench->model.appearance.size_bytes ? 4.0 : 1.0) * FLOAT_ROUNDING;
        if (bench->config.loss == VW_LOSS_L1 && error != 0.0 && ray.weight > 0.0 && fabs(error) < error_error && ray.target[c] > 0.0)
            fail_msg("%s: ray %u stands at the kink of the loss; choose another seed", bench->where, index);
        taken.loss += share * reference_loss(bench->config.loss, error, &slope);
        taken.loss_error += share * error_error * 2.0 + 4.0 * FLOAT_ROUNDING;
        d_seen[c] = share * slope;
        taken.d_colour[c] = gain * d_seen[c];
        taken.d_colour_error[c] = gain * share * (curvature(bench->config.loss) * error_error + 4.0 * FLOAT_ROUNDING);
    }
    return taken;
}

static void check_sample(const struct step_bench *bench, const struct twin *twin, const struct twin_loss *taken, uint32_t i,
                         const struct reference_d_point *expected, const vw_float4 *device, uint64_t index) {
    const double rgb[3] = {device->x, device->y, device->z};
    double tau = twin->points[i].density * twin->stride, light = exp(-twin->tau_before[i] - tau) + LEAST_LIGHT, raw_error = FLOAT_LEAST;
    for (int c = 0; c < 3; c++) {
        double slope = fabs(taken->d_colour[c]), slope_error = taken->d_colour_error[c];
        check_value(bench->where, "d_rgb", index, rgb[c], expected->rgb[c],
                    twin->weight[i] * (slope_error + (twin->share_error[i] + 3.0 * FLOAT_ROUNDING) * slope) + slope * LEAST_LIGHT +
                        3.0 * FLOAT_LEAST);
        // Both the sample and what is behind it are seen through `light`, whose size their difference may be much below.
        double seen = light * (twin->points[i].rgb[c] + 1.0);
        raw_error += tau * slope * LEAST_LIGHT;
        raw_error +=
            tau * seen * (slope_error + slope * (2.0 * SHARE_TOLERANCE + 64.0 * FLOAT_ROUNDING * (1.0 + twin->tau_before[i] + tau)));
    }
    check_value(bench->where, "d_raw", index, device->w, expected->raw, raw_error);
}

// The ray's share of the photo's gradient.
static void check_share(const struct step_bench *bench, const struct twin *twin, const struct twin_loss *taken, const double d_seen[3],
                        uint32_t ray, const struct vw_appearance *device) {
    for (int c = 0; c < 3; c++) {
        check_value(bench->where, "d_bias", ray, (&device->bias.x)[c], d_seen[c], 2.0 * taken->d_colour_error[c]);
        check_value(bench->where, "d_gain", ray, (&device->gain.x)[c], d_seen[c] * twin->colour[c],
                    2.0 * taken->d_colour_error[c] * (twin->colour[c] + twin->colour_error[c]) + fabs(d_seen[c]) * twin->colour_error[c] +
                        FLOAT_ROUNDING * fabs(d_seen[c] * twin->colour[c]) + FLOAT_LEAST);
    }
}

static void check_ray(const struct step_bench *bench, const struct inputs *in, uint32_t ray, float device_loss, const vw_float4 *d_field,
                      const struct vw_appearance *shares) {
    double d_seen[3];
    struct twin twin;
    struct reference_d_point expected[SAMPLES_MAX];
    composite(bench, in, ray, &twin);
    struct twin_loss taken = take_loss(bench, in, ray, &twin, d_seen);
    if (shares) check_share(bench, &twin, &taken, d_seen, ray, &shares[ray]);
    check_value(bench->where, "ray_loss", ray, device_loss, taken.loss, taken.loss_error);
    reference_composite_gradient(twin.points, in->samples, twin.stride, twin.background, taken.d_colour, expected);
    for (uint32_t i = 0; i < in->samples; i++) {
        uint64_t index = (uint64_t)ray * in->samples + i;
        check_sample(bench, &twin, &taken, i, &expected[i], &d_field[index], index);
    }
}

void check_backward_rays(struct step_bench *bench, enum input_kind kind) {
    struct inputs in = make_inputs(bench, kind, bench->step.padded_rays);
    struct vw_push_samples push = step_bench_push(bench, 1);
    step_bench_write(bench, bench->step.ray_buffer, in.rays);
    step_bench_write(bench, bench->step.samples, in.field);
    step_bench_write_params(bench);
    step_bench_write(bench, bench->field.step_state, &(struct vw_step_state){.view = bench->view});
    step_bench_dispatch(bench, bench->step.backward_rays, &push, sizeof push, push.ray_count);
    float *losses = step_bench_read(bench, bench->step.ray_loss);
    vw_float4 *d_field = step_bench_read(bench, bench->step.d_samples);
    struct vw_appearance *shares = bench->step.appearance.d_appearance ? step_bench_read(bench, bench->step.appearance.d_appearance) : NULL;
    for (uint32_t ray = 0; ray < in.ray_count; ray++) check_ray(bench, &in, ray, losses[ray], d_field, shares);
    free(shares);
    free(losses);
    free(d_field);
    free_inputs(&in);
}
