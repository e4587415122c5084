// reduce_views and reduce_loss against the reference: sums good to 2^-40.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "gpu/compute.h"
#include "gpu/shaders.h"
#include "kernels/checks/check.h"
#include "support/gpu_fixture.h"

static const double SUM_TOLERANCE = 0x1p-40; // relative: two floats carry 48 bits, n additions lose log2(n) of them
static const float GUARD = 12345.0f;         // stands in the rows of the scalars that are none of the pass's business
enum { SCALAR_ROW = 3, SCALAR_ROWS = SCALAR_ROW + 2 + REDUCED_VIEWS };

const struct vw_ray_range reduced_ranges[REDUCED_VIEWS] = {
    {0, 1}, {1, 63}, {64, 64}, {128, 65}, {193, REDUCED_RAYS - 193}};

// ---- reduce_views ---------------------------------------------------------------------------------------------------

static void make_passes(struct vw_gpu *gpu, bool fitted, struct view_reduction *r) {
    const struct vw_specialization specialization = {.effect_appearance = fitted};
    const struct vw_binding bindings[] = {{.slot = VW_SLOT_RAYS, .buffer = r->rays},
                                          {.slot = VW_SLOT_COLOURS, .buffer = r->colours},
                                          {.slot = VW_SLOT_VAL_VIEWS, .buffer = r->views},
                                          {.slot = VW_SLOT_FITS, .buffer = r->fits},
                                          {.slot = VW_SLOT_SCALARS, .buffer = r->scalars}};
    struct vw_pass_params params = {.shader = &vw_shader_reduce_views,
                                    .specialization = (const uint32_t *)&specialization,
                                    .specialization_count = VW_SPECIALIZATION_COUNT,
                                    .bindings = bindings,
                                    .binding_count = VW_ARRAY_COUNT(bindings)};
    r->pass = test_pass(gpu, params);
    params.shader = &vw_shader_fit_views;
    r->fit_pass = test_pass(gpu, params);
}

struct view_reduction *reduction_open(struct vw_gpu *gpu, bool fitted) {
    struct view_reduction *r = test_allocate(1, sizeof *r);
    *r = (struct view_reduction){.rays = test_buffer(gpu, "rays", REDUCED_RAYS * sizeof(struct vw_ray)),
                                 .colours = test_buffer(gpu, "colours", REDUCED_RAYS * sizeof(vw_float4)),
                                 .views = test_buffer(gpu, "views", sizeof reduced_ranges),
                                 .scalars = test_buffer(gpu, "scalars", 16 * SCALAR_ROWS),
                                 .fits = test_buffer(gpu, "fits", REDUCED_VIEWS * sizeof(struct vw_appearance)),
                                 .ray_data = test_allocate(REDUCED_RAYS, sizeof *r->ray_data),
                                 .colour_data = test_allocate(REDUCED_RAYS, sizeof *r->colour_data)};
    make_passes(gpu, fitted, r);
    r->submission = test_submission(gpu);
    ASSERT_OK(vw_buffer_write(r->views, 0, reduced_ranges, sizeof reduced_ranges));
    return r;
}

void reduction_fill(struct view_reduction *r, enum input_kind kind, uint64_t seed) {
    struct test_random random = {.seed = seed};
    for (uint32_t i = 0; i < REDUCED_RAYS; i++) {
        float error = exp2f(-12.0f + 12.0f * test_random_next(&random)); // from 2^-24 to 1
        vw_float4 *target = &r->ray_data[i].target_weight, *colour = &r->colour_data[i];
        *target = (vw_float4){0.5f + 0.5f * test_random_next(&random), 0.25f, 0.75f, i % 31 != 7};
        *colour = (vw_float4){target->x + error, 0.25f - error * test_random_next(&random), 0.5f, 0.1f};
        if (kind == INPUT_ORDINARY) continue;
        *target = (vw_float4){.w = target->w}; // so that no error is lost beside its target
        *colour = (vw_float4){input_draw(kind, &random), input_draw(kind, &random), input_draw(kind, &random), 0.1f};
    }
}

void reduction_run(struct view_reduction *r, vw_float4 sums[REDUCED_VIEWS]) {
    struct vw_push_reduce push = {.count = REDUCED_VIEWS, .scalar_row = SCALAR_ROW};
    vw_float4 rows[SCALAR_ROWS];
    for (size_t i = 0; i < SCALAR_ROWS; i++) rows[i] = (vw_float4){GUARD, GUARD, GUARD, GUARD};
    ASSERT_OK(vw_buffer_write(r->scalars, 0, rows, sizeof rows));
    ASSERT_OK(vw_buffer_write(r->rays, 0, r->ray_data, REDUCED_RAYS * sizeof *r->ray_data));
    ASSERT_OK(vw_buffer_write(r->colours, 0, r->colour_data, REDUCED_RAYS * sizeof *r->colour_data));
    vw_submission_begin(r->submission);
    vw_submission_dispatch(r->submission, r->pass, &push, sizeof push, 64 * REDUCED_VIEWS);
    test_submit(r->submission);
    ASSERT_OK(vw_buffer_read(r->scalars, 0, rows, sizeof rows));
    for (size_t i = 0; i < SCALAR_ROWS; i++)
        if (i < SCALAR_ROW + 1 || i >= SCALAR_ROW + 1 + REDUCED_VIEWS)
            assert_true(rows[i].x == GUARD && rows[i].w == GUARD);
    memcpy(sums, rows + SCALAR_ROW + 1, REDUCED_VIEWS * sizeof *sums);
}

struct reference_view_error reduction_reference(const struct view_reduction *r, uint32_t view) {
    const struct vw_ray_range *range = &reduced_ranges[view];
    return reference_view_error(r->ray_data + range->first, r->colour_data + range->first, range->count);
}

void reduction_check(const char *where, struct view_reduction *r, vw_float4 sums[REDUCED_VIEWS]) {
    reduction_run(r, sums);
    for (uint32_t view = 0; view < REDUCED_VIEWS; view++) {
        struct reference_view_error expected = reduction_reference(r, view);
        double flushed = 3.0 * reduced_ranges[view].count * FLOAT_LEAST;
        check_value(where, "squared error", view, (double)sums[view].x + sums[view].y, expected.squared,
                    SUM_TOLERANCE * expected.squared + flushed);
        check_value(where, "absolute error", view, (double)sums[view].z + sums[view].w, expected.absolute,
                    SUM_TOLERANCE * expected.absolute + flushed);
    }
}

void check_reduce_views(struct step_bench *bench, enum input_kind kind) {
    vw_float4 sums[REDUCED_VIEWS];
    struct view_reduction *reduction = reduction_open(bench->gpu, false);
    reduction_fill(reduction, kind, bench->config.seed);
    reduction_check(bench->where, reduction, sums);
}

// ---- reduce_loss ----------------------------------------------------------------------------------------------------

void check_reduce_loss(struct step_bench *bench, enum input_kind kind) {
    const uint32_t row = 2, rays = bench->step.padded_rays;
    struct vw_push_reduce push = {.count = rays, .scalar_row = row};
    struct test_random random = {.seed = bench->config.seed};
    float *losses = test_allocate(rays, sizeof *losses);
    long double sum = 0.0L;
    for (uint32_t ray = 0; ray < rays; ray++) {
        losses[ray] = fabsf(input_draw(kind, &random));
        if (kind == INPUT_ORDINARY) losses[ray] *= exp2f(10.0f * test_random_next(&random));
        sum += losses[ray];
    }
    test_write(bench->step.ray_loss, losses);
    step_bench_take_overflows(bench);
    test_write(bench->field.step_state, &(struct vw_step_state){.clamped = 77});
    step_bench_dispatch(bench, bench->step.reduce_loss, &push, sizeof push, 1);
    vw_float4 *scalars = test_read(bench->scalars);
    check_value(bench->where, "loss", 0, (double)scalars[row].x + scalars[row].y, (double)sum,
                SUM_TOLERANCE * (double)sum + rays * FLOAT_LEAST);
    assert_true(scalars[row].z == 0.0f);
    assert_true(scalars[row].w == 77.0f);
    const struct vw_step_state *state = test_read(bench->field.step_state);
    assert_int_equal(state->clamped, 0); // the next step begins anew
}
