// reduce_views and reduce_loss: sums good to 2^-40, sensitive to the last bit of a pixel, and open to NaN (decisions 5 and 8).
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "gpu/shaders.h"
#include "reference/reference.h"
#include "support/gpu_fixture.h"
#include "reference/step_bench.h"
#include "viewworth/memory.h"

static const double SUM_TOLERANCE = 0x1p-40; // relative: two floats carry 48 bits, n additions lose log2(n) of them
enum { VIEWS = 5, SCALAR_ROW = 3, RAYS = 3000 };
static const struct vw_ray_range ranges[VIEWS] = {{0, 1}, {1, 63}, {64, 64}, {128, 65}, {193, RAYS - 193}};

struct reduction {
    struct vw_buffer *rays, *colours, *views, *scalars;
    struct vw_pass *pass;
    struct vw_batch *batch;
    struct vw_ray *ray_data;
    vw_float4 *colour_data;
};
static struct reduction reduction;

static void ok(enum vw_status status) {
    if (status) fail_msg("%s", vw_error_message());
}

static struct vw_buffer *make_buffer(const char *name, uint64_t size_bytes) {
    struct vw_buffer *buffer = NULL;
    ok(vw_buffer_create(test_gpu(), &(struct vw_buffer_params){.name = name, .size_bytes = size_bytes}, &buffer));
    return buffer;
}

static int set_up(void **state) {
    (void)state;
    struct reduction *r = &reduction;
    *r = (struct reduction){.rays = make_buffer("rays", RAYS * sizeof(struct vw_ray)),
                            .colours = make_buffer("colours", RAYS * sizeof(vw_float4)),
                            .views = make_buffer("views", sizeof ranges),
                            .scalars = make_buffer("scalars", 16 * (SCALAR_ROW + 2 + VIEWS))};
    const struct vw_binding bindings[] = {{.slot = VW_SLOT_RAYS, .buffer = r->rays},
                                          {.slot = VW_SLOT_COLOURS, .buffer = r->colours},
                                          {.slot = VW_SLOT_VAL_VIEWS, .buffer = r->views},
                                          {.slot = VW_SLOT_SCALARS, .buffer = r->scalars}};
    struct vw_pass_params params = {.shader = &vw_shader_reduce_views, .bindings = bindings, .binding_count = VW_ARRAY_COUNT(bindings)};
    ok(vw_pass_create(test_gpu(), &params, &r->pass));
    ok(vw_batch_create(test_gpu(), &r->batch));
    ok(vw_buffer_write(r->views, 0, ranges, sizeof ranges));
    r->ray_data = vw_allocate(RAYS, sizeof *r->ray_data);
    r->colour_data = vw_allocate(RAYS, sizeof *r->colour_data);
    struct test_random random = {.seed = 91};
    for (uint32_t i = 0; i < RAYS; i++) {
        float error = exp2f(-12.0f + 12.0f * test_random_next(&random)); // from 2^-24 to 1
        r->ray_data[i].target_weight = (vw_float4){0.5f + 0.5f * test_random_next(&random), 0.25f, 0.75f, i % 31 != 7};
        r->colour_data[i] = (vw_float4){r->ray_data[i].target_weight.x + error, 0.25f - error * test_random_next(&random), 0.5f, 0.1f};
    }
    return 0;
}

static int tear_down(void **state) {
    (void)state;
    struct reduction *r = &reduction;
    vw_batch_destroy(&r->batch);
    vw_pass_destroy(&r->pass);
    vw_buffer_destroy(&r->rays);
    vw_buffer_destroy(&r->colours);
    vw_buffer_destroy(&r->views);
    vw_buffer_destroy(&r->scalars);
    free(r->ray_data);
    free(r->colour_data);
    return 0;
}

static void reduce(vw_float4 sums[VIEWS]) {
    struct reduction *r = &reduction;
    struct vw_push_reduce push = {.count = VIEWS, .scalar_row = SCALAR_ROW};
    vw_float4 rows[SCALAR_ROW + 2 + VIEWS];
    const float guard = 12345.0f;
    for (size_t i = 0; i < VW_ARRAY_COUNT(rows); i++) rows[i] = (vw_float4){guard, guard, guard, guard};
    ok(vw_buffer_write(r->scalars, 0, rows, sizeof rows));
    ok(vw_buffer_write(r->rays, 0, r->ray_data, RAYS * sizeof *r->ray_data));
    ok(vw_buffer_write(r->colours, 0, r->colour_data, RAYS * sizeof *r->colour_data));
    vw_batch_begin(r->batch);
    vw_batch_dispatch(r->batch, r->pass, &push, sizeof push, 64 * VIEWS);
    ok(vw_batch_submit(r->batch));
    ok(vw_batch_wait(r->batch));
    ok(vw_buffer_read(r->scalars, 0, rows, sizeof rows));
    for (size_t i = 0; i < VW_ARRAY_COUNT(rows); i++)
        if (i < SCALAR_ROW + 1 || i >= SCALAR_ROW + 1 + VIEWS) assert_true(rows[i].x == guard && rows[i].w == guard);
    memcpy(sums, rows + SCALAR_ROW + 1, VIEWS * sizeof *sums);
}

static struct reference_view_error twin(uint32_t view) {
    return reference_view_error(reduction.ray_data + ranges[view].first, reduction.colour_data + ranges[view].first, ranges[view].count);
}

static void check_sums(const char *where, vw_float4 sums[VIEWS]) {
    reduce(sums);
    for (uint32_t view = 0; view < VIEWS; view++) {
        struct reference_view_error expected = twin(view);
        check_value(where, "squared error", view, (double)sums[view].x + sums[view].y, expected.squared, SUM_TOLERANCE * expected.squared);
        check_value(where, "absolute error", view, (double)sums[view].z + sums[view].w, expected.absolute,
                    SUM_TOLERANCE * expected.absolute);
    }
}

static void view_sums_match_the_twin(void **state) {
    (void)state;
    vw_float4 sums[VIEWS];
    check_sums("reduce_views, seed 91", sums);
}

// What valuation lives on: the change of the sums is right as well when a few pixels change by one unit in the last place.
static void the_last_bit_of_a_pixel_counts(void **state) {
    (void)state;
    static const uint32_t changed[] = {0, 1, 70, 190, 200, RAYS - 1};
    vw_float4 sums[VIEWS], after[VIEWS];
    for (size_t i = 0; i < VW_ARRAY_COUNT(changed); i++) {
        uint32_t view = 0;
        check_sums("reduce_views, seed 91, before a change", sums);
        while (changed[i] >= ranges[view].first + ranges[view].count) view++;
        struct reference_view_error before = twin(view);
        // In the blue channel: its error is 1/4 and so the change of the sums is 2^-25 or more of one pixel.
        reduction.colour_data[changed[i]].z = nextafterf(reduction.colour_data[changed[i]].z, 1.0f);
        check_sums("reduce_views, seed 91, a pixel changed by one unit in the last place", after);
        double moved = ((double)after[view].z - sums[view].z) + ((double)after[view].w - sums[view].w);
        double expected = twin(view).absolute - before.absolute;
        if (reduction.ray_data[changed[i]].target_weight.w == 0.0f) continue;
        assert_true(expected < 0.0); // the colour came closer to its target
        check_value("reduce_views, seed 91", "change of the absolute error", changed[i], moved, expected, SUM_TOLERANCE * before.absolute);
    }
}

static void not_finite_reaches_the_scalars(void **state) {
    (void)state;
    static const float poison[] = {NAN, INFINITY, -INFINITY};
    for (size_t i = 0; i < VW_ARRAY_COUNT(poison); i++) {
        for (uint32_t view = 0; view < VIEWS; view++) {
            uint32_t ray = ranges[view].first + ranges[view].count / 2;
            vw_float4 sums[VIEWS], kept = reduction.colour_data[ray];
            float weight = reduction.ray_data[ray].target_weight.w;
            reduction.colour_data[ray].y = poison[i];
            reduction.ray_data[ray].target_weight.w = 1.0f;
            reduce(sums);
            for (uint32_t other = 0; other < VIEWS; other++) {
                bool finite = isfinite((double)sums[other].x + sums[other].y) && isfinite((double)sums[other].z + sums[other].w);
                if (finite != (other != view))
                    fail_msg("%g in view %u: view %u is %s", poison[i], view, other, finite ? "finite" : "not finite");
            }
            reduction.colour_data[ray] = kept;
            reduction.ray_data[ray].target_weight.w = weight;
        }
    }
}

// ---- The training loss ---------------------------------------------------------------------------------------------------

static void reduce_loss(struct step_bench *bench, const float *ray_loss, struct vw_step_state flags, uint32_t row, vw_float4 *scalars) {
    struct vw_push_reduce push = {.count = bench->step.padded_rays, .scalar_row = row};
    step_bench_write(bench, bench->step.ray_loss, ray_loss);
    step_bench_write(bench, bench->field.step_state, &flags);
    step_bench_dispatch(bench, bench->step.reduce_loss, &push, sizeof push, 1);
    vw_float4 *all = step_bench_read(bench, bench->scalars);
    *scalars = all[row];
    free(all);
}

static void loss_matches_the_twin_and_carries_the_flags(void **state) {
    (void)state;
    static const uint32_t ray_counts[] = {1, 64, 500, 5000};
    for (size_t i = 0; i < VW_ARRAY_COUNT(ray_counts); i++) {
        struct step_case many = {.name = "loss", .seed = 95 + i, .rays = ray_counts[i], .levels = 2, .log2_table = 4, .width = 16};
        struct step_bench *bench = step_bench_open(&many);
        float *losses = vw_allocate(bench->step.padded_rays, sizeof *losses);
        struct test_random random = {.seed = many.seed};
        long double sum = 0.0L;
        vw_float4 scalars;
        for (uint32_t ray = 0; ray < bench->step.padded_rays; ray++) {
            losses[ray] = fabsf(test_random_next(&random)) * exp2f(10.0f * test_random_next(&random));
            sum += losses[ray];
        }
        reduce_loss(bench, losses, (struct vw_step_state){.clamped = 77}, 2, &scalars);
        check_value(bench->where, "loss", 0, (double)scalars.x + scalars.y, (double)sum, SUM_TOLERANCE * (double)sum);
        assert_true(scalars.z == 0.0f);
        assert_true(scalars.w == 77.0f);
        reduce_loss(bench, losses, (struct vw_step_state){.nonfinite = 1}, 1, &scalars);
        assert_true(scalars.z == 1.0f);
        losses[bench->step.padded_rays - 1] = NAN;
        reduce_loss(bench, losses, (struct vw_step_state){0}, 0, &scalars);
        assert_true(scalars.z == 1.0f);
        struct vw_step_state *after = step_bench_read(bench, bench->field.step_state);
        assert_true(after->nonfinite != 0); // seen by the passes that follow
        free(after);
        free(losses);
        step_bench_close(bench);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(view_sums_match_the_twin, set_up, tear_down),
        cmocka_unit_test_setup_teardown(the_last_bit_of_a_pixel_counts, set_up, tear_down),
        cmocka_unit_test_setup_teardown(not_finite_reaches_the_scalars, set_up, tear_down),
        cmocka_unit_test(loss_matches_the_twin_and_carries_the_flags),
    };
    return cmocka_run_group_tests_name("reductions", tests, NULL, step_bench_teardown);
}
