// Every pass of splats against the reference, and the gradient of all of them against finite differences of it.
#include "support/cmocka_test.h"

#include "support/gpu_fixture.h"
#include "support/guard_bands.h"
#include "support/splat_bench.h"

static const struct splat_case cases[] = {
    {"all tiles", .seed = 1},
    {"some tiles", .seed = 2, .tiles = TILES_SOME, .degree = 1},
    {"large splats", .seed = 3, .log_scale = -1.5f, .degree = 2, .loss = SPLAT_L1},
    {"as on GPUs", .seed = 4, .as_on_gpus = true, .degree = 1},
    {"as on GPUs, some tiles", .seed = 5, .as_on_gpus = true, .tiles = TILES_SOME, .log_scale = -2.0f},
    {"small", .seed = 6, .log_scale = -4.5f, .degree = 3},
    {"opaque", .seed = 7, .logit = 5.0f, .log_scale = -2.0f, .count = 90},
    {"far camera", .seed = 8, .far_camera = true, .degree = 1},
    {"three views", .seed = 9, .views = 3, .degree = 3},
    {"three views, a walk over tiles", .seed = 14, .views = 3, .tiles = TILES_SOME, .walk_tiles = true},
    {"one view, a walk over tiles", .seed = 15, .tiles = TILES_SOME, .walk_tiles = true},
    {"many pairs", .seed = 10, .count = 700, .log_scale = -2.5f},
    {"polynomial lens", .seed = 11, .lens_terms = DISTORTION_ANY_LENS,
     .lens = {.k1 = 0.3, .k2 = -0.1, .k3 = 0.05, .k4 = 0.5, .k5 = 0.1, .k6 = 0.02, .p1 = -0.01, .p2 = 0.02}},
    {"wide fisheye", .seed = 12, .lens_terms = DISTORTION_ANY_LENS, .log_scale = -1.5f, .wide = true,
     .lens = {.lens = VW_LENS_FISHEYE, .k1 = 0.1, .k2 = -0.05}},
    {"lens with a fold", .seed = 13, .wide = true, .lens_terms = DISTORTION_BASIC, .lens = {.k1 = -0.9}},
};
enum { CASES = sizeof cases / sizeof cases[0] };

// ---- project_splats, emit_pairs, the sort ---------------------------------------------------------------------------

TEST_CASES(shapes_are_those_of_the_reference, index, CASES) {
    struct splat_bench *bench = splat_bench_open(&cases[index]);
    splat_bench_run(bench, false, false);
    const struct vw_splat_shape *shapes = test_read(bench->drawing.shapes);
    double numbers[REFERENCE_SPLAT_NUMBERS];
    for (uint32_t sighting = 0; sighting < bench->count * bench->room.views; sighting++) {
        const struct reference_splat_view view = splat_bench_view(bench, sighting / bench->count);
        struct reference_splat_shape expected;
        splat_bench_splat(bench, sighting % bench->count, numbers);
        reference_splat_project(&view, numbers, &expected);
        const struct vw_splat_shape *shape = &shapes[sighting];
        // Floats of box coordinates carry 6e-8, which a focal length of 40 to 12,000 px turns into 2e-5 to 7e-4 px.
        double px = 2e-4 + (bench->setup->far_camera ? 2e-3 : 0.0);
        assert_near(shape->centre_conic.x, expected.centre[0], px);
        assert_near(shape->centre_conic.y, expected.centre[1], px);
        // The exponentials of scales are good to 1e-6, and squares double it.
        double largest = expected.conic[0] + expected.conic[2];
        assert_near(shape->centre_conic.z, expected.conic[0], 5e-5 * largest);
        assert_near(shape->centre_conic.w, expected.conic[1], 5e-5 * largest);
        assert_near(shape->conic_depth.x, expected.conic[2], 5e-5 * largest);
        assert_near(shape->conic_depth.y, expected.opacity, 1e-4 * expected.opacity + 1e-6);
        assert_near(shape->conic_depth.z, expected.depth, 1e-6 * expected.depth);
    }
}

// Says whether the tile has a pixel that the splat colours; `by` is how far beyond the rim it still asks, in exponents.
static bool colours_tile(const struct splat_bench *bench, const struct vw_splat_shape *shape,
                         const struct vw_splat_tile *tile, double by) {
    double rim = log(255.0 * shape->conic_depth.y) + by;
    for (uint32_t i = 0; i < bench->s.side * bench->s.side; i++) {
        double dx = (tile->corner & 0xffff) * bench->s.side + i % bench->s.side + 0.5 - shape->centre_conic.x;
        double dy = (tile->corner >> 16) * bench->s.side + i / bench->s.side + 0.5 - shape->centre_conic.y;
        double exponent =
            0.5 * (shape->centre_conic.z * dx * dx + shape->conic_depth.x * dy * dy) + shape->centre_conic.w * dx * dy;
        if (exponent <= rim) return true;
    }
    return false;
}

TEST_CASES(every_tile_that_a_splat_colours_has_their_pair, index, CASES) {
    struct splat_bench *bench = splat_bench_open(&cases[index]);
    splat_bench_run(bench, false, false);
    const struct splat_pairs p = splat_bench_pairs(bench);
    uint8_t *found = test_allocate((size_t)bench->count * bench->room.views * bench->tile_count, 1);
    assert_int_equal(p.state.overflow, 0);
    assert_true(p.state.pairs > 0 && p.state.seen > 0);
    for (uint32_t i = 0; i < p.state.pairs; i++)
        found[(size_t)p.seen[p.ranks[p.sorted[i][1]]].sighting * bench->tile_count +
              (p.sorted[i][0] >> VW_SPLAT_DEPTH_BITS)]++;
    uint32_t extra = 0;
    for (uint32_t sighting = 0; sighting < bench->count * bench->room.views; sighting++)
        for (uint32_t tile = 0; tile < bench->tile_count; tile++) {
            uint8_t pairs = found[(size_t)sighting * bench->tile_count + tile];
            bool own =
                bench->tiles[tile].view == sighting / bench->count && p.shapes[sighting].conic_depth.y >= 1.0f / 255.0f;
            bool must = own && colours_tile(bench, &p.shapes[sighting], &bench->tiles[tile], 0.0);
            assert_true(pairs <= 1 && (own || !pairs));
            if (must && !pairs) fail_msg("%s: sighting %u lacks tile %u", cases[index].name, sighting, tile);
            extra += pairs && !must;
        }
    // The least exponent lies between pixels, so that some tiles are listed of which no pixel is coloured.
    if (extra > p.state.pairs / 4) fail_msg("%u of %u pairs colour nothing", extra, p.state.pairs);
}

TEST_CASES(pairs_are_sorted_by_tile_and_depth_and_are_stable, index, CASES) {
    struct splat_bench *bench = splat_bench_open(&cases[index]);
    splat_bench_run(bench, false, false);
    const struct splat_pairs p = splat_bench_pairs(bench);
    uint8_t *met = test_allocate(p.state.pairs, 1);
    for (uint32_t i = 0; i < p.state.pairs; i++) {
        assert_true(p.sorted[i][1] < p.state.pairs && !met[p.sorted[i][1]]++);
        if (!i) continue;
        assert_true(p.sorted[i - 1][0] < p.sorted[i][0] ||
                    (p.sorted[i - 1][0] == p.sorted[i][0] && p.sorted[i - 1][1] < p.sorted[i][1]));
        if (p.sorted[i - 1][0] >> VW_SPLAT_DEPTH_BITS != p.sorted[i][0] >> VW_SPLAT_DEPTH_BITS) continue;
        float near = p.shapes[p.seen[p.ranks[p.sorted[i - 1][1]]].sighting].conic_depth.z;
        float far = p.shapes[p.seen[p.ranks[p.sorted[i][1]]].sighting].conic_depth.z;
        assert_true(near <= far * 1.00002f);
    }
    uint32_t next = 0; // pairs of a splat stand together, in the order of splats
    for (uint32_t rank = 0; rank < p.state.seen; rank++) {
        assert_int_equal(p.seen[rank].first_pair, next);
        assert_true(rank == 0 || p.seen[rank].sighting > p.seen[rank - 1].sighting);
        for (uint32_t i = 0; i < p.seen[rank].pairs; i++) assert_int_equal(p.ranks[next++], rank);
    }
    assert_int_equal(next, p.state.pairs);
}

// ---- blend_tiles, slope_pixels, blend_tiles_back -------------------------------------------------------------------

struct tile_list {
    uint32_t *order, count; // ranks
    uint32_t *pairs;
};

static void list_tile(struct splat_bench *bench, uint32_t tile, struct tile_list *list) {
    const struct splat_pairs p = splat_bench_pairs(bench);
    list->order = test_allocate(p.state.pairs + 1, sizeof *list->order);
    list->pairs = test_allocate(p.state.pairs + 1, sizeof *list->pairs);
    list->count = 0;
    for (uint32_t i = 0; i < p.state.pairs; i++)
        if (p.sorted[i][0] >> VW_SPLAT_DEPTH_BITS == tile) {
            list->order[list->count] = p.ranks[p.sorted[i][1]];
            list->pairs[list->count++] = p.sorted[i][1];
        }
}

// Reads what is drawn, as the reference has it, so that passes after it are judged alone.
static struct reference_splat_shape *drawn_shapes(struct splat_bench *bench, uint32_t seen) {
    const float(*drawn)[12] = test_read(bench->drawing.drawn);
    struct reference_splat_shape *shapes = test_allocate(seen + 1, sizeof *shapes);
    for (uint32_t rank = 0; rank < seen; rank++)
        shapes[rank] = (struct reference_splat_shape){.shown = true,
                                                      .centre = {drawn[rank][0], drawn[rank][1]},
                                                      .conic = {drawn[rank][2], drawn[rank][3], drawn[rank][4]},
                                                      .opacity = drawn[rank][5],
                                                      .rgb = {drawn[rank][6], drawn[rank][7], drawn[rank][8]}};
    return shapes;
}

TEST_CASES(colours_are_those_of_the_reference, index, CASES) {
    struct splat_bench *bench = splat_bench_open(&cases[index]);
    splat_bench_run(bench, false, false);
    const struct reference_splat_shape *shapes = drawn_shapes(bench, splat_bench_state(bench).seen);
    const float(*colours)[4] = test_read(bench->drawing.colours);
    uint32_t pixels = bench->s.side * bench->s.side;
    uint32_t flips = 0;
    for (uint32_t tile = 0; tile < bench->tile_count; tile++) {
        const size_t before = test_owned();
        struct tile_list list;
        list_tile(bench, tile, &list);
        uint8_t *fates = test_allocate(list.count + 1, 1);
        for (uint32_t ray = tile * pixels; ray < (tile + 1) * pixels; ray++) {
            double x, y, rgb[3], left;
            splat_bench_pixel(bench, ray, &x, &y);
            reference_splat_pixel(shapes, list.order, list.count, x, y, false, fates, rgb, &left);
            // A splat that is next to 1/255 may be drawn here and not there: 0.004 of a colour up to 3.
            bool near = fabs(colours[ray][3] - left) <= 2e-5;
            for (int c = 0; c < 3; c++) near = near && fabs(colours[ray][c] - rgb[c]) <= 5e-5;
            flips += !near;
            for (int c = 0; c < 3; c++) assert_near(colours[ray][c], rgb[c], 0.02);
            assert_near(colours[ray][3], left, 0.01);
        }
        test_release_to(before);
    }
    if (flips > bench->ray_count / 200) fail_msg("%u of %u pixels differ", flips, bench->ray_count);
}

TEST_CASES(sums_of_pairs_are_those_of_the_reference, index, CASES) {
    if (cases[index].views > 1) return;
    struct splat_bench *bench = splat_bench_open(&cases[index]);
    splat_bench_run(bench, true, false);
    const struct reference_splat_shape *shapes = drawn_shapes(bench, splat_bench_state(bench).seen);
    const float(*d_colours)[4] = test_read(bench->gradient.d_colours);
    const float(*d_pairs)[12] = test_read(bench->gradient.d_pairs);
    uint32_t pixels = bench->s.side * bench->s.side, compared = 0, off = 0;
    for (uint32_t tile = 0; tile < bench->tile_count; tile++) {
        const size_t before = test_owned();
        struct tile_list list;
        list_tile(bench, tile, &list);
        uint8_t *fates = test_allocate(list.count + 1, 1);
        struct reference_splat_sums *sums = test_allocate(list.count + 1, sizeof *sums);
        for (uint32_t ray = tile * pixels; ray < (tile + 1) * pixels; ray++) {
            double x, y, rgb[3], left, slope[4];
            for (int c = 0; c < 4; c++) slope[c] = d_colours[ray][c];
            splat_bench_pixel(bench, ray, &x, &y);
            reference_splat_pixel(shapes, list.order, list.count, x, y, false, fates, rgb, &left);
            reference_splat_pixel_back(shapes, list.order, list.count, x, y, fates, slope, sums);
        }
        for (uint32_t i = 0; i < list.count; i++) {
            const float *d = d_pairs[list.pairs[i]];
            const double expected[9] = {sums[i].q,   sums[i].qx,     sums[i].qy,     sums[i].qxx,   sums[i].qxy,
                                        sums[i].qyy, sums[i].rgb[0], sums[i].rgb[1], sums[i].rgb[2]};
            for (int k = 0; k < 9; k++) {
                // Slopes are up to 2/3; moments grow with distances up to 16 px, squared. Errors of 1e-7 of what is
                // left are divided by 1 - alpha, at least 0.01.
                double reach = k < 1 || k > 5 ? 1.0 : k < 3 ? 16.0 : 256.0;
                compared++;
                off += fabs(d[k] - expected[k]) > 2e-4 * reach + 1e-3 * fabs(expected[k]);
            }
        }
        test_release_to(before);
    }
    if (off > compared / 500) fail_msg("%s: %u of %u sums differ", cases[index].name, off, compared); // next to 1/255
}

TEST(losses_and_slopes_are_of_what_is_seen) {
    struct splat_bench *bench = splat_bench_open(&cases[0]);
    splat_bench_run(bench, true, false);
    const float(*colours)[4] = test_read(bench->drawing.colours);
    const float(*d_colours)[4] = test_read(bench->gradient.d_colours);
    const float *losses = test_read(bench->ray_loss);
    const double backdrop[3] = {0.2, 0.7, 0.4};
    for (uint32_t ray = 0; ray < bench->ray_count; ray++) {
        const vw_float4 t = bench->rays[ray].target_weight;
        const double target[3] = {t.x, t.y, t.z};
        double loss = 0.0, by_left = 0.0;
        for (int c = 0; c < 3; c++) {
            double error = colours[ray][c] + colours[ray][3] * backdrop[c] - target[c];
            loss += t.w / 3.0 * error * error;
            by_left += t.w * 2.0 / 3.0 * error * backdrop[c];
            assert_near(d_colours[ray][c], t.w * 2.0 / 3.0 * error, 1e-6);
        }
        assert_near(losses[ray], loss, 2e-6);
        assert_near(d_colours[ray][3], by_left, 1e-6);
    }
}

TEST_GROUP(NULL, test_gpu_close)
