// The passes of photos with exposures of their own against the reference: fit_views and fit_photo.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "gpu/compute.h"
#include "kernels/checks/check.h"

enum { UPDATES = 3 };

static const float *values_of(const struct vw_param_range *range, const float *params) {
    return params + range->offset_bytes / sizeof(float);
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
    test_write(r->rays, r->ray_data);
    test_write(r->colours, r->colour_data);
    step_bench_dispatch(bench, r->fit_pass, &push, sizeof push, 64 * REDUCED_VIEWS);
    assert_int_equal(vw_buffer_read(r->fits, 0, fits, sizeof fits), VW_OK);
    check_fits(bench->where, r, fits);
    check_fitted_errors(bench->where, r, fits);
}

static void check_untouched(const struct step_bench *bench, const char *what, const void *after, const void *before,
                            uint32_t photos, size_t photo_bytes) {
    for (uint32_t view = 0; view < photos; view++)
        if (view != bench->view)
            check_same_bits(bench->where, what, (const char *)after + view * photo_bytes,
                            (const char *)before + view * photo_bytes, photo_bytes);
}

// ---- fit_photo ------------------------------------------------------------------------------------------------------

struct visit {
    struct vw_ray *rays;
    vw_float4 *rendered;
    struct vw_appearance photo, photo_after;
    struct vw_photo_sums sums, sums_after;
};

// A value in double, with the sum of magnitudes that its rounding is relative to.
struct sum {
    double value, magnitude;
};

static void add_to(struct sum *sum, double weight, double value, double magnitude) {
    sum->value += weight * value;
    sum->magnitude += weight * magnitude;
}

// Lists the sums of a channel after the visit: of rays, rendered, squares, missing, products.
static void sum_channel(const struct step_bench *bench, const struct visit *visit, uint32_t c, struct sum sums[5]) {
    const float *before[] = {&visit->sums.rendered.w, &visit->sums.rendered.x + c, &visit->sums.squares.x + c,
                             &visit->sums.missing.x + c, &visit->sums.products.x + c};
    for (int i = 0; i < 5; i++) sums[i] = (struct sum){0.5 * *before[i], 0.5 * fabs((double)*before[i])};
    for (uint32_t ray = 0; ray < bench->step.padded_rays; ray++) {
        const vw_float4 target = visit->rays[ray].target_weight;
        bool clipped = !(target.x > 0.0f && target.x < 1.0f && target.y > 0.0f && target.y < 1.0f && target.z > 0.0f &&
                         target.z < 1.0f);
        double weight = clipped ? 0.0 : visit->rendered[ray].w, rendered = (&visit->rendered[ray].x)[c],
               scaled = (1.0 + (&visit->photo.gain.x)[c]) * (&visit->rays[ray].target_weight.x)[c],
               bias = (&visit->photo.bias.x)[c], missing = scaled + bias - rendered,
               missing_size = fabs(scaled) + fabs(bias) + fabs(rendered);
        add_to(&sums[0], weight, 1.0, 1.0);
        add_to(&sums[1], weight, rendered, fabs(rendered));
        add_to(&sums[2], weight, rendered * rendered, rendered * rendered);
        add_to(&sums[3], weight, missing, missing_size);
        add_to(&sums[4], weight, rendered * missing, fabs(rendered) * missing_size);
    }
}

// Holds the sums against the reference's, and the fit against what the reference makes of the device's sums.
// BIAS_PULL keeps the determinant above a twelfth of its first product, which magnifies its rounding by as much.
static void check_fitted(const struct step_bench *bench, const struct visit *visit, uint32_t c) {
    static const char *const names[] = {"rays", "rendered", "squares", "missing", "products"};
    const float *after[] = {&visit->sums_after.rendered.w, &visit->sums_after.rendered.x + c,
                            &visit->sums_after.squares.x + c, &visit->sums_after.missing.x + c,
                            &visit->sums_after.products.x + c};
    struct sum sums[5];
    sum_channel(bench, visit, c, sums);
    for (int i = 0; i < 5; i++)
        check_value(bench->where, names[i], c, *after[i], sums[i].value,
                    (bench->step.padded_rays / 64.0 + 72.0) * FLOAT_ROUNDING * sums[i].magnitude +
                        4.0 * bench->step.padded_rays * FLOAT_LEAST);
    struct reference_photo_sums device = {.rays = *after[0]};
    struct reference_photo photo = {0};
    device.rendered[c] = *after[1];
    device.squares[c] = *after[2];
    device.missing[c] = *after[3];
    device.products[c] = *after[4];
    reference_fit_photo(&device, &photo);
    double biased = 1.1 * *after[0] + reference_fit_ridge, squares = *after[2] + reference_fit_ridge,
           products = fabs((double)*after[4]) + fabs((double)*after[1] * *after[3]) / biased,
           gain_error = 12.0 * 8.0 * FLOAT_ROUNDING * (products / squares + fabs(photo.gain[c])) + 16.0 * FLOAT_LEAST,
           shown = fabs((double)*after[3]) + fabs(photo.gain[c] * *after[1]),
           bias_error = (4.0 * FLOAT_ROUNDING * shown + gain_error * fabs((double)*after[1])) / biased + FLOAT_LEAST;
    check_value(bench->where, "fitted gain", c, (&visit->sums_after.gain.x)[c], photo.gain[c], gain_error);
    check_value(bench->where, "fitted bias", c, (&visit->sums_after.bias.x)[c], photo.bias[c], bias_error);
}

// Holds the photo against the device's own fits of all photos. A mean gain is above -0.9, whose inverse magnifies its
// rounding by 10.
static void check_centred(const struct step_bench *bench, const struct visit *visit, const struct vw_photo_sums *sums) {
    const struct reference_photo photo =
        reference_photo_of_fits(sums, reference_photo_count(&bench->model), bench->view);
    for (uint32_t c = 0; c < 3; c++) {
        double ratio = 1.0 + photo.gain[c], size = fabs(photo.bias[c]) + fabs((&visit->sums_after.bias.x)[c]);
        check_value(bench->where, "centred gain", c, (&visit->photo_after.gain.x)[c], photo.gain[c],
                    100.0 * FLOAT_ROUNDING * (1.0 + ratio));
        check_value(bench->where, "centred bias", c, (&visit->photo_after.bias.x)[c], photo.bias[c],
                    200.0 * FLOAT_ROUNDING * (1.0 + ratio) * (1.0 + size));
    }
}

struct photo_state {
    float *params;
    struct vw_photo_sums *sums;
};

static struct photo_state read_photos(struct step_bench *bench) {
    return (struct photo_state){test_read(bench->field.params),
                                test_read(bench->step.effect_buffers[VW_SLOT_PHOTO_SUMS])};
}

static const struct vw_appearance *photo_of(const struct step_bench *bench, const float *params) {
    return (const struct vw_appearance *)values_of(&bench->model.ranges[VW_SLOT_APPEARANCE], params) + bench->view;
}

static void dispatch_fit(struct step_bench *bench, const struct visit *visit, bool flagged) {
    const struct vw_push_update push = {.count = bench->step.padded_rays};
    const struct vw_step_state state = {.nonfinite = flagged, .view = bench->view};
    test_write(bench->step.ray_buffer, visit->rays);
    test_write(bench->step.effect_buffers[VW_SLOT_RENDERED], visit->rendered);
    test_write(bench->field.step_state, &state);
    step_bench_dispatch(bench, step_bench_effect_pass(bench, "fit_photo"), &push, sizeof push, 1);
}

static void check_visit(struct step_bench *bench, struct visit *visit) {
    const struct vw_param_range *range = &bench->model.ranges[VW_SLOT_APPEARANCE];
    const struct photo_state before = read_photos(bench);
    const uint32_t photos = reference_photo_count(&bench->model);
    dispatch_fit(bench, visit, false);
    const struct photo_state after = read_photos(bench);
    const struct vw_step_state *state = test_read(bench->field.step_state);
    visit->photo = *photo_of(bench, before.params);
    visit->photo_after = *photo_of(bench, after.params);
    visit->sums = before.sums[bench->view];
    visit->sums_after = after.sums[bench->view];
    for (uint32_t c = 0; c < 3; c++) check_fitted(bench, visit, c);
    check_centred(bench, visit, after.sums);
    assert_true(visit->sums_after.gain.w == visit->sums.gain.w + 1.0f);
    assert_true(state->nonfinite == 0 && visit->photo_after.gain.w == 0.0f && visit->photo_after.bias.w == 0.0f);
    check_same_bits(bench->where, "grid and weights", after.params, before.params, range->offset_bytes);
    check_untouched(bench, "other photos", values_of(range, after.params), values_of(range, before.params), photos,
                    sizeof(struct vw_appearance));
    check_untouched(bench, "other photos' sums", after.sums, before.sums, photos, sizeof *after.sums);
}

// Draws rays, of which some are masked.
static void draw_visit(const struct step_bench *bench, enum input_kind kind, struct test_random *random,
                       struct visit *visit) {
    for (uint32_t ray = 0; ray < bench->step.padded_rays; ray++) {
        float numbers[6];
        input_fill(kind, random, numbers, 6);
        float weight = ray % 7 == 2 ? 0.0f : ray % 5 == 1 ? 0.25f : 1.0f;
        visit->rays[ray].target_weight = (vw_float4){numbers[0], numbers[1], numbers[2], weight};
        visit->rendered[ray] = (vw_float4){numbers[3], numbers[4], numbers[5], weight};
    }
}

static void check_still(struct step_bench *bench, const struct visit *visit, bool flagged) {
    const struct photo_state before = read_photos(bench);
    dispatch_fit(bench, visit, flagged);
    const struct photo_state after = read_photos(bench);
    const struct vw_step_state *state = test_read(bench->field.step_state);
    if (!state->nonfinite)
        fail_msg("%s: rendered %g, target %g is not flagged", bench->where, (double)visit->rendered[1].y,
                 (double)visit->rays[1].target_weight.y);
    check_same_bits(bench->where, "params of a skipped step", after.params, before.params, bench->model.param_bytes);
    check_same_bits(bench->where, "sums of a skipped step", after.sums, before.sums,
                    vw_buffer_size_bytes(bench->step.effect_buffers[VW_SLOT_PHOTO_SUMS]));
}

// Checks that a value that is not finite, or has no square, moves nothing, and that the flag says so; nor does a step
// that was flagged before.
static void check_not_finite(struct step_bench *bench, const struct visit *visit) {
    static const float wrong[] = {NAN, INFINITY, -INFINITY, 1e30f, -1e30f};
    for (size_t i = 0; i < VW_ARRAY_COUNT(wrong); i++) {
        const float rendered = visit->rendered[1].y, target = visit->rays[1].target_weight.y;
        visit->rendered[1].y = wrong[i];
        check_still(bench, visit, false);
        visit->rendered[1].y = rendered;
        visit->rays[1].target_weight.y = wrong[i];
        if (!isfinite(wrong[i])) check_still(bench, visit, false);
        visit->rays[1].target_weight.y = target;
    }
    check_still(bench, visit, true);
}

// Checks that what masked rays hold changes no bit.
static void check_masked(struct step_bench *bench, struct visit *visit, const struct photo_state *start) {
    struct photo_state after[2];
    for (int i = 0; i < 2; i++) {
        test_write(bench->field.params, start->params);
        test_write(bench->step.effect_buffers[VW_SLOT_PHOTO_SUMS], start->sums);
        dispatch_fit(bench, visit, false);
        after[i] = read_photos(bench);
        for (uint32_t ray = 0; ray < bench->step.padded_rays; ray++)
            if (visit->rendered[ray].w == 0.0f) {
                visit->rendered[ray] = (vw_float4){7.0f, -3.0f, 100.0f, 0.0f};
                visit->rays[ray].target_weight = (vw_float4){-2.0f, 50.0f, 0.25f, 0.0f};
            }
    }
    check_same_bits(bench->where, "params, masked rays aside", after[1].params, after[0].params,
                    bench->model.param_bytes);
    check_same_bits(bench->where, "sums, masked rays aside", after[1].sums, after[0].sums,
                    vw_buffer_size_bytes(bench->step.effect_buffers[VW_SLOT_PHOTO_SUMS]));
}

// Checks that a nearly black photo of what is bright comes to the least gain and stays there.
static void check_dark(struct step_bench *bench, struct visit *visit) {
    enum { VISITS = 8 };
    float *params = test_read(bench->field.params);
    uint64_t first = bench->model.ranges[VW_SLOT_APPEARANCE].offset_bytes / sizeof *params + 8 * bench->view;
    memset(params + first, 0, sizeof(struct vw_appearance));
    test_write(bench->field.params, params);
    test_write(bench->step.effect_buffers[VW_SLOT_PHOTO_SUMS],
               test_allocate(vw_buffer_size_bytes(bench->step.effect_buffers[VW_SLOT_PHOTO_SUMS]), 1));
    for (int i = 0; i < VISITS; i++) {
        const struct vw_appearance photo = *photo_of(bench, test_read(bench->field.params));
        for (uint32_t ray = 0; ray < bench->step.padded_rays; ray++) {
            vw_float4 *target = &visit->rays[ray].target_weight;
            for (int c = 0; c < 3; c++)
                (&target->x)[c] = (0.01f - (&photo.bias.x)[c]) / (1.0f + (&photo.gain.x)[c]); // as it is corrected
            target->w = 1.0f;
            visit->rendered[ray] = (vw_float4){ray % 11 / 10.0f, ray % 8 / 7.0f, 1.0f - ray % 6 / 5.0f, 1.0f};
        }
        check_visit(bench, visit);
    }
    for (int c = 0; c < 3; c++) assert_true((&visit->sums_after.gain.x)[c] == -0.9f);
}

void check_fit_photo(struct step_bench *bench, enum input_kind kind) {
    struct vw_buffer *sums = bench->step.effect_buffers[VW_SLOT_PHOTO_SUMS];
    if (!step_bench_effect_pass(bench, "fit_photo")) return;
    struct test_random random = {.seed = bench->config.seed};
    struct visit visit = {.rays = test_allocate(bench->step.padded_rays, sizeof *visit.rays),
                          .rendered = test_allocate(bench->step.padded_rays, sizeof *visit.rendered)};
    step_bench_write_params(bench);
    struct photo_state start = read_photos(bench);
    memset(start.sums, 0, vw_buffer_size_bytes(sums));
    for (uint32_t view = 0; view < reference_photo_count(&bench->model); view++)
        if (view != bench->view) {
            input_fill(INPUT_ORDINARY, &random, &start.sums[view].rendered.x, 16);
            start.sums[view].gain = (vw_float4){0.5f, -0.3f, 0.1f, (float)(view % 3)}; // some were not visited
            start.sums[view].bias = (vw_float4){0.1f, 0.0f, -0.2f, 0.0f};
        }
    test_write(sums, start.sums);
    for (int i = 0; i < UPDATES; i++) {
        draw_visit(bench, kind, &random, &visit);
        check_visit(bench, &visit);
    }
    if (kind == INPUT_ORDINARY) {
        start = read_photos(bench);
        check_masked(bench, &visit, &start);
        check_not_finite(bench, &visit);
        check_dark(bench, &visit);
    }
    test_write(bench->field.step_state, &(struct vw_step_state){0});
    step_bench_write_params(bench);
}
