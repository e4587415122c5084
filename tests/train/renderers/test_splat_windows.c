// SSIM as a part of the loss of splats: losses and gradients against the reference in double and its finite
// differences, on squares with masks and at the photo's rim; constant squares; and pixels that do not count.
#include "support/cmocka_test.h"

#include "reference/reference.h"
#include "support/gpu_fixture.h"
#include "support/splat_bench.h"

enum { SIDE = VW_SPLAT_SQUARE, PIXELS = SIDE * SIDE };
static const double BACKDROP[3] = {0.2, 0.7, 0.4};

static const struct splat_case cases[] = {
    {"a share", .seed = 51, .ssim_weight = 0.2f, .tiles = SQUARES_SOME},
    {"alone, large splats", .seed = 52, .ssim_weight = 1.0f, .tiles = SQUARES_SOME, .log_scale = -1.5f, .width_px = 60},
    {"as on GPUs", .seed = 53, .ssim_weight = 0.7f, .tiles = SQUARES_SOME, .as_on_gpus = true, .loss = SPLAT_L1},
    {"uncertain", .seed = 55, .ssim_weight = 0.4f, .tiles = SQUARES_SOME, .uncertain = true},
    {"uncertain, without windows", .seed = 56, .tiles = SQUARES_SOME, .uncertain = true, .loss = SPLAT_L1},
    {"a narrow photo", .seed = 54, .ssim_weight = 0.5f, .tiles = SQUARES_SOME, .width_px = 5, .height_px = 35},
};
enum { CASES = sizeof cases / sizeof cases[0] };

struct square {
    uint32_t column, row;
    int64_t rays[PIXELS]; // -1: none
    struct reference_splat_square channels[3];
};

static double seen_of(const float colour[4], int channel) { return colour[channel] + colour[3] * BACKDROP[channel]; }

static struct square *find_square(struct square *squares, uint32_t *count, uint32_t column, uint32_t row) {
    for (uint32_t i = 0; i < *count; i++)
        if (squares[i].column == column && squares[i].row == row) return &squares[i];
    struct square *added = &squares[(*count)++];
    *added = (struct square){.column = column, .row = row};
    for (uint32_t i = 0; i < PIXELS; i++) added->rays[i] = -1;
    return added;
}

// Collects what was drawn, square by square, by the place of each ray alone.
static struct square *collect(struct splat_bench *bench, uint32_t *count) {
    const float(*colours)[4] = test_read(bench->drawing.colours);
    struct square *squares = test_allocate(bench->tile_count, sizeof *squares);
    *count = 0;
    for (uint32_t ray = 0; ray < bench->ray_count; ray++) {
        double x_px, y_px;
        splat_bench_pixel(bench, ray, &x_px, &y_px);
        uint32_t x = (uint32_t)x_px, y = (uint32_t)y_px;
        struct square *square = find_square(squares, count, x / SIDE, y / SIDE);
        uint32_t place = y % SIDE * SIDE + x % SIDE;
        const vw_float4 t = bench->rays[ray].target_weight;
        const float photo[3] = {t.x, t.y, t.z};
        square->rays[place] = ray;
        for (int c = 0; c < 3; c++) {
            square->channels[c].weight[place] = t.w;
            square->channels[c].seen[place] = seen_of(colours[ray], c);
            square->channels[c].photo[place] = photo[c];
        }
    }
    return squares;
}

// Returns a channel's share of the loss by its difference at a pixel, and its slope.
static double plain_loss(const struct splat_bench *bench, const struct reference_splat_square *of, uint32_t place,
                         double *slope) {
    double error = of->seen[place] - of->photo[place], weight = of->weight[place] / 3.0;
    bool square = bench->s.run.loss == LOSS_L2;
    *slope = weight * (square ? 2.0 * error : error > 0.0 ? 1.0 : -1.0);
    return weight * (square ? error * error : fabs(error));
}

// Returns how much the window of a pixel counts.
static double certainty_at(const struct splat_bench *bench, const struct square *square, uint32_t place) {
    return square->rays[place] < 0 ? 0.0 : splat_bench_certainty(bench, (uint32_t)square->rays[place]);
}

// Checks losses, and the gradients by what rays count: of the loss, and of the cost of doubt.
static void check_losses(struct splat_bench *bench, const struct square *square, const float *losses) {
    static double windows[3][PIXELS];
    const float(*ray_weights)[2] = bench->ray_weights ? test_read(bench->ray_weights) : NULL;
    double share = bench->s.ssim_weight, slope, certain_loss = reference_certain_loss(&bench->s.run, 0);
    for (int c = 0; c < 3; c++) reference_splat_windows(&square->channels[c], windows[c]);
    for (uint32_t i = 0; i < PIXELS; i++) {
        double plain = 0.0, certain = certainty_at(bench, square, i), weight = square->channels[0].weight[i];
        if (square->rays[i] < 0) continue;
        for (int c = 0; c < 3; c++)
            plain += (1.0 - share) * plain_loss(bench, &square->channels[c], i, &slope) + share / 3.0 * windows[c][i];
        assert_near(losses[square->rays[i]], certain * plain - (ray_weights ? weight * certain_loss * log(certain) : 0),
                    1e-5);
        if (ray_weights)
            assert_near(ray_weights[square->rays[i]][1], plain - weight * certain_loss / certain,
                        1e-5 + 1e-6 / certain);
    }
}

// Returns the loss of a channel's windows, as much as each counts.
static double window_loss(const struct splat_bench *bench, const struct square *square,
                          const struct reference_splat_square *channel) {
    static double losses[PIXELS];
    double sum = 0.0;
    reference_splat_windows(channel, losses);
    for (uint32_t i = 0; i < PIXELS; i++) sum += certainty_at(bench, square, i) * losses[i];
    return sum;
}

static void check_gradient(struct splat_bench *bench, const struct square *square, const float (*d_colours)[4]) {
    const double h = 1e-5, share = bench->s.ssim_weight;
    for (uint32_t i = 0; i < PIXELS; i += test_is_full() ? 1 : 5) {
        double by_left = 0.0;
        for (int c = 0; c < 3 && square->rays[i] >= 0; c++) {
            struct reference_splat_square moved = square->channels[c];
            double slope, ahead;
            moved.seen[i] += h;
            ahead = window_loss(bench, square, &moved);
            moved.seen[i] -= 2.0 * h;
            double window = (ahead - window_loss(bench, square, &moved)) / (2.0 * h) / 3.0;
            plain_loss(bench, &square->channels[c], i, &slope);
            double expected = (1.0 - share) * certainty_at(bench, square, i) * slope + share * window;
            by_left += expected * BACKDROP[c];
            assert_near(d_colours[square->rays[i]][c], expected, 2e-5 + 2e-4 * fabs(expected));
        }
        if (square->rays[i] >= 0) assert_near(d_colours[square->rays[i]][3], by_left, 4e-5 + 2e-4 * fabs(by_left));
    }
}

TEST_CASES(losses_and_gradients_are_those_of_the_reference, index, CASES) {
    struct splat_bench *bench = splat_bench_open(&cases[index]);
    splat_bench_run(bench, true, false);
    const float *losses = test_read(bench->ray_loss);
    const float(*d_colours)[4] = test_read(bench->gradient.d_colours);
    uint32_t count;
    const struct square *squares = collect(bench, &count);
    assert_true(count >= 2);
    for (uint32_t i = 0; i < count; i++) {
        check_losses(bench, &squares[i], losses);
        check_gradient(bench, &squares[i], d_colours);
    }
}

// The means alone count where nothing varies, and nothing is divided by 0.
TEST(constant_squares_are_compared_by_their_means) {
    struct splat_case setup = cases[1];
    setup.count = 1;
    setup.logit = -20.0f;
    struct splat_bench *bench = splat_bench_open(&setup);
    for (uint32_t i = 0; i < bench->ray_count; i++)
        bench->rays[i].target_weight = (vw_float4){0.2f, 0.6f, 0.0f, bench->rays[i].target_weight.w};
    ASSERT_OK(vw_buffer_write(bench->ray_buffer, 0, bench->rays, bench->ray_count * sizeof *bench->rays));
    splat_bench_run(bench, true, false);
    const float *losses = test_read(bench->ray_loss);
    const float(*d_colours)[4] = test_read(bench->gradient.d_colours);
    double green = 1.0 - (2 * 0.7 * 0.6 + 1e-4) / (0.7 * 0.7 + 0.6 * 0.6 + 1e-4),
           blue = 1.0 - 1e-4 / (0.4 * 0.4 + 1e-4);
    for (uint32_t i = 0; i < bench->ray_count; i++) {
        double weight = bench->rays[i].target_weight.w;
        assert_near(losses[i], weight * (green + blue) / 3.0, 2e-4); // floats of means, over C2
        assert_near(d_colours[i][0], 0.0, 2e-3);
    }
}

// Nothing depends on the photo where a pixel does not count; 0 may be -0 there.
TEST(pixels_that_do_not_count_change_nothing) {
    struct splat_bench *bench = splat_bench_open(&cases[0]);
    splat_bench_run(bench, true, false);
    const float *losses = test_read(bench->ray_loss), *slopes = test_read(bench->gradient.d_colours);
    uint32_t hidden = 0;
    for (uint32_t i = 0; i < bench->ray_count; i++) {
        if (bench->rays[i].target_weight.w > 0.0f) continue;
        bench->rays[i].target_weight = (vw_float4){1.0f, 0.0f, 0.25f, 0.0f};
        hidden++;
    }
    ASSERT_OK(vw_buffer_write(bench->ray_buffer, 0, bench->rays, bench->ray_count * sizeof *bench->rays));
    splat_bench_run(bench, true, false);
    assert_true(hidden > 50 && hidden < bench->ray_count - 50);
    const float *losses_after = test_read(bench->ray_loss), *slopes_after = test_read(bench->gradient.d_colours);
    for (uint32_t i = 0; i < bench->ray_count; i++) assert_true(losses_after[i] == losses[i]);
    for (uint32_t i = 0; i < 4 * bench->ray_count; i++) assert_true(slopes_after[i] == slopes[i]);
}

TEST(a_share_of_0_has_no_pass) {
    struct splat_case plain = cases[0];
    plain.ssim_weight = 0.0f;
    struct splat_bench *bench = splat_bench_open(&plain);
    assert_null(bench->gradient.windows);
    assert_null(bench->gradient.d_windows);
}

TEST_GROUP(NULL, test_gpu_close)
