// --profile: every pass that a run dispatches has a cost, dispatched as often as the cost says, and costs grow as the
// work does.
#include "support/cmocka_test.h"

#include "gpu/compute.h"
#include "support/exposed_scene.h"
#include "support/trainer_fixture.h"
#include "train/trainer.h"

static const struct vw_pass_cost *find_cost(const struct vw_pass_costs *costs, const char *name, const char *role) {
    for (uint32_t i = 0; i < costs->count; i++) {
        const struct vw_pass_cost *cost = &costs->list[i];
        bool same_role = cost->role && role ? !strcmp(cost->role, role) : cost->role == role;
        if (same_role && !strcmp(cost->name, name)) return cost;
    }
    return NULL;
}

static void check_dispatches(enum vw_field field, uint32_t importance_samples, enum vw_coarse_network coarse_network,
                             const char *effects, uint32_t epochs) {
    struct vw_scene *scene = test_scene();
    struct vw_config config = test_config_of(field);
    struct vw_pass_costs costs;
    struct test_run *run = test_allocate(1, sizeof *run);
    uint32_t timer_count = 0, matched = 0;
    if (field != VW_FIELD_SPLATS) config.rays = 1200; // several chunks
    config.importance_samples = importance_samples;
    config.coarse_network = coarse_network;
    config.epochs = epochs;
    snprintf(config.effects, sizeof config.effects, "%s", effects);
    config.ssim_weight = field == VW_FIELD_SPLATS && strstr(effects, "sky") ? 0.2 : 0.0;
    config.consistency_weight = strstr(effects, "transient") ? 0.0 : 0.001; // for the encoder, where it is on
    struct vw_gpu *gpu = test_gpu_open((struct vw_gpu_params){.validation = true, .timers = true});
    const struct vw_trainer_params params = {// of longer submissions not all dispatches are timed
                                             .gpu = gpu,
                                             .scene = scene,
                                             .config = &config,
                                             .validate = true,
                                             .steps_per_submission = 2};
    struct vw_trainer *trainer = test_trainer_open(params);
    test_run_finish(trainer, run);
    vw_trainer_pass_costs(trainer, &costs);
    const struct vw_gpu_timer *timers = vw_gpu_timers(gpu, &timer_count);
    for (uint32_t i = 0; i < timer_count; i++) {
        if (!strcmp(timers[i].name, "generate_rays") && timers[i].role) continue; // once, before the first step
        const struct vw_pass_cost *cost = find_cost(&costs, timers[i].name, timers[i].role);
        if (!cost) fail_msg("%s has no cost; add it to src/train/step_costs.c or the renderer's costs", timers[i].name);
        bool validates = (timers[i].role && strstr(timers[i].role, "validation")) ||
                         !strcmp(timers[i].name, "reduce_views") || !strcmp(timers[i].name, "fit_views"); // also before
        double before = validates ? cost->dispatches : 0.0;
        assert_int_equal(timers[i].dispatches, (uint64_t)round(cost->dispatches * (run->count - 1) + before));
        assert_true(cost->bytes > 0 && isfinite(cost->multiply_adds));
        matched++;
    }
    assert_int_equal(matched, costs.count);
    test_release(trainer);
    test_release(gpu);
}

TEST(every_dispatch_is_accounted_for) {
    check_dispatches(VW_FIELD_HASH, 16, VW_COARSE_NETWORK_SHARED, "sky,unbounded,appearance,appearance_code", 3);
    check_dispatches(VW_FIELD_MLP, 16, VW_COARSE_NETWORK_OWN, "sky,appearance,appearance_code,transient", 3);
    check_dispatches(VW_FIELD_HASH, 16, VW_COARSE_NETWORK_SHARED, "transient,appearance_encoder", 3);
    check_dispatches(VW_FIELD_HASH, 0, VW_COARSE_NETWORK_SHARED, "pose", 16);
    check_dispatches(VW_FIELD_MLP, 16, VW_COARSE_NETWORK_OWN, "appearance_encoder,visibility", 3);
    check_dispatches(VW_FIELD_SPLATS, 0, VW_COARSE_NETWORK_SHARED, "none", 3);
    check_dispatches(VW_FIELD_SPLATS, 0, VW_COARSE_NETWORK_SHARED, "sky,appearance,uncertainty", 3);
    if (!test_is_full()) return; // the rest has passes of those above
    check_dispatches(VW_FIELD_HASH, 0, VW_COARSE_NETWORK_SHARED, "none", 3);
    check_dispatches(VW_FIELD_MLP, 16, VW_COARSE_NETWORK_SHARED, "sky,appearance,appearance_code", 3);
    check_dispatches(VW_FIELD_HASH, 0, VW_COARSE_NETWORK_SHARED, "appearance_encoder,sky", 16);
    check_dispatches(VW_FIELD_MLP, 0, VW_COARSE_NETWORK_SHARED, "sky,appearance_code,transient", 3);
}

// No pass fits photos whose exposure is known from points, and none is counted.
TEST(a_fit_that_no_step_makes_costs_nothing) {
    for (int points = 0; points < 2; points++) {
        struct vw_scene *scene = exposed_scene((struct exposed_scene_params){.gains = 1});
        struct vw_config config = test_config_with("appearance");
        struct vw_pass_costs costs;
        if (!points) scene_forget_points(scene);
        vw_trainer_pass_costs(test_trainer_create(scene, &config, false, 1), &costs);
        assert_int_equal(find_cost(&costs, "fit_photo", NULL) != NULL, !points);
    }
}

// Returns the cost of a pass for a number of rays.
static struct vw_pass_cost cost_of(const char *name, uint32_t rays) {
    struct vw_scene *scene = test_scene();
    struct vw_config config = test_config();
    config.rays = rays;
    struct vw_trainer *trainer = test_trainer_create(scene, &config, false, 1);
    struct vw_pass_costs costs;
    vw_trainer_pass_costs(trainer, &costs);
    struct vw_pass_cost cost = *find_cost(&costs, name, NULL);
    return cost;
}

// The multiply-adds of the small field, counted by hand: 4 levels x 2 features into 16 hidden units, 16 outputs, 24
// inputs of the colour network, 16 hidden units, 4 outputs with the padding: 128 + 256 + 384 + 64 = 832 a sample, and 2
// for each of 32 gathered pairs.
TEST(multiply_adds_are_those_of_the_networks) {
    double samples = 64.0 * 16.0;
    assert_true(cost_of("forward_field", 64).multiply_adds == samples * (832 + 64));
    assert_true(cost_of("gradient_weights", 64).multiply_adds == samples * 832);
    assert_true(cost_of("backward_field", 64).multiply_adds ==
                samples * (832 - 16 * 8)); // the harmonics have no gradient
    assert_true(cost_of("forward_field", 128).multiply_adds == 2 * samples * (832 + 64));
    assert_true(cost_of("scatter_grid", 128).bytes == 2 * cost_of("scatter_grid", 64).bytes);
}

TEST_GROUP(NULL, test_gpu_close)
