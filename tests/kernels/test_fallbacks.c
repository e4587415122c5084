// Devices differ in limits, not in results: on one device every fallback gives the same bits after three whole steps,
// and passes that keep their loops meet the reference as those do whose loops are unrolled.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "gpu/compute.h"
#include "gpu/shaders.h"
#include "gpu/spirv.h"
#include "kernels/checks/check.h"
#include "support/gpu_fixture.h"

// Tables of 2^14 entries on 8 levels, and 2,048 samples: beyond 65,536 texels in both the grid and the activations. The
// other has so many samples that its gradient takes wide words.
static const struct step_case base_case = {"fallback", .seed = 111, .rays = 64, .base_resolution = 24};
static const struct step_case momentum_case = {"fallback with momentum, wide words and photos",
                                               .seed = 112,
                                               .rays = 1056,
                                               .features = 4,
                                               .levels = 4,
                                               .beta1 = 0.9,
                                               .base_resolution = 24,
                                               .effects = "appearance,appearance_code"};
enum { STEPS = 3 };

struct outcome {
    void *buffers[5];
    uint64_t sizes_bytes[5];
};
static const char *const names[] = {"params", "weight moments", "grid moment2", "grid visits", "scalars"};

static struct outcome run(struct step_bench *bench) {
    struct vw_buffer *buffers[] = {bench->field.params, bench->step.weight_moments, bench->volume->grid_moment2,
                                   bench->volume->grid_visits, bench->scalars};
    struct outcome outcome;
    for (uint64_t number = 1; number <= STEPS; number++) step_bench_step(bench, number);
    for (int i = 0; i < 5; i++) {
        outcome.buffers[i] = test_read(buffers[i]);
        outcome.sizes_bytes[i] = vw_buffer_size_bytes(buffers[i]);
    }
    return outcome;
}

static const struct step_case *const setups[] = {&base_case, &momentum_case};
enum { SETUPS = 2 };
static struct outcome undisturbed[SETUPS]; // without any fallback

static int run_setups(void **state) {
    (void)state;
    for (int i = 0; i < SETUPS; i++) {
        struct step_bench *bench = step_bench_open(setups[i]);
        undisturbed[i] = run(bench);
        assert_true(memcmp(undisturbed[i].buffers[0], bench->params, bench->model.param_bytes) != 0); // it did move
        test_release(bench);
    }
    return 0;
}

// Runs a variant of setups[`setup`], compares, and closes it.
static void expect_same(size_t setup, struct step_bench *other) {
    struct outcome found = run(other);
    for (int i = 0; i < 5; i++) {
        assert_int_equal(found.sizes_bytes[i], undisturbed[setup].sizes_bytes[i]);
        check_same_bits(other->where, names[i], found.buffers[i], undisturbed[setup].buffers[i], found.sizes_bytes[i]);
    }
    test_release(other);
}

TEST(storage_buffers_instead_of_texels_change_no_bit) {
    struct vw_gpu_limits clamp = *vw_gpu_get_limits(test_gpu());
    clamp.texel_elements = 65536;
    for (size_t i = 0; i < VW_ARRAY_COUNT(setups); i++) {
        struct step_bench *storage = step_bench_open_clamped(setups[i], &clamp);
        assert_int_equal(storage->model.specialization.grid_texel, 0);
        assert_int_equal(storage->model.specialization.rows_texel, 0);
        expect_same(i, storage);
    }
}

TEST(windows_of_the_grid_change_no_bit) {
    struct vw_gpu_limits clamp = *vw_gpu_get_limits(test_gpu());
    clamp.storage_binding_bytes = 600000;
    for (size_t i = 0; i < VW_ARRAY_COUNT(setups); i++) {
        struct step_case chunked = *setups[i];
        chunked.chunk_samples = 256; // the chunk's activations fit such a binding
        struct step_bench *windows = step_bench_open_clamped(&chunked, &clamp);
        assert_true(windows->layout->window_count > 1);
        if (windows->layout->grid.size_bytes > clamp.storage_binding_bytes)
            assert_int_equal(windows->model.specialization.grid_texel, 1);
        assert_int_equal(windows->model.specialization.wide_gradient, i == 1);
        expect_same(i, windows);
    }
}

// All choices but the length and the parts of slices, and the lanes of rays, give equal bits: without texels, and with
// a branch around zeros.
TEST_CASES(the_choices_for_gpus_change_no_bit, i, VW_ARRAY_COUNT(setups)) {
    struct step_case on_gpus = *setups[i];
    struct vw_device_choices own;
    vw_device_choose(vw_gpu_get_info(test_gpu()), &own);
    on_gpus.as_on_gpus = true;
    on_gpus.slice_samples = own.slice_samples, on_gpus.slice_parts = own.slice_parts;
    on_gpus.ray_lanes = own.ray_lanes;
    struct step_bench *bench = step_bench_open(&on_gpus);
    const struct vw_specialization *s = &bench->model.specialization;
    assert_true(s->skip_zeros && !s->grid_texel && !s->rows_texel);
    expect_same(i, bench);
}

TEST(the_chunk_size_changes_no_bit) {
    static const uint32_t chunks[] = {256, 768}; // 768 leaves a shorter last chunk
    for (size_t i = 0; i < VW_ARRAY_COUNT(chunks); i++) {
        struct step_case chunked = base_case;
        chunked.chunk_samples = chunks[i];
        expect_same(0, step_bench_open(&chunked));
    }
}

// Other fields and effects; with importance samples both kinds fill whole workgroups, and a picture of several chunks
// is rendered twice.
static const struct {
    struct step_case setup;
    uint32_t chunk_samples;
} chunked_cases[] = {
    {{"mlp", .seed = 320, .field = VW_FIELD_MLP, .mlp_depth = 7, .width = 24, .rays = 60, .samples = 16}, 256},
    {{"mlp, coarse network", .seed = 320, .field = VW_FIELD_MLP, .mlp_depth = 7, .width = 24, .rays = 60, .samples = 16,
      .importance_samples = 8, .own_coarse = true},
     512},
    {{"transient", .seed = 420, .width = 16, .rays = 64, .samples = 16, .loss = VW_LOSS_L2, .effects = "transient"},
     256},
    {{"mlp, transient", .seed = 420, .field = VW_FIELD_MLP, .mlp_depth = 2, .width = 16, .rays = 64, .samples = 16,
      .loss = VW_LOSS_L2, .effects = "transient"},
     256},
    {{"picture, importance samples", .seed = 617, .rays = 100, .samples = 16, .importance_samples = 16,
      .effects = "appearance_encoder", .consistency_weight = 5.0},
     256},
    {{"mlp, picture", .seed = 618, .field = VW_FIELD_MLP, .mlp_depth = 2, .width = 40, .rays = 100, .samples = 16,
      .effects = "appearance_encoder", .consistency_weight = 5.0},
     256},
};

TEST_CASES(nor_in_other_fields_and_effects_does_it, i, VW_ARRAY_COUNT(chunked_cases)) {
    step_bench_check_chunks(&chunked_cases[i].setup, chunked_cases[i].chunk_samples, STEPS);
}

static vw_float4 *render(struct step_bench *bench, struct vw_evaluator *evaluator, const struct vw_pixel *pixels,
                         uint32_t count) {
    assert_int_equal(vw_evaluator_set_pixels(evaluator, pixels, count), VW_OK);
    vw_submission_begin(bench->submission);
    vw_evaluator_record(evaluator, bench->submission);
    test_submit(bench->submission);
    return test_read(evaluator->colours);
}

// More samples than are held at a time: a ray's colour depends neither on its chunk nor on its place there.
TEST(rendering_in_chunks_changes_no_bit) {
    static const struct step_case many = {
        .name = "many samples", .seed = 113, .samples = 512, .rays = 192, .levels = 2, .log2_table = 8, .width = 16};
    enum { BEHIND = 70 };
    struct step_bench *bench = step_bench_open(&many);
    struct vw_evaluator *whole = step_bench_evaluator(bench), part;
    uint32_t chunk_rays = vw_volume_evaluation_of(whole)->chunk_rays;
    assert_true(chunk_rays < many.rays && chunk_rays > BEHIND);
    assert_int_equal(vw_evaluator_create(&bench->field, many.rays - BEHIND, false, &part), VW_OK);
    assert_int_equal(vw_volume_evaluation_of(&part)->chunk_rays, part.ray_count);
    vw_float4 *expected = render(bench, &part, bench->pixels + BEHIND, many.rays - BEHIND);
    vw_float4 *found = render(bench, whole, bench->pixels, many.rays);
    check_same_bits(bench->where, "colours", found + BEHIND, expected, (many.rays - BEHIND) * sizeof *found);
    vw_evaluator_destroy(&part);
}

// The same steps twice on one device.
TEST(a_second_run_gives_the_same_bits) { expect_same(1, step_bench_open(&momentum_case)); }

// ---- Kept loops: the form of the shaders (VIEWWORTH_LOOPS=kept) for drivers that compile what is unrolled too slowly
// ---

enum { HEADER_WORDS = 5, OP_LOOP_MERGE = 246, CONTROL_WORD = 3, UNROLL = 1, DONT_UNROLL = 2, CASE_STRIDE = 9 };

static uint32_t count_loops(const uint32_t *code, size_t words, uint32_t control) {
    uint32_t count = 0;
    for (size_t at = HEADER_WORDS; at < words; at += code[at] >> 16)
        count += (code[at] & 0xFFFF) == OP_LOOP_MERGE && code[at + CONTROL_WORD] == control;
    return count;
}

TEST_CASES(every_loop_that_asks_to_be_unrolled_asks_to_be_kept, i, vw_shader_count) {
    const struct vw_shader *shader = vw_shaders[i];
    size_t words = shader->code_bytes / 4;
    uint32_t *code = test_allocate(words, 4);
    assert_non_null(code);
    memcpy(code, shader->code, shader->code_bytes);
    uint32_t unrolled = count_loops(code, words, UNROLL), kept = count_loops(code, words, DONT_UNROLL);
    vw_spirv_keep_loops(code, shader->code_bytes);
    if (count_loops(code, words, UNROLL) || count_loops(code, words, DONT_UNROLL) != unrolled + kept)
        fail_msg("%s: %u loops still ask to be unrolled", shader->name, count_loops(code, words, UNROLL));
}

TEST(passes_that_keep_their_loops_meet_the_reference) {
    pass_check *const checks[] = {check_forward_field, check_backward_field, check_gradient_weights,
                                  check_scatter_grid};
    struct vw_gpu_limits clamp = *vw_gpu_get_limits(test_gpu());
    clamp.unrolls_loops = false;
    for (uint32_t i = 0; i < step_case_count; i += CASE_STRIDE) {
        struct step_bench *bench = step_bench_open_clamped(&step_cases[i], &clamp);
        assert_false(vw_gpu_get_limits(bench->gpu)->unrolls_loops);
        for (size_t k = 0; k < VW_ARRAY_COUNT(checks); k++) {
            checks[k](bench, INPUT_ORDINARY);
        }
        test_release(bench);
    }
}

TEST(another_word_than_kept_or_unrolled_is_refused) {
    struct vw_gpu *gpu = NULL;
    assert_int_equal(setenv("VIEWWORTH_LOOPS", "folded", 1), 0);
    ASSERT_FAILS(vw_gpu_open(&(struct vw_gpu_params){0}, &gpu), VW_ERROR_USAGE, "VIEWWORTH_LOOPS is \"folded\"");
    assert_int_equal(unsetenv("VIEWWORTH_LOOPS"), 0);
}

// So that a run's identity, which holds the driver's text, tells the forms apart.
TEST(the_driver_text_tells_that_loops_are_kept) {
    struct vw_gpu *gpu = NULL;
    assert_null(strstr(vw_gpu_get_info(test_gpu())->driver, "loops kept"));
    assert_int_equal(setenv("VIEWWORTH_LOOPS", "kept", 1), 0);
    assert_int_equal(vw_gpu_open(&(struct vw_gpu_params){0}, &gpu), VW_OK);
    assert_int_equal(unsetenv("VIEWWORTH_LOOPS"), 0);
    assert_non_null(strstr(vw_gpu_get_info(gpu)->driver, ", loops kept"));
    assert_false(vw_gpu_get_limits(gpu)->unrolls_loops);
    assert_int_equal(vw_gpu_close(&gpu), VW_OK);
}

TEST_GROUP(run_setups, test_gpu_close)
