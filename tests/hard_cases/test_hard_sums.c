// Hard sums: of more errors than floats can count, all alike or all different, and of none at all. The errors are made
// on the device and are multiples of 2^-24, so that integers give the exact sum.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "base/statistics.h"
#include "generate_errors.h"
#include "gpu/compute.h"
#include "gpu/shaders.h"
#include "hard_cases/hard_case.h"
#include "interface.h"
#include "support/gpu_fixture.h"

static const double SUM_TOLERANCE =
    0x1p-40; // relative: what a valuation asks for, since it subtracts nearly equal sums

static const struct vw_shader generate_errors = {"generate_errors", generate_errors_code, sizeof generate_errors_code};

struct errors { // as in generate_errors.comp
    uint32_t first_pixel, pixel_count, mask, constant, pixels_each;
};
enum { PIXELS_EACH = 64 };

struct reduction {
    struct vw_buffer *rays, *colours, *views, *scalars;
    struct vw_pass *generate, *reduce;
    struct vw_submission *submission;
    uint32_t capacity; // pixels
};

enum { VIEWS_MAX = 16 };

static struct reduction *open_reduction(uint32_t capacity) {
    struct reduction *r = test_allocate(1, sizeof *r);
    *r = (struct reduction){.rays = test_buffer(test_gpu(), "rays", (uint64_t)capacity * sizeof(struct vw_ray)),
                            .colours = test_buffer(test_gpu(), "colours", (uint64_t)capacity * sizeof(vw_float4)),
                            .views = test_buffer(test_gpu(), "views", VIEWS_MAX * sizeof(struct vw_ray_range)),
                            .scalars = test_buffer(test_gpu(), "scalars", (1 + VIEWS_MAX) * sizeof(vw_float4)),
                            .capacity = capacity};
    const struct vw_binding bindings[] = {{.slot = VW_SLOT_RAYS, .buffer = r->rays},
                                          {.slot = VW_SLOT_COLOURS, .buffer = r->colours},
                                          {.slot = VW_SLOT_VAL_VIEWS, .buffer = r->views},
                                          {.slot = VW_SLOT_FITS, .buffer = r->views}, // not read
                                          {.slot = VW_SLOT_SCALARS, .buffer = r->scalars}};
    struct vw_pass_params params = {
        .shader = &generate_errors, .bindings = bindings, .binding_count = VW_ARRAY_COUNT(bindings)};
    r->generate = test_pass(test_gpu(), params);
    params.shader = &vw_shader_reduce_views;
    r->reduce = test_pass(test_gpu(), params);
    r->submission = test_submission(test_gpu());
    return r;
}

// Makes the errors and sums them as `view_count` views of equal size.
static void reduce(struct reduction *r, const struct errors *errors, uint32_t view_count, vw_float4 sums[VIEWS_MAX]) {
    struct vw_ray_range views[VIEWS_MAX];
    struct vw_push_reduce push = {.count = view_count};
    uint32_t pixels = errors->pixel_count / view_count;
    assert_true(errors->pixel_count <= r->capacity && pixels * view_count == errors->pixel_count &&
                view_count <= VIEWS_MAX);
    for (uint32_t i = 0; i < view_count; i++) views[i] = (struct vw_ray_range){.first = i * pixels, .count = pixels};
    ASSERT_OK(vw_buffer_write(r->views, 0, views, view_count * sizeof *views));
    vw_submission_begin(r->submission);
    vw_submission_dispatch(r->submission, r->generate, errors, sizeof *errors,
                           (errors->pixel_count + PIXELS_EACH - 1) / PIXELS_EACH);
    vw_submission_dispatch(r->submission, r->reduce, &push, sizeof push, 64ull * view_count);
    test_submit(r->submission);
    ASSERT_OK(vw_buffer_read(r->scalars, sizeof *sums, sums, view_count * sizeof *sums));
}

static uint32_t hash(uint32_t word) {
    word *= UINT32_C(2654435761);
    word = (word ^ (word >> 15)) * UINT32_C(2246822519);
    return word ^ (word >> 13);
}

struct exact_sums {
    uint64_t high, low; // squared errors: high 2^-24 + low 2^-48
    uint64_t absolute;  // 2^-24
};

static struct exact_sums sum_exactly(const struct errors *errors, uint32_t first, uint32_t count) {
    uint32_t begin = 3 * (errors->first_pixel + first), mask = errors->mask, constant = errors->constant;
    uint64_t high = 0, low = 0, absolute = 0;
    for (uint32_t i = begin; i - begin < 3 * count; i++) {
        uint64_t error = (hash(i) & mask) | constant, square = error * error;
        high += square >> 24;
        low += square & 0xffffff;
        absolute += error;
    }
    return (struct exact_sums){high, low, absolute};
}

static double squared_sum(const struct exact_sums *sums) {
    return (double)((long double)sums->high * 0x1p-24L + (long double)sums->low * 0x1p-48L);
}
static double absolute_sum(const struct exact_sums *sums) { return (double)sums->absolute * 0x1p-24; }

static void compare_sums(struct hard_finding *finding, uint32_t view, double device_squared, double device_absolute,
                         const struct exact_sums *exact) {
    hard_compare(finding, "squared errors", view, device_squared, squared_sum(exact), squared_sum(exact),
                 SUM_TOLERANCE);
    hard_compare(finding, "absolute errors", view, device_absolute, absolute_sum(exact), absolute_sum(exact),
                 SUM_TOLERANCE);
}

// Sums view by view, as validation takes them, and all of them together in double, as the trainer adds them.
static void check_sums(struct hard_finding *finding, struct reduction *r, const struct errors *errors,
                       uint32_t view_count, double total[2], struct exact_sums *exact_total) {
    vw_float4 sums[VIEWS_MAX];
    uint32_t pixels = errors->pixel_count / view_count;
    reduce(r, errors, view_count, sums);
    for (uint32_t i = 0; i < view_count; i++) {
        struct exact_sums exact = sum_exactly(errors, i * pixels, pixels);
        double device[2] = {(double)sums[i].x + sums[i].y, (double)sums[i].z + sums[i].w};
        compare_sums(finding, i, device[0], device[1], &exact);
        total[0] += device[0];
        total[1] += device[1];
        exact_total->high += exact.high;
        exact_total->low += exact.low;
        exact_total->absolute += exact.absolute;
    }
}

// Checks 12 windows of 2^21 pixels, with --full 48, 300 million errors.
static void errors_of_1e7_pixels(struct hard_finding *finding) {
    enum { WINDOW = 1 << 21 };
    const uint32_t windows = test_is_full() ? 48 : 12;
    struct reduction *r = open_reduction(WINDOW);
    double total[2] = {0};
    struct exact_sums exact = {0};
    for (uint32_t window = 0; window < windows; window++) {
        struct errors errors = {
            .first_pixel = window * WINDOW, .pixel_count = WINDOW, .mask = 0xffffff, .pixels_each = PIXELS_EACH};
        check_sums(finding, r, &errors, window % 3 ? VIEWS_MAX : 4, total, &exact);
    }
    compare_sums(finding, windows, total[0], total[1], &exact);
}

// The most pixels of one view that fit the smallest storage binding of lavapipe, 128 MiB.
enum { LARGEST_VIEW = (128 << 20) / sizeof(struct vw_ray) };

static void check_view(struct hard_finding *finding, struct reduction *r, uint32_t mask, uint32_t constant) {
    struct errors errors = {
        .pixel_count = LARGEST_VIEW, .mask = mask, .constant = constant, .pixels_each = PIXELS_EACH};
    double total[2] = {0};
    struct exact_sums exact = {0};
    check_sums(finding, r, &errors, 1, total, &exact);
}

static void one_view_of_millions_of_pixels(struct hard_finding *finding) {
    struct reduction *r = open_reduction(LARGEST_VIEW);
    check_view(finding, r, 0xffffff, 0);
}

// Checks a single-colour photo before an empty field: every error is the same, and so is the rounding of every
// addition.
static void millions_of_equal_errors(struct hard_finding *finding) {
    static const uint32_t errors[] = {0x9a3b57, 0xffffff, 0x000001};
    struct reduction *r = open_reduction(LARGEST_VIEW);
    for (size_t i = 0; i < VW_ARRAY_COUNT(errors); i++) check_view(finding, r, 0, errors[i]);
}

static const struct hard_case cases[] = {
    {"error sums over 10^7 pixels", "a float stops counting at 2^24", errors_of_1e7_pixels},
    {"one view of 2.8 million pixels", "loops cut short by the driver", one_view_of_millions_of_pixels},
    {"millions of equal errors", "each addition is rounded the same way", millions_of_equal_errors},
};

HARD_CASES("sums", cases)
