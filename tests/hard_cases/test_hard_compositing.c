// Hard media: nothing, everything, and what lies between, over sixteen orders of magnitude and 4,096 samples. Where the
// samples are made by hand, compositing and its gradient are held against the reference relative to what there is to
// see; the other cases are whole steps.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "hard_cases/hard_step.h"

// Tolerance relative to the light that the medium holds back: near an optical thickness of 0.03, where the series ends,
// 1 - exp(-tau) is good to 1.3e-7 / 0.03, and the gradient takes its difference with what is behind.
static const double MEDIUM_TOLERANCE = 2e-5;
// The thickness so far is a float as well: after 4,096 additions up to 8 it may be off by some hundred units in its
// last place, and the light that passes by as much, relatively.
static const double LONG_MEDIUM_TOLERANCE = 2e-4;
static const double LEAST_LIGHT = 1e-28; // beyond tau = 87 the device keeps 1e-38 of the light, the reference nothing

enum { STEP = 3 };

static const struct step_case setup = {.name = "media", .seed = 311, HARD_STEP};

// ---- Samples made by hand -------------------------------------------------------------------------------------------

// Optical thickness of sample i of a ray.
typedef double thickness(uint32_t ray, uint32_t i);

struct inputs {
    uint32_t rays, samples;
    struct vw_ray *ray;
    vw_float4 *field;
};

// Colours up to 0.8 before a white target, so that no ray comes near the kink of the L1 loss; the stride changes from
// ray to ray.
static struct inputs make_inputs(const struct step_bench *bench, thickness *medium) {
    struct inputs in = {.rays = bench->step.padded_rays, .samples = bench->config.samples};
    struct test_random random = {.seed = bench->config.seed};
    in.ray = test_allocate(in.rays, sizeof *in.ray);
    in.field = test_allocate((size_t)in.rays * in.samples, sizeof *in.field);
    for (uint32_t ray = 0; ray < in.rays; ray++) {
        float stride = exp2f(-(float)(ray % 8));
        in.ray[ray].direction_stride.w = stride;
        in.ray[ray].target_weight = (vw_float4){1.0f, 1.0f, 1.0f, 1.0f};
        for (uint32_t i = 0; i < in.samples; i++) {
            vw_float4 *sample = &in.field[(size_t)ray * in.samples + i];
            for (int c = 0; c < 3; c++) (&sample->x)[c] = 0.4f + 0.4f * test_random_next(&random);
            sample->w = (float)(medium(ray, i) / stride);
        }
    }
    return in;
}

static void list_points(const struct inputs *in, uint32_t ray, struct reference_point *points) {
    for (uint32_t i = 0; i < in->samples; i++) {
        const vw_float4 *sample = &in->field[(size_t)ray * in->samples + i];
        points[i] =
            (struct reference_point){{sample->x, sample->y, sample->z}, sample->w, in->ray[ray].direction_stride.w};
    }
}

static void check_colour(struct hard_finding *finding, uint32_t ray, const vw_float4 *device, const double colour[3],
                         double left, double tolerance) {
    const double rgb[3] = {device->x, device->y, device->z};
    double opacity =
        1.0 - left > 1e-3 ? 1.0 - left : 2.0 * (colour[0] + colour[1] + colour[2]); // near 0, left is a rounded 1
    for (int c = 0; c < 3; c++) hard_compare(finding, "colour", ray, rgb[c], colour[c], opacity, tolerance);
    hard_compare(finding, "light that is left", ray, device->w, left, 1.0, tolerance);
}

static void check_gradient(struct hard_finding *finding, const struct inputs *in, const struct reference_point *points,
                           const double d_colour[3], const vw_float4 *device, double tolerance) {
    static const double black[3];
    struct reference_d_point *expected = test_allocate(in->samples, sizeof *expected);
    double before = 0.0;
    reference_composite_gradient(points, in->samples, black, d_colour, expected);
    for (uint32_t i = 0; i < in->samples; i++) {
        double tau = points[i].density * points[i].length,
               size = fabs(d_colour[0]) + fabs(d_colour[1]) + fabs(d_colour[2]);
        const double d_rgb[3] = {device[i].x, device[i].y, device[i].z};
        for (int c = 0; c < 3; c++)
            hard_compare(finding, "gradient by a colour", i, d_rgb[c], expected[i].rgb[c],
                         fabs(expected[i].rgb[c]) + fabs(d_colour[c]) * -expm1(-tau) * LEAST_LIGHT, tolerance);
        double light = fmax(exp(-(before + tau)), LEAST_LIGHT);
        hard_compare(finding, "gradient by a density", i, device[i].w, expected[i].raw, size * tau * light, tolerance);
        before += tau;
    }
}

static void check_medium(struct hard_finding *finding, struct step_bench *bench, thickness *medium, double tolerance) {
    struct inputs in = make_inputs(bench, medium);
    struct vw_evaluator *evaluator = step_bench_evaluator(bench);
    struct reference_point *points = test_allocate(in.samples, sizeof *points);
    struct vw_push_samples push = step_bench_push(bench, STEP);
    assert_true(push.ray_count <= vw_volume_evaluation_of(evaluator)->chunk_rays);
    step_bench_write(bench, bench->step.ray_buffer, in.ray);
    step_bench_write(bench, vw_volume_step_of(&bench->step)->samples, in.field);
    step_bench_write(bench, evaluator->rays, in.ray);
    step_bench_write(bench, vw_volume_evaluation_of(evaluator)->samples, in.field);
    step_bench_dispatch(bench, vw_volume_step_of(&bench->step)->gradient.backward_rays, &push, sizeof push,
                        step_bench_lanes(bench, push.ray_count));
    step_bench_dispatch(bench, vw_volume_evaluation_of(evaluator)->composite, &push, sizeof push,
                        step_bench_lanes(bench, push.ray_count));
    vw_float4 *colours = step_bench_read(bench, evaluator->colours),
              *d_field = step_bench_read(bench, vw_volume_step_of(&bench->step)->d_samples);
    for (uint32_t ray = 0; ray < in.rays; ray++) {
        static const double black[3];
        double colour[3], d_colour[3];
        list_points(&in, ray, points);
        double left = reference_composite(points, in.samples, black, colour);
        check_colour(finding, ray, &colours[ray], colour, left, tolerance);
        for (int c = 0; c < 3; c++) {
            reference_loss(&bench->model.specialization, colour[c] - 1.0, &d_colour[c]);
            d_colour[c] /= 3.0;
        }
        check_gradient(finding, &in, points, d_colour, &d_field[(size_t)ray * in.samples], tolerance);
    }
}

// Returns a thickness from 10^-12 to 10^4 over the rays, the same along each.
static double even_thickness(uint32_t ray, uint32_t i) {
    return i == 0 && ray == 0 ? 1e-12 : pow(10.0, -12.0 + 16.0 * (ray % 64) / 63.0);
}

// Returns a thickness of the same range, in every order along one ray.
static double mixed_thickness(uint32_t ray, uint32_t i) {
    return pow(10.0, -12.0 + 16.0 * ((7 * i + 13 * ray) % 64) / 63.0);
}

static void optical_thickness(struct hard_finding *finding) {
    struct step_bench *bench = step_bench_open(&setup);
    check_medium(finding, bench, even_thickness, MEDIUM_TOLERANCE);
    check_medium(finding, bench, mixed_thickness, MEDIUM_TOLERANCE);
}

// Returns a wall as thick as walls get (DENSITY_MAX through the whole box), then anything.
static double wall_first(uint32_t ray, uint32_t i) { return i == 0 ? 3e6 : mixed_thickness(ray, i); }

static void opaque_first_sample(struct hard_finding *finding) {
    struct step_bench *bench = step_bench_open(&setup);
    check_medium(finding, bench, wall_first, MEDIUM_TOLERANCE);
}

// ---- Whole steps ----------------------------------------------------------------------------------------------------

// Sets all densities' logarithms to `weight` times the sum of the hidden units, which are never below 0.
static void set_density_weights(struct step_bench *bench, float weight) {
    float *params = bench->params + bench->model.weights.offset_bytes / sizeof(float);
    for (uint32_t k = 0; k < bench->config.width; k++)
        params[reference_block_index(&bench->model.specialization, 1, 0, k)] = weight;
    step_bench_write_params(bench);
}

static void check_densities(struct hard_finding *finding, struct step_bench *bench, double expected, double tolerance) {
    vw_float4 *samples = step_bench_read(bench, vw_volume_step_of(&bench->step)->samples);
    for (uint32_t i = 0; i < bench->padded_samples; i++)
        hard_compare(finding, "density", i, samples[i].w, expected, 1.0, tolerance);
}

// Checks densities from just above the largest to beyond the floats.
static void density_beyond_exp(struct hard_finding *finding) {
    static const float weights[] = {1e3f, 1e6f, 1e30f, 3e38f};
    struct step_bench *bench = step_bench_open(&setup);
    for (size_t i = 0; i < VW_ARRAY_COUNT(weights); i++) {
        set_density_weights(bench, weights[i]);
        hard_check_step(finding, bench, STEP);
        check_densities(finding, bench, reference_density_max, 0.0);
        hard_check_rendering(finding, bench);
    }
}

// Checks that in empty space the background alone is seen, and no gradient comes back.
static void no_density_anywhere(struct hard_finding *finding) {
    static const float weights[] = {-1e3f, -1e30f, -3e38f};
    struct step_case white = setup;
    white.effects = "background";
    struct step_bench *bench = step_bench_open(&white);
    for (size_t i = 0; i < VW_ARRAY_COUNT(weights); i++) {
        set_density_weights(bench, weights[i]);
        hard_check_step(finding, bench, STEP);
        check_densities(finding, bench, 0.0, 0.0);
        hard_check_rendering(finding, bench);
        float *params = step_bench_read(bench, bench->field.params);
        hard_same_bits(finding, "params that no light met", params, bench->params, bench->model.param_bytes);
    }
}

// ---- 4,096 samples --------------------------------------------------------------------------------------------------

// 8,192 trips through the loops of backward_rays, of the 65,535 that lavapipe allows; jitter of 12 bits within a
// stratum.
static const struct step_case long_rays = {.name = "long rays",
                                           .seed = 312,
                                           .rays = 2,
                                           .samples = 4096,
                                           .levels = 4,
                                           .log2_table = 8,
                                           .width = 16,
                                           .loss = VW_LOSS_L2};

static double thin_fog(uint32_t ray, uint32_t i) { return (1e-6 + 3e-4 * (i % 7)) * (ray + 1); }
static double wall_at_the_end(uint32_t ray, uint32_t i) { return i == 4095 - ray ? 50.0 : 1e-9; }

static void many_samples(struct hard_finding *finding) {
    struct step_bench *bench = step_bench_open(&long_rays);
    hard_check_step(finding, bench, STEP);
    hard_check_rendering(finding, bench);
    check_medium(finding, bench, thin_fog, LONG_MEDIUM_TOLERANCE);
    check_medium(finding, bench, wall_at_the_end, LONG_MEDIUM_TOLERANCE);
}

static const struct hard_case cases[] = {
    {"density so high that exp overflows", "inf * 0 in the backward pass: NaN gradients", density_beyond_exp},
    {"zero density everywhere", "0/0 in Adam; background off by rounding", no_density_anywhere},
    {"optical thickness 10^-12 to 10^4 per sample", "1 - exp(-tau) loses its digits, exp underflows",
     optical_thickness},
    {"opaque first sample", "light leaks; the backward pass divides by no light", opaque_first_sample},
    {"4,096 samples on a ray", "loops cut short by the driver; sums that lose the small", many_samples},
};

int main(void) { return hard_cases_run("compositing", cases, VW_ARRAY_COUNT(cases)); }
