// The registry of passes: every shader that is embedded, held against the reference on every case and every kind of
// input, with guard bands around every buffer (tests/support/guard_bands.c). The quick tests give every case the
// ordinary inputs and one of the other six kinds, which differ from pass to pass; passes on halves and in other
// forms get every second case. test_passes NAME gives one pass all of them.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "base/text.h"
#include "detect/decide.h"
#include "gpu/compute.h"
#include "gpu/shaders.h"
#include "gpu/spirv.h"
#include "kernels/checks/check.h"
#include "support/gpu_fixture.h"
#include "support/guard_bands.h"
#include "train/effects/registry.h"

static const struct pass {
    const char *name;
    const struct vw_shader *shader;
    pass_check *check;
    enum vw_scatter_form scatter;
} passes[] = {
    {"fit_views", &vw_shader_fit_views, check_fit_views, SCATTER_ATOMICS},
    {"fit_photo", &vw_shader_fit_photo, check_fit_photo, SCATTER_ATOMICS},
    {"generate_rays", &vw_shader_generate_rays, check_generate_rays, SCATTER_ATOMICS},
    {"forward_field", &vw_shader_forward_field, check_forward_field, SCATTER_ATOMICS},
    {"composite_rays", &vw_shader_composite_rays, check_composite_rays, SCATTER_ATOMICS},
    {"reduce_views", &vw_shader_reduce_views, check_reduce_views, SCATTER_ATOMICS},
    {"backward_rays", &vw_shader_backward_rays, check_backward_rays, SCATTER_ATOMICS},
    {"backward_rays_effects", &vw_shader_backward_rays_effects, check_backward_rays, SCATTER_ATOMICS},
    {"backward_field", &vw_shader_backward_field, check_backward_field, SCATTER_ATOMICS},
    {"gradient_weights", &vw_shader_gradient_weights, check_gradient_weights, SCATTER_ATOMICS},
    {"reduce_weights", &vw_shader_reduce_weights, check_reduce_weights, SCATTER_ATOMICS},
    {"scatter_grid", &vw_shader_scatter_grid, check_scatter_grid, SCATTER_ATOMICS},
    {"scatter_grid_split", &vw_shader_scatter_grid_split, check_scatter_grid, SCATTER_SPLIT_ATOMICS},
    {"scatter_grid_walk", &vw_shader_scatter_grid_walk, check_scatter_grid, SCATTER_WALK},
    {"reduce_loss", &vw_shader_reduce_loss, check_reduce_loss, SCATTER_ATOMICS},
    {"update_grid", &vw_shader_update_grid, check_update_grid, SCATTER_ATOMICS},
    {"update_weights", &vw_shader_update_weights, check_update_weights, SCATTER_ATOMICS},
    {"trace_recipe", &vw_shader_trace_recipe, check_trace_recipe, SCATTER_ATOMICS},
};

// Other programs hold these against the reference.
static const struct vw_shader *const elsewhere[] = {
    // test_adjoint_product; test_gradient_methods the last
    &vw_shader_slope_views, &vw_shader_direct_adjoint, &vw_shader_reduce_adjoint, &vw_shader_perturb_params,
    &vw_shader_difference_rays, &vw_shader_difference_rays_effects, &vw_shader_normalise_slopes, &vw_shader_gather_grid,
    &vw_shader_gather_weights, &vw_shader_gather_code, &vw_shader_multiply_blocks,
    // test_draw_pixels
    &vw_shader_draw_pixels, &vw_shader_draw_pixels_tiles,
    // test_hard_importance
    &vw_shader_place_samples,
    // test_measure_views
    &vw_shader_composite_rays_depth, &vw_shader_colour_splats_depth, &vw_shader_show_pixels_depth,
    // test_mlp_gradients
    &vw_shader_encode_samples, &vw_shader_multiply_layer, &vw_shader_multiply_layer_back, &vw_shader_activate_samples,
    &vw_shader_activate_samples_back, &vw_shader_gradient_weights_layer, &vw_shader_reduce_weights_layer,
    // test_transient
    &vw_shader_feed_transient, &vw_shader_feed_transient_features, &vw_shader_backward_transient,
    &vw_shader_backward_transient_effects, &vw_shader_backward_field_transient, &vw_shader_update_transient,
    // test_pose
    &vw_shader_gradient_positions, &vw_shader_gradient_pose, &vw_shader_update_pose,
    // test_appearance_encoder; test_consistency the last four
    &vw_shader_convolve_photo, &vw_shader_convolve_photo_back, &vw_shader_pool_photo, &vw_shader_spread_photo,
    &vw_shader_gradient_photo, &vw_shader_shrink_colours, &vw_shader_spread_photo_codes, &vw_shader_spread_colours,
    &vw_shader_add_gradients,
    // test_step_gradients
    &vw_shader_gradient_sky, &vw_shader_mix_code, &vw_shader_update_code, &vw_shader_predict_visibility,
    &vw_shader_gradient_visibility, &vw_shader_reduce_visibility, &vw_shader_update_visibility,
    &vw_shader_predict_visibility_uncertainty, &vw_shader_gradient_visibility_uncertainty,
    &vw_shader_reduce_visibility_uncertainty,
    // test_splat_passes; test_splat_gradient, test_splat_windows, and test_splats_training the last
    &vw_shader_mark_tiles, &vw_shader_project_splats, &vw_shader_place_pairs, &vw_shader_emit_pairs,
    &vw_shader_colour_splats, &vw_shader_count_digits, &vw_shader_place_digits, &vw_shader_scatter_pairs,
    &vw_shader_blend_tiles, &vw_shader_slope_pixels, &vw_shader_slope_pixels_effects, &vw_shader_blend_tiles_back,
    &vw_shader_backward_splats, &vw_shader_update_splats, &vw_shader_compare_windows,
    &vw_shader_compare_windows_effects, &vw_shader_show_pixels};

enum { BENCHES_MAX = 24 };
static struct step_bench *benches[BENCHES_MAX]; // one per case, shared by the passes

static int open_benches(void **state) {
    (void)state;
    assert_true(step_case_count <= BENCHES_MAX);
    for (uint32_t i = 0; i < step_case_count; i++) benches[i] = step_bench_open(&step_cases[i]);
    return 0;
}

static struct step_bench *open_for(const struct pass *pass, struct step_case setup) {
    setup.scatter = pass->scatter;
    struct vw_gpu_limits clamp = *vw_gpu_get_limits(test_gpu());
    clamp.int64_atomics &= pass->scatter == SCATTER_ATOMICS; // the other forms can do without
    return step_bench_open_clamped(&setup, &clamp);
}

static bool all_kinds;

static bool is_chosen(const struct pass *pass, uint32_t case_index, enum input_kind kind) {
    return all_kinds || kind == INPUT_ORDINARY ||
           (kind + case_index + (uint32_t)(pass - passes)) % (INPUT_KINDS - 1) == 0;
}

static void run_kinds(const struct pass *pass, uint32_t case_index, struct step_bench *bench) {
    const struct step_case *setup = &step_cases[case_index];
    for (enum input_kind kind = 0; kind < INPUT_KINDS; kind++) {
        if (!is_chosen(pass, case_index, kind)) continue;
        snprintf(bench->where, sizeof bench->where, "case \"%s\", seed %llu, %s inputs; rerun: test_passes %s",
                 setup->name, (unsigned long long)setup->seed, input_kind_names[kind], pass->name);
        const size_t before = test_owned();
        pass->check(bench, kind);
        test_release_to(before);
    }
}

// Returns whether a case runs a pass. A case runs only one variant of backward_rays.
static bool takes_case(const struct pass *pass, const struct step_case *setup) {
    if (strncmp(pass->name, "backward_rays", strlen("backward_rays")) != 0) return true;
    bool effects = vw_word_list_has(setup->effects, "sky") || vw_word_list_has(setup->effects, "appearance") ||
                   vw_word_list_has(setup->effects, "visibility") || vw_word_list_has(setup->effects, "uncertainty");
    return effects == (pass->shader == &vw_shader_backward_rays_effects);
}

static void run_pass(void **state) {
    const struct pass *pass = *state;
    for (uint32_t i = 0; i < step_case_count; i++) {
        if (!takes_case(pass, &step_cases[i])) continue;
        const size_t before = test_owned();
        bool shared = pass->scatter == SCATTER_ATOMICS;
        if (!shared && !all_kinds && (i + (uint32_t)(pass - passes)) % 2) continue; // opening a bench takes longest
        struct step_bench *bench = shared ? benches[i] : open_for(pass, step_cases[i]);
        run_kinds(pass, i, bench);
        test_release_to(before);
    }
    if (guard_bands_broken()) fail_msg("pass %s wrote to guard bands, see stderr", pass->name);
}

// ---- That nothing is left out ---------------------------------------------------------------------------------------

static void every_shader_is_listed(void **state) {
    (void)state;
    for (uint32_t i = 0; i < vw_shader_count; i++) {
        bool listed = false;
        for (size_t k = 0; k < VW_ARRAY_COUNT(passes); k++) listed |= passes[k].shader == vw_shaders[i];
        for (size_t k = 0; k < VW_ARRAY_COUNT(elsewhere); k++) listed |= elsewhere[k] == vw_shaders[i];
        if (!listed)
            fail_msg("shader %u of shaders/list.cmake, of %s.comp, is not in the registry", i, vw_shaders[i]->name);
    }
}

// Checks that devices at the floor, such as v3dv, run everything but sky, appearance, visibility and uncertainty.
static void only_ray_effects_declare_more_storage_buffers_than_the_floor(void **state) {
    (void)state;
    uint32_t most = 0;
    for (uint32_t i = 0; i < vw_shader_count; i++) {
        struct vw_spirv spirv;
        uint32_t storage_buffers = 0;
        assert_int_equal(vw_spirv_read(vw_shaders[i], NULL, 0, &spirv), VW_OK);
        for (uint32_t k = 0; k < spirv.slot_count; k++) storage_buffers += !spirv.slots[k].texel;
        print_message("%s: %u storage buffers\n", vw_shaders[i]->name, storage_buffers);
        if (vw_shaders[i] == &vw_shader_backward_rays_effects) assert_int_equal(storage_buffers, 10);
        else if (vw_shaders[i] == &vw_shader_backward_transient_effects) assert_int_equal(storage_buffers, 11);
        else if (vw_shaders[i] == &vw_shader_slope_pixels_effects) assert_int_equal(storage_buffers, 11);
        else if (storage_buffers > most) most = storage_buffers;
    }
    assert_int_equal(most, vw_gpu_floor_limits.storage_buffers);
}

static void too_many_storage_buffers_are_refused_by_name(void **state) {
    (void)state;
    struct vw_gpu *gpu = NULL;
    struct vw_pass *pass = NULL;
    assert_int_equal(vw_gpu_open(&(struct vw_gpu_params){.clamp = &vw_gpu_floor_limits}, &gpu), VW_OK);
    const struct vw_pass_params params = {.shader = &vw_shader_backward_rays_effects};
    assert_int_equal(vw_pass_create(gpu, &params, &pass), VW_ERROR_DEVICE);
    assert_non_null(
        strstr(vw_error_message(), "pass backward_rays: 10 storage buffers, the device binds 8; leave out"));
    assert_int_equal(vw_gpu_close(&gpu), VW_OK);
}

static uint32_t count_precise(const struct vw_shader *shader) { // operations that SPIR-V decorates as NoContraction
    enum { HEADER_WORDS = 5, OP_DECORATE = 71, NO_CONTRACTION = 42 };
    uint32_t count = 0;
    for (size_t at = HEADER_WORDS; at < shader->code_bytes / 4; at += shader->code[at] >> 16)
        count += (shader->code[at] & 0xFFFF) == OP_DECORATE && shader->code[at + 2] == NO_CONTRACTION;
    return count;
}

// Checks that no compiler may fuse a product and a sum in one pipeline and not in another. (Lavapipe never fuses.)
// Counts are of grid_locate and grid_weight; sampling.glsl; camera_ray; a target over its background.
static void what_several_passes_compute_is_precise(void **state) {
    (void)state;
    enum { CELL = 6, POSITION = 30, RAY = 15, TARGET = 8 };
    assert_int_equal(count_precise(&vw_shader_scatter_grid), CELL);
    assert_int_equal(count_precise(&vw_shader_scatter_grid_walk), CELL);
    assert_int_equal(count_precise(&vw_shader_forward_field), CELL + POSITION);
    assert_int_equal(count_precise(&vw_shader_generate_rays), RAY + TARGET);
}

static void every_effect_has_a_case_with_and_one_without(void **state) {
    (void)state;
    struct vw_effect_decision decisions[VW_EFFECT_COUNT_MAX];
    uint32_t count = 0, on[VW_EFFECT_COUNT_MAX] = {0};
    for (uint32_t i = 0; i < step_case_count; i++) {
        assert_int_equal(vw_effects_find_facts(benches[i]->scene, benches[i]->config.effects, decisions, &count),
                         VW_OK);
        for (uint32_t k = 0; k < count; k++) on[k] += decisions[k].on;
    }
    assert_true(count > 0);
    const struct vw_effect *effects = vw_effects_get(&count);
    for (uint32_t k = 0; k < count; k++)
        if (strcmp(effects[k].name, "transient") && strcmp(effects[k].name, "pose") &&
            strcmp(effects[k].name, "appearance_encoder") && effects[k].constant != SIZE_MAX &&
            (on[k] == 0 || on[k] == step_case_count)) // else the host's alone
            fail_msg("effect %s is %s in every case of tests/reference/step_cases.c", decisions[k].name,
                     on[k] ? "on" : "off");
}

// Checks that some case makes every choice: bit i is set when some case makes choice i of a kind of choices.
static void every_choice_has_a_case(void **state) {
    (void)state;
    uint32_t losses = 0, optimizers = 0, momentum = 0, words = 0, features = 0, widths = 0;
    for (uint32_t i = 0; i < step_case_count; i++) {
        const struct step_case *c = &step_cases[i];
        losses |= 1u << c->loss;
        optimizers |= 1u << c->optimizer;
        momentum |= 1u << (c->beta1 > 0.0);
        words |= 1u << c->wide;
        features |= 1u << (c->features == 4);
        widths |= c->width ? c->width : 32;
    }
    assert_int_equal(losses, 1u << VW_LOSS_L1 | 1u << VW_LOSS_L2 | 1u << VW_LOSS_HUBER);
    assert_int_equal(optimizers, 1u << VW_OPTIMIZER_LAZY_ADAM | 1u << VW_OPTIMIZER_DENSE_ADAM | 1u << VW_OPTIMIZER_SGD);
    assert_int_equal(momentum, 3);
    assert_int_equal(words, 3);
    assert_int_equal(features, 3);
    assert_int_equal(widths, 16 | 32 | 64);
}

int main(int argc, char **argv) {
    enum { COVERAGE_TESTS = 6 };
    struct CMUnitTest tests[VW_ARRAY_COUNT(passes) + COVERAGE_TESTS] = {
        cmocka_unit_test(every_shader_is_listed),
        cmocka_unit_test(only_ray_effects_declare_more_storage_buffers_than_the_floor),
        cmocka_unit_test(too_many_storage_buffers_are_refused_by_name),
        cmocka_unit_test(what_several_passes_compute_is_precise),
        cmocka_unit_test(every_effect_has_a_case_with_and_one_without),
        cmocka_unit_test(every_choice_has_a_case),
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(passes); i++)
        tests[COVERAGE_TESTS + i] =
            (struct CMUnitTest){.name = passes[i].name, .test_func = run_pass, .initial_state = (void *)&passes[i]};
    all_kinds = argc > 1 || test_is_full();
    if (argc > 1) cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests_name("passes", tests, open_benches, test_gpu_close);
}
