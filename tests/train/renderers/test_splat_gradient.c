// The gradient of splats against finite differences of the reference, with lists, order and cut-offs held; the
// optimiser against plain Adam; and what must leave splats alone.
#include "support/cmocka_test.h"

#include "support/gpu_fixture.h"
#include "support/splat_bench.h"

static const struct splat_case cases[] = {
    {"degree 0", .seed = 21},
    {"degree 1", .seed = 22, .degree = 1},
    {"degree 3, some tiles", .seed = 23, .degree = 3, .tiles = TILES_SOME},
    {"large splats", .seed = 24, .log_scale = -1.5f},
    {"as on GPUs", .seed = 25, .degree = 2, .as_on_gpus = true},
    {"small", .seed = 26, .log_scale = -4.5f},
    {"opaque", .seed = 27, .logit = 4.0f, .log_scale = -2.0f},
    {"far camera", .seed = 28, .far_camera = true, .degree = 1},
    {"beside the photo", .seed = 29, .width_px = 13, .height_px = 11, .log_scale = -1.5f},
    {"barrel lens", .seed = 30, .degree = 1, .lens_terms = DISTORTION_BASIC,
     .lens = {.k1 = -0.3, .k2 = 0.08, .p1 = 0.02, .p2 = -0.015}},
    {"pincushion lens", .seed = 31, .lens_terms = DISTORTION_BASIC, .log_scale = -2.0f, .lens = {.k1 = 0.4, .k2 = 0.2}},
    {"rational lens", .seed = 32, .lens_terms = DISTORTION_ANY_LENS, .log_scale = -2.0f,
     .lens = {.k1 = 0.3, .k2 = -0.1, .k3 = 0.05, .k4 = 0.5, .k5 = 0.1, .k6 = 0.02, .p1 = -0.01, .p2 = 0.02}},
    {"fisheye", .seed = 33, .degree = 1, .lens_terms = DISTORTION_ANY_LENS,
     .lens = {.lens = VW_LENS_FISHEYE, .k1 = -0.04, .k2 = 0.02, .k3 = -0.01, .k4 = 0.003}},
    {"wide fisheye", .seed = 34, .lens_terms = DISTORTION_ANY_LENS, .log_scale = -1.5f, .wide = true,
     .lens = {.lens = VW_LENS_FISHEYE, .k1 = 0.1, .k2 = -0.05}},
    {"lens beside the photo", .seed = 35, .width_px = 13, .height_px = 11, .log_scale = -1.5f,
     .lens_terms = DISTORTION_BASIC, .lens = {.k1 = -0.2, .k2 = 0.05, .p1 = 0.02}},
    {"lens with a fold", .seed = 36, .log_scale = -2.0f, .wide = true, .lens_terms = DISTORTION_BASIC,
     .lens = {.k1 = -0.9}},
};
enum { CASES = sizeof cases / sizeof cases[0] };

// ---- The gradient --------------------------------------------------------------------------------------------------

// The loss in double, by splats, with all decisions held.
struct frozen {
    struct splat_bench *bench;
    struct reference_splat_view view;
    struct reference_splat_shape *shapes; // by rank
    const struct vw_splat_seen *seen;
    uint32_t **order, *counts; // per tile: ranks
    uint8_t **fates;           // per ray
};

static double ray_loss(const struct frozen *f, uint32_t ray, bool held) {
    const double backdrop[3] = {0.2, 0.7, 0.4};
    uint32_t tile = ray / (f->bench->s.side * f->bench->s.side);
    double x, y, colour[3], left, loss = 0.0;
    splat_bench_pixel(f->bench, ray, &x, &y);
    reference_splat_pixel(f->shapes, f->order[tile], f->counts[tile], x, y, held, f->fates[ray], colour, &left);
    const vw_float4 t = f->bench->rays[ray].target_weight;
    const double target[3] = {t.x, t.y, t.z};
    for (int c = 0; c < 3; c++) {
        double error = colour[c] + left * backdrop[c] - target[c];
        loss += t.w / 3.0 * error * error;
    }
    return loss;
}

static struct frozen freeze(struct splat_bench *bench) {
    struct frozen f = {.bench = bench, .view = splat_bench_view(bench, 0)};
    const struct splat_pairs p = splat_bench_pairs(bench);
    double numbers[REFERENCE_SPLAT_NUMBERS];
    f.seen = p.seen;
    f.shapes = test_allocate(p.state.seen, sizeof *f.shapes);
    for (uint32_t rank = 0; rank < p.state.seen; rank++) {
        splat_bench_splat(bench, f.seen[rank].sighting, numbers);
        reference_splat_project(&f.view, numbers, &f.shapes[rank]);
    }
    f.order = test_allocate(bench->tile_count, sizeof *f.order);
    f.counts = test_allocate(bench->tile_count, sizeof *f.counts);
    f.fates = test_allocate(bench->ray_count, sizeof *f.fates);
    for (uint32_t tile = 0; tile < bench->tile_count; tile++)
        f.order[tile] = test_allocate(p.state.pairs, sizeof **f.order);
    for (uint32_t i = 0; i < p.state.pairs; i++) {
        uint32_t tile = p.sorted[i][0] >> VW_SPLAT_DEPTH_BITS;
        f.order[tile][f.counts[tile]++] = p.ranks[p.sorted[i][1]];
    }
    uint32_t pixels = bench->s.side * bench->s.side;
    for (uint32_t ray = 0; ray < bench->ray_count; ray++) {
        f.fates[ray] = test_allocate(f.counts[ray / pixels] + 1, 1);
        ray_loss(&f, ray, false);
    }
    return f;
}

// Returns the loss of the tiles that have the splat, with one of its numbers moved.
static double moved_loss(struct frozen *f, uint32_t rank, uint32_t number, double by) {
    double numbers[REFERENCE_SPLAT_NUMBERS], loss = 0.0;
    const struct reference_splat_shape before = f->shapes[rank];
    uint32_t pixels = f->bench->s.side * f->bench->s.side;
    splat_bench_splat(f->bench, f->seen[rank].sighting, numbers);
    numbers[number] += by;
    reference_splat_project(&f->view, numbers, &f->shapes[rank]);
    for (uint32_t tile = 0; tile < f->bench->tile_count; tile++) {
        bool has = false;
        for (uint32_t i = 0; i < f->counts[tile]; i++) has = has || f->order[tile][i] == rank;
        for (uint32_t ray = tile * pixels; has && ray < (tile + 1) * pixels; ray++) loss += ray_loss(f, ray, true);
    }
    f->shapes[rank] = before;
    return loss;
}

static float largest_of(const struct splat_bench *bench, const float (*d_splats)[4], uint32_t seen, uint32_t number) {
    float most = 0.0f;
    for (uint32_t rank = 0; rank < seen; rank++)
        most = fmaxf(most, fabsf(d_splats[(size_t)number / 4 * bench->room.splats + rank][number % 4]));
    return most;
}

TEST_CASES(gradients_are_those_of_finite_differences, index, CASES) {
    struct splat_bench *bench = splat_bench_open(&cases[index]);
    splat_bench_run(bench, true, false);
    const struct vw_splat_state state = splat_bench_state(bench);
    const float(*d_splats)[4] = test_read(bench->gradient.d_splats);
    struct frozen f = freeze(bench);
    uint32_t compared = 0, stride = test_is_full() ? 1 : 5;
    for (uint32_t number = 0; number < 4 * bench->columns; number++) {
        if (number / 4 != SPLAT_MEAN && number / 4 != SPLAT_TURN && number % 4 == 3) continue; // unused
        float largest = largest_of(bench, d_splats, state.seen, number);
        for (uint32_t rank = number % stride; rank < state.seen; rank += stride) {
            const double h = cases[index].far_camera ? 1e-6 : 1e-5;
            double expected = (moved_loss(&f, rank, number, h) - moved_loss(&f, rank, number, -h)) / (2.0 * h);
            double gradient = d_splats[(size_t)number / 4 * bench->room.splats + rank][number % 4];
            // Pixels next to 1/255 count here and not there; sums over pixels cancel. Far cameras magnify rounding.
            double slack = cases[index].far_camera ? 1e-2 : 2e-3;
            if (fabs(gradient - expected) > slack * (double)largest + 0.01 * fabs(expected))
                fail_msg("%s: number %u of rank %u: %.6g, not %.6g; largest %.6g", cases[index].name, number, rank,
                         gradient, expected, (double)largest);
            compared++;
        }
    }
    assert_true(compared > 100);
}

// ---- The optimiser -------------------------------------------------------------------------------------------------

static double rate_of(const struct vw_push_splat_update *by, uint32_t column, uint32_t lane) {
    switch (column) {
    case SPLAT_MEAN: return lane == 3 ? by->opacity : by->mean;
    case SPLAT_SCALE: return lane == 3 ? 0.0f : by->scale;
    case SPLAT_TURN: return by->turn;
    default: return lane == 3 ? 0.0f : column == SPLAT_HARMONICS ? by->colour : by->harmonics;
    }
}

// In the third case the first harmonics come into use at the second step, and their steps count from there.
TEST_CASES(splats_move_by_their_own_adam, index, 3) {
    const struct splat_case setup = {"adam", .seed = 31, .degree = 1, .tiles = TILES_SOME, .momentum = index == 1};
    struct splat_bench *bench = splat_bench_open(&setup);
    const struct vw_push_splat_update by = splat_bench_update(bench);
    size_t count = (size_t)4 * bench->columns * bench->room.splats;
    double *m1 = test_allocate(count, sizeof *m1), *m2 = test_allocate(count, sizeof *m2);
    uint32_t *visits = test_allocate(bench->count, sizeof *visits), moved = 0;
    uint32_t *without = test_allocate(bench->count, sizeof *without); // visits before there were harmonics
    for (int step = 0; step < 4; step++) {
        bench->push.degree = index == 2 && step == 0 ? 0 : 1;
        bench->push.tile_count = step == 2 ? bench->tile_count / 2 : bench->tile_count; // some splats are not seen
        splat_bench_run(bench, true, true);
        const struct vw_splat_state state = splat_bench_state(bench);
        const struct vw_splat_seen *seen = test_read(bench->drawing.seen);
        const float(*d)[4] = test_read(bench->gradient.d_splats);
        const float(*after)[4] = test_read(bench->param_buffer);
        uint8_t *touched = test_allocate(bench->count, 1);
        for (uint32_t rank = 0; rank < state.seen; rank++) {
            if (d[SPLAT_SCALE * bench->room.splats + rank][3] == 0.0f) continue;
            uint32_t splat = seen[rank].sighting, used = VW_SPLAT_COLUMNS(bench->push.degree);
            visits[splat]++;
            without[splat] += used < bench->columns;
            touched[splat] = 1;
            moved++;
            for (uint32_t column = 0; column < used; column++)
                for (uint32_t lane = 0; lane < 4; lane++) {
                    uint32_t v = visits[splat] - (column > SPLAT_HARMONICS ? without[splat] : 0);
                    size_t at = (size_t)column * bench->room.splats + splat;
                    double g = d[column * bench->room.splats + rank][lane] * (double)bench->s.run.inverse_rays;
                    double *first = &m1[4 * at + lane], *second = &m2[4 * at + lane];
                    *first = setup.momentum ? 0.9 * *first + 0.1 * g : g;
                    *second = 0.999 * *second + 0.001 * g * g;
                    double direction = setup.momentum ? *first / (1.0 - pow(0.9, v)) : g;
                    double step_by =
                        rate_of(&by, column, lane) * direction / (sqrt(*second / (1.0 - pow(0.999, v))) + 1e-15);
                    double before = *splat_bench_number(bench, splat, column, lane);
                    // 1 - 0.999^n in floats is off by 6e-5 of itself; params of up to 3 carry 2e-7.
                    assert_near(after[at][lane], before - step_by, 1e-3 * fabs(step_by) + 4e-7);
                }
        }
        for (uint32_t splat = 0; splat < bench->count; splat++)
            for (uint32_t column = 0; column < bench->columns && !touched[splat]; column++)
                for (uint32_t lane = 0; lane < 4; lane++)
                    assert_true(after[(size_t)column * bench->room.splats + splat][lane] ==
                                *splat_bench_number(bench, splat, column, lane));
        memcpy(bench->params, after, count * sizeof(float));
    }
    assert_true(moved > 40);
}

// ---- What leaves splats alone --------------------------------------------------------------------------------------

static void assert_skipped(struct splat_bench *bench, bool overflow) {
    splat_bench_run(bench, true, true);
    const struct vw_step_state *step = test_read(bench->step_state);
    assert_int_equal(step->nonfinite, 1);
    assert_int_equal(splat_bench_state(bench).overflow, overflow);
    const float *after = test_read(bench->param_buffer);
    assert_memory_equal(after, bench->params, vw_splat_param_bytes(&bench->room));
    const float *moments = test_read(bench->gradient.moment2);
    for (size_t i = 0; i < vw_splat_param_bytes(&bench->room) / 4; i++) assert_true(moments[i] == 0.0f);
}

TEST(more_pairs_than_have_room_skip_the_step) {
    const struct splat_case full = {"full", .seed = 41}, setup = {"overflow", .seed = 41, .pairs = 1};
    struct splat_bench *bench = splat_bench_open(&full);
    splat_bench_run(bench, false, false);
    uint32_t pairs = splat_bench_state(bench).pairs;
    struct splat_case exact = full, less = setup;
    exact.pairs = pairs;
    less.pairs = pairs - 1;
    bench = splat_bench_open(&exact);
    splat_bench_run(bench, true, true);
    assert_int_equal(splat_bench_state(bench).overflow, 0);
    assert_int_equal(splat_bench_state(bench).pairs, pairs);
    assert_skipped(splat_bench_open(&less), true);
    assert_skipped(splat_bench_open(&setup), true);
}

TEST(a_target_that_is_not_finite_skips_the_step) {
    struct splat_bench *bench = splat_bench_open(&(struct splat_case){"target", .seed = 42});
    bench->rays[77].target_weight = (vw_float4){NAN, 0.5f, 0.5f, 1.0f};
    ASSERT_OK(vw_buffer_write(bench->ray_buffer, 0, bench->rays, bench->ray_count * sizeof *bench->rays));
    assert_skipped(bench, false);
}

TEST_GROUP(NULL, test_gpu_close)
