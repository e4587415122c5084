// Splats as strangers' files and unlucky steps have them. Colours and gradients stay finite, what cannot be shown is
// not listed, and all bits are equal in every run.
#include "support/cmocka_test.h"

#include "support/gpu_fixture.h"
#include "support/splat_bench.h"

// Puts a splat before the camera's middle, at a distance from it.
static void place(struct splat_bench *bench, uint32_t splat, float depth) {
    const struct vw_gpu_camera *c = &bench->cameras[0];
    const float back[3] = {c->back.x, c->back.y, c->back.z}, eye[3] = {c->reference.x, c->reference.y, c->reference.z};
    for (uint32_t i = 0; i < 3; i++) *splat_bench_number(bench, splat, SPLAT_MEAN, i) = eye[i] - depth * back[i];
}

static void set(struct splat_bench *bench, uint32_t splat, uint32_t column, float x, float y, float z) {
    const float values[3] = {x, y, z};
    for (uint32_t i = 0; i < 3; i++) *splat_bench_number(bench, splat, column, i) = values[i];
}

// Runs a step, of which all results must be finite.
static void run_soundly(struct splat_bench *bench) {
    splat_bench_write(bench);
    splat_bench_run(bench, true, true);
    const struct vw_step_state *step = test_read(bench->step_state);
    const struct vw_splat_state state = splat_bench_state(bench);
    assert_int_equal(step->nonfinite, 0);
    assert_int_equal(state.overflow, 0);
    const float *colours = test_read(bench->drawing.colours);
    for (size_t i = 0; i < (size_t)4 * bench->ray_count; i++) assert_true(isfinite(colours[i]));
    const float(*d_splats)[4] = test_read(bench->gradient.d_splats);
    for (uint32_t column = 0; column < bench->columns; column++)
        for (uint32_t rank = 0; rank < state.seen; rank++)
            for (uint32_t i = 0; i < 4; i++)
                assert_true(isfinite(d_splats[(size_t)column * bench->room.splats + rank][i]));
}

static uint32_t pairs_of(struct splat_bench *bench, uint32_t splat) {
    const struct vw_splat_seen *seen = test_read(bench->drawing.seen);
    const struct vw_splat_state state = splat_bench_state(bench);
    for (uint32_t rank = 0; rank < state.seen; rank++)
        if (seen[rank].sighting == splat) return seen[rank].pairs;
    return 0;
}

static struct splat_bench *open_few(void) {
    return splat_bench_open(&(struct splat_case){"few", .seed = 51, .count = 12, .degree = 1});
}

TEST(near_plane_and_beyond) {
    struct splat_bench *bench = open_few();
    const float depths[] = {-1.0f, 0.0f, 0.0199f, 0.0201f, 0.03f, 1.0f, 1e5f, INFINITY, NAN};
    for (uint32_t i = 0; i < 9; i++) {
        place(bench, i, depths[i]);
        *splat_bench_number(bench, i, SPLAT_MEAN, 3) = 1.0f;
    }
    run_soundly(bench);
    for (uint32_t i = 0; i < 9; i++) assert_int_equal(pairs_of(bench, i) > 0, i >= 3 && i <= 6);
}

// Beyond its fold a lens would show what lies beside the photo in its middle.
TEST(what_is_beyond_the_fold_of_a_lens_is_not_shown) {
    const struct {
        struct vw_camera lens;
        float within, beyond; // x / z
    } lenses[] = {{{.k1 = -0.9}, 0.5f, 0.9f}, {{.lens = VW_LENS_FISHEYE, .k1 = -0.3}, 1.5f, 3.0f}};
    for (uint32_t i = 0; i < 2; i++) {
        struct splat_bench *bench = splat_bench_open(&(struct splat_case){
            "fold", .seed = 52, .count = 3, .wide = true, .lens_terms = DISTORTION_ANY_LENS, .lens = lenses[i].lens});
        const struct vw_gpu_camera *c = &bench->cameras[0];
        const float right[3] = {c->right.x, c->right.y, c->right.z};
        for (uint32_t splat = 0; splat < 3; splat++) {
            place(bench, splat, 1.0f);
            *splat_bench_number(bench, splat, SPLAT_MEAN, 3) = 1.0f;
            for (uint32_t k = 0; k < 3 && splat; k++)
                *splat_bench_number(bench, splat, SPLAT_MEAN, k) +=
                    (splat == 1 ? lenses[i].within : lenses[i].beyond) * right[k];
        }
        run_soundly(bench);
        for (uint32_t splat = 0; splat < 3; splat++) assert_int_equal(pairs_of(bench, splat) > 0, splat < 2);
    }
}

TEST(quaternions_without_a_direction_are_not_shown) {
    struct splat_bench *bench = open_few();
    const float turns[][4] = {{0, 0, 0, 0},     {NAN, 0, 0, 1},   {0, INFINITY, 0, 0},
                              {1e-8f, 0, 0, 0}, {1e-3f, 0, 0, 0}, {0, 0, 0, 1e6f}};
    for (uint32_t i = 0; i < 6; i++) {
        place(bench, i, 1.0f);
        *splat_bench_number(bench, i, SPLAT_MEAN, 3) = 1.0f;
        for (uint32_t k = 0; k < 4; k++) *splat_bench_number(bench, i, SPLAT_TURN, k) = turns[i][k];
    }
    run_soundly(bench);
    for (uint32_t i = 0; i < 6; i++) assert_int_equal(pairs_of(bench, i) > 0, i >= 4);
}

TEST(needles_and_sizes_beyond_reason) {
    struct splat_bench *bench = open_few();
    const float scales[][3] = {{0, -12, -12},      {-12, -30, 0.5f}, {3, -20, -20},    {-60, -60, -60},
                               {-200, -200, -200}, {2, 2, 2},        {12, 12, 12},     {60, 60, 60},
                               {200, 0, 0},        {NAN, -3, -3},    {INFINITY, 0, 0}, {-INFINITY, -3, -3}};
    for (uint32_t i = 0; i < 12; i++) {
        place(bench, i, 1.0f + 0.01f * (float)i);
        *splat_bench_number(bench, i, SPLAT_MEAN, 3) = -2.0f;
        set(bench, i, SPLAT_SCALE, scales[i][0], scales[i][1], scales[i][2]);
    }
    run_soundly(bench);
    const bool shown[12] = {true, true, true, true, true, true, true, false, false, false, false, true};
    for (uint32_t i = 0; i < 12; i++)
        if ((pairs_of(bench, i) > 0) != shown[i]) fail_msg("splat %u has %u pairs", i, pairs_of(bench, i));
    assert_int_equal(pairs_of(bench, 5), bench->tile_count); // one splat over all tiles
}

TEST(opacity_at_its_ends) {
    struct splat_bench *bench = open_few();
    const float logits[] = {-INFINITY, -88.0f, -5.6f, -5.5f, 20.0f, 88.0f, INFINITY, NAN};
    for (uint32_t i = 0; i < 8; i++) {
        place(bench, i, 1.0f);
        *splat_bench_number(bench, i, SPLAT_MEAN, 3) = logits[i];
        *splat_bench_number(bench, i, SPLAT_MEAN, 0) += 0.05f * (float)i - 0.2f;
    }
    splat_bench_write(bench);
    splat_bench_run(bench, true, false);
    for (uint32_t i = 0; i < 8; i++) assert_int_equal(pairs_of(bench, i) > 0, i >= 3 && i <= 6);
    *splat_bench_number(bench, 6, SPLAT_MEAN, 3) = 80.0f;
    run_soundly(bench);
}

TEST(splats_in_one_place_are_drawn_in_the_order_of_their_indices) {
    struct splat_bench *bench = open_few();
    for (uint32_t i = 0; i < 12; i++) {
        place(bench, i, 1.0f);
        *splat_bench_number(bench, i, SPLAT_MEAN, 3) = -1.0f;
        set(bench, i, SPLAT_SCALE, -2, -2, -2);
    }
    run_soundly(bench);
    const struct splat_pairs p = splat_bench_pairs(bench);
    for (uint32_t i = 1; i < p.state.pairs; i++)
        if (p.sorted[i][0] == p.sorted[i - 1][0])
            assert_true(p.seen[p.ranks[p.sorted[i][1]]].sighting > p.seen[p.ranks[p.sorted[i - 1][1]]].sighting);
}

TEST(no_splat_in_view_leaves_the_background) {
    struct splat_bench *bench = open_few();
    for (uint32_t i = 0; i < 12; i++) place(bench, i, -1.0f);
    run_soundly(bench);
    assert_int_equal(splat_bench_state(bench).pairs, 0);
    const float(*colours)[4] = test_read(bench->drawing.colours);
    for (uint32_t ray = 0; ray < bench->ray_count; ray++)
        assert_true(colours[ray][0] == 0.0f && colours[ray][3] == 1.0f);
    const float *after = test_read(bench->param_buffer);
    assert_memory_equal(after, bench->params, vw_splat_param_bytes(&bench->room));
}

// ---- Bits ----------------------------------------------------------------------------------------------------------

static const struct splat_case same[] = {
    {"same bits", .seed = 61, .count = 900, .degree = 2, .log_scale = -2.5f},
    {"same bits, as on GPUs", .seed = 62, .count = 500, .as_on_gpus = true, .log_scale = -2.5f},
};

// Takes ten steps; the results depend on nothing but the params.
static float *take_steps(const struct splat_case *setup, uint64_t *bytes) {
    struct splat_bench *bench = splat_bench_open(setup);
    for (int step = 0; step < 10; step++) splat_bench_run(bench, true, true);
    *bytes = vw_buffer_size_bytes(bench->param_buffer);
    assert_int_equal(splat_bench_state(bench).overflow, 0);
    return test_read(bench->param_buffer);
}

TEST_CASES(two_runs_have_equal_bits, index, 2) {
    uint64_t bytes, again_bytes;
    const float *once = take_steps(&same[index], &bytes), *again = take_steps(&same[index], &again_bytes);
    assert_int_equal(bytes, again_bytes);
    assert_memory_equal(once, again, bytes);
    struct splat_bench *bench = splat_bench_open(&same[index]);
    assert_memory_not_equal(once, bench->params, bytes); // it moves
}

TEST(earlier_tiles_do_not_matter) {
    struct splat_bench *bench = splat_bench_open(&(struct splat_case){"lists", .seed = 63, .degree = 1});
    splat_bench_run(bench, false, false);
    const float *all = test_read(bench->drawing.colours);
    uint32_t tiles = bench->tile_count, half = tiles / 2, pixels = bench->s.side * bench->s.side;
    bench->push.first_tile = half;
    bench->push.tile_count = tiles - half;
    splat_bench_run(bench, false, false); // the map still has all tiles
    const float *some = test_read(bench->drawing.colours);
    assert_memory_equal(some, all + (size_t)4 * half * pixels, (size_t)16 * (tiles - half) * pixels);
}

TEST_GROUP(NULL, test_gpu_close)
