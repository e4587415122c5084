// composite_rays and backward_rays against the twin, on hand-made samples: nothing, thin air, fog, walls, and the density's maximum.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "reference/reference.h"
#include "reference/step_bench.h"

// Colours are sums of up to 48 samples, each some roundings and two exp of the device away; values are up to 1.
static const double COLOUR_TOLERANCE = 4e-6;
// Slopes of L2 and Huber follow the colour with a factor of up to 10.
static const double GRADIENT_TOLERANCE = 8e-6;

static const struct step_case cases[] = {
    {.name = "L1, black", .seed = 21, .rays = 256, .levels = 2, .log2_table = 4},
    {.name = "L2, 7 samples, background",
     .seed = 22,
     .rays = 256,
     .samples = 7,
     .levels = 2,
     .log2_table = 4,
     .loss = VW_LOSS_L2,
     .background = true},
    {.name = "Huber, 48 samples",
     .seed = 23,
     .rays = 256,
     .samples = 48,
     .levels = 2,
     .log2_table = 4,
     .loss = VW_LOSS_HUBER,
     .background = true},
    {.name = "one sample", .seed = 24, .rays = 256, .samples = 1, .levels = 2, .log2_table = 4, .background = true},
};

struct inputs {
    uint32_t ray_count, samples;
    struct vw_ray *rays;
    vw_float4 *field;
};

static float unit(struct test_random *random) { return 0.5f + 0.5f * test_random_next(random); }

static struct inputs make_inputs(const struct step_bench *bench) {
    static const float strides[] = {0.03f, 0.005f, 1e-7f, 0.0f, 0.05f}, densities[] = {1.0f, 30.0f, 0.01f, 1e-9f, 0.0f, 1e3f, 3e6f};
    struct test_random random = {.seed = bench->config.seed};
    struct inputs in = {.ray_count = bench->step.padded_rays, .samples = bench->config.samples};
    in.rays = calloc(in.ray_count, sizeof *in.rays);
    in.field = calloc((size_t)in.ray_count * in.samples, sizeof *in.field);
    for (uint32_t ray = 0; ray < in.ray_count; ray++) {
        in.rays[ray].direction_stride.w = strides[ray % 5];
        in.rays[ray].target_weight = (vw_float4){unit(&random), unit(&random), unit(&random), ray % 11 != 3};
        if (ray % 13 == 5) in.rays[ray].target_weight = (vw_float4){.w = 1.0f}; // a black target, and below nothing in front of it
        for (uint32_t i = 0; i < in.samples; i++) {
            float density = ray % 13 == 5 ? 0.0f : densities[ray % 7] * unit(&random);
            if (ray % 3 == 0) density = densities[(uint32_t)(7.0f * unit(&random)) % 7];
            in.field[ray * in.samples + i] = (vw_float4){unit(&random), unit(&random), unit(&random), density};
        }
    }
    return in;
}

static void free_inputs(struct inputs *in) {
    free(in->rays);
    free(in->field);
}

static void list_points(const struct inputs *in, uint32_t ray, struct reference_point *points) {
    for (uint32_t i = 0; i < in->samples; i++) {
        const vw_float4 *sample = &in->field[ray * in->samples + i];
        points[i] = (struct reference_point){{sample->x, sample->y, sample->z}, sample->w};
    }
}

static void check_training_ray(const struct step_bench *bench, const struct inputs *in, uint32_t index, float device_loss,
                               const vw_float4 *d_field) {
    struct reference_point points[64];
    struct reference_d_point d_points[64];
    struct reference_ray ray = reference_ray_of(&in->rays[index]);
    double background[3], colour[3], d_colour[3], loss = 0.0;
    reference_background(&bench->model.specialization, background);
    list_points(in, index, points);
    reference_composite(points, in->samples, ray.stride, background, colour);
    for (int c = 0; c < 3; c++) {
        double error = colour[c] - ray.target[c];
        if (bench->config.loss == VW_LOSS_L1 && error != 0.0 && fabs(error) < COLOUR_TOLERANCE)
            fail_msg("%s: ray %u stands at the kink of the loss; choose another seed", bench->where, index);
        loss += ray.weight / 3.0 * reference_loss(bench->config.loss, error, &d_colour[c]);
        d_colour[c] *= ray.weight / 3.0;
    }
    check_value(bench->where, "ray_loss", index, device_loss, loss, 2.0 * COLOUR_TOLERANCE);
    reference_composite_gradient(points, in->samples, ray.stride, background, d_colour, d_points);
    for (uint32_t i = 0; i < in->samples; i++) {
        const vw_float4 *d = &d_field[index * in->samples + i];
        const double rgb[3] = {d->x, d->y, d->z};
        for (int c = 0; c < 3; c++)
            check_value(bench->where, "d_rgb", index * in->samples + i, rgb[c], d_points[i].rgb[c], GRADIENT_TOLERANCE);
        check_value(bench->where, "d_raw", index * in->samples + i, d->w, d_points[i].raw, GRADIENT_TOLERANCE);
    }
}

static void backward_rays_matches_the_twin(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct step_bench *bench = step_bench_open(&cases[i]);
        struct inputs in = make_inputs(bench);
        step_bench_write(bench, bench->step.ray_buffer, in.rays);
        step_bench_write(bench, bench->step.samples, in.field);
        struct vw_push_samples push = step_bench_push(bench, 1);
        step_bench_dispatch(bench, bench->step.backward_rays, &push, sizeof push, push.ray_count);
        float *ray_loss = step_bench_read(bench, bench->step.ray_loss);
        vw_float4 *d_field = step_bench_read(bench, bench->step.d_samples);
        for (uint32_t ray = 0; ray < in.ray_count; ray++) check_training_ray(bench, &in, ray, ray_loss[ray], d_field);
        free(ray_loss);
        free(d_field);
        free_inputs(&in);
        step_bench_close(bench);
    }
}

static void check_colours(const struct step_bench *bench, const struct inputs *in, const vw_float4 *colours) {
    double background[3], colour[3];
    struct reference_point points[64];
    reference_background(&bench->model.specialization, background);
    for (uint32_t ray = 0; ray < in->ray_count; ray++) {
        const double device[3] = {colours[ray].x, colours[ray].y, colours[ray].z};
        list_points(in, ray, points);
        double left = reference_composite(points, in->samples, in->rays[ray].direction_stride.w, background, colour);
        check_value(bench->where, "transmittance", ray, colours[ray].w, left, COLOUR_TOLERANCE);
        for (int c = 0; c < 3; c++) check_value(bench->where, "colour", ray, device[c], colour[c], COLOUR_TOLERANCE);
    }
}

static void composite_rays_matches_the_twin(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct step_bench *bench = step_bench_open(&cases[i]);
        struct inputs in = make_inputs(bench);
        struct evaluator *evaluator = step_bench_evaluator(bench);
        step_bench_write(bench, evaluator->rays, in.rays);
        step_bench_write(bench, evaluator->samples, in.field);
        struct vw_push_samples push = step_bench_push(bench, 1);
        step_bench_dispatch(bench, evaluator->composite, &push, sizeof push, push.ray_count);
        vw_float4 *colours = step_bench_read(bench, evaluator->colours);
        check_colours(bench, &in, colours);
        free(colours);
        free_inputs(&in);
        step_bench_close(bench);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(backward_rays_matches_the_twin), cmocka_unit_test(composite_rays_matches_the_twin)};
    return cmocka_run_group_tests_name("composite_rays", tests, NULL, step_bench_teardown);
}
