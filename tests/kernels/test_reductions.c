// The resolution of a delta: a valuation is the difference of two nearly equal error sums, so the change of the sums
// must be right as well when only the last bits of a few pixels change (decision 5). And sums of any number of losses.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "base/statistics.h"
#include "kernels/checks/check.h"
#include "support/gpu_fixture.h"

static const double SUM_TOLERANCE = 0x1p-40; // relative, of the sums themselves
enum { LAST_VIEW = REDUCED_VIEWS - 1 };      // the largest

struct outcome {
    vw_float4 device[REDUCED_VIEWS];
    struct reference_view_error reference[REDUCED_VIEWS];
};

static void take(const char *where, struct view_reduction *reduction, struct outcome *outcome) {
    reduction_check(where, reduction, outcome->device);
    for (uint32_t view = 0; view < REDUCED_VIEWS; view++)
        outcome->reference[view] = reduction_reference(reduction, view);
}

// Moves every (REDUCED_RAYS / k)th pixel by one unit in the last place: away from its target in the blue channel, whose
// error is 1/4, or anywhere.
static void change_pixels(struct view_reduction *reduction, uint32_t k, bool anywhere) {
    struct test_random random = {.seed = k};
    for (uint32_t i = 0; i < k; i++) {
        vw_float4 *colour = &reduction->colour_data[(uint64_t)i * REDUCED_RAYS / k];
        float *channels[] = {&colour->x, &colour->y, &colour->z}, drawn = test_random_next(&random);
        float *channel = anywhere ? channels[(uint32_t)(3.0f * fabsf(drawn)) % 3] : &colour->z;
        *channel = nextafterf(*channel, anywhere && drawn > 0.0f ? INFINITY : -INFINITY);
    }
}

static double high_and_low(float high, float low) { return (double)high + low; }

static double squared(vw_float4 sums) { return high_and_low(sums.x, sums.y); }

static double psnr_change(double sum_before, double sum_after, uint32_t rays) {
    return vw_psnr_db(sum_after / (3.0 * rays)) - vw_psnr_db(sum_before / (3.0 * rays));
}

static void check_change(const char *where, const struct outcome *before, const struct outcome *after, uint32_t view) {
    const struct reference_view_error *was = &before->reference[view], *is = &after->reference[view];
    const vw_float4 *had = &before->device[view], *has = &after->device[view];
    uint32_t rays = reduced_ranges[view].count;
    // Half by half, so that this difference loses no bits either.
    check_value(where, "change of the squared error", view, ((double)has->x - had->x) + ((double)has->y - had->y),
                is->squared - was->squared, SUM_TOLERANCE * was->squared);
    check_value(where, "change of the absolute error", view, ((double)has->z - had->z) + ((double)has->w - had->w),
                is->absolute - was->absolute, SUM_TOLERANCE * was->absolute);
    check_value(where, "change of the PSNR, dB", view, psnr_change(squared(*had), squared(*has), rays),
                psnr_change(was->squared, is->squared, rays), 10.0 / log(10.0) * SUM_TOLERANCE);
}

// Checks that the change is far above its tolerance, and of the right sign.
static void check_significance(const char *where, const struct outcome *before, const struct outcome *after) {
    double change = after->reference[LAST_VIEW].squared - before->reference[LAST_VIEW].squared,
           found = squared(after->device[LAST_VIEW]) - squared(before->device[LAST_VIEW]);
    if (!(change > 8.0 * SUM_TOLERANCE * before->reference[LAST_VIEW].squared && found > 0.5 * change))
        fail_msg("%s: the squared error of the last view changes by %g, by the reference by %g", where, found, change);
}

TEST(the_last_bits_of_k_pixels_count) {
    static const uint32_t counts[] = {1, 2, 10, 100, 1000, REDUCED_RAYS};
    struct view_reduction *reduction = reduction_open(test_gpu(), false);
    for (size_t i = 0; i < VW_ARRAY_COUNT(counts); i++) {
        for (int anywhere = 0; anywhere < 2; anywhere++) {
            struct outcome before, after;
            char where[96];
            snprintf(where, sizeof where, "reduce_views, seed 91, %u pixels changed %s", counts[i],
                     anywhere ? "anywhere" : "in blue");
            reduction_fill(reduction, INPUT_ORDINARY, 91);
            reduction->ray_data[REDUCED_RAYS - 1].target_weight.w = 1.0f;
            take(where, reduction, &before);
            change_pixels(reduction, counts[i], anywhere);
            take(where, reduction, &after);
            for (uint32_t view = 0; view < REDUCED_VIEWS; view++) check_change(where, &before, &after, view);
            if (!anywhere && counts[i] > 2) check_significance(where, &before, &after);
        }
    }
}

TEST(losses_of_any_number_of_rays_are_summed) {
    static const uint32_t ray_counts[] = {1, 64, 500, 5000};
    for (size_t i = 0; i < VW_ARRAY_COUNT(ray_counts); i++) {
        struct step_case many = {
            .name = "loss", .seed = 95 + i, .rays = ray_counts[i], .levels = 2, .log2_table = 4, .width = 16};
        struct step_bench *bench = step_bench_open(&many);
        check_reduce_loss(bench, INPUT_ORDINARY);
        test_release(bench);
    }
}

TEST_GROUP(NULL, test_gpu_close)
