// A run with an effect off has nothing of it: no param, no byte on the device, no pass. Here without guard bands, which
// take bytes too.
// label: host
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "gpu/compute.h"
#include "support/plain_config.h"
#include "support/synthetic_scene.h"
#include "support/trainer_fixture.h"
#include "train/renderers/volume/volume.h"
#include "train/trainer.h"
#include "train/trainer_private.h"

// Passes that a run without effects consists of. Any other in such a run belongs to an effect that is off.
static const char *const shared_passes[] = {"generate_rays", "forward_field",  "composite_rays",   "reduce_views",
                                            "backward_rays", "backward_field", "gradient_weights", "reduce_weights",
                                            "scatter_grid",  "reduce_loss",    "update_weights",   "update_grid"};

enum { STAND_IN_BYTES = 256 }; // size of what a pass binds in place of buffers that it leaves alone

struct cost {
    uint64_t param_count, param_bytes, grid_and_weight_bytes, device_bytes, shared_bytes;
    uint32_t pass_count, other_passes;
};

static uint64_t shared_bytes(const struct vw_trainer *trainer) {
    const struct vw_radiance_field *f = &trainer->field;
    const struct vw_step_passes *s = &trainer->step;
    const struct vw_volume_step *volume = vw_volume_step_of(s);
    const struct vw_evaluator *v = &trainer->validation.evaluator;
    struct vw_buffer *const buffers[] = {f->params,
                                         f->cameras,
                                         f->rows,
                                         f->grid_rows,
                                         f->step_state,
                                         s->ray_buffer,
                                         volume->samples,
                                         volume->d_samples,
                                         s->ray_loss,
                                         s->overflow,
                                         volume->weight_partials,
                                         s->d_weights,
                                         s->weight_moments,
                                         volume->d_grid,
                                         volume->grid_moment1,
                                         volume->grid_moment2,
                                         volume->grid_visits,
                                         v->pixels,
                                         v->rays,
                                         vw_volume_evaluation_of(v)->samples,
                                         v->colours,
                                         trainer->validation.ranges,
                                         trainer->pixels,
                                         trainer->scalars};
    uint64_t sum = 0;
    for (size_t i = 0; i < VW_ARRAY_COUNT(buffers); i++) sum += vw_buffer_size_bytes(buffers[i]);
    return sum;
}

static bool is_shared(const char *pass) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(shared_passes); i++)
        if (!strcmp(shared_passes[i], pass)) return true;
    return false;
}

// Measures a few steps with exactly these effects, on a device of their own, whose timers then know every pass.
static struct cost measure(const struct vw_scene *scene, const char *effects) {
    struct vw_config config = plain_config();
    const struct vw_step_record *records;
    uint32_t count = 0;
    config.epochs = 2;
    config.rays = 64;
    config.width = 16;
    config.log2_table = 10;
    snprintf(config.effects, sizeof config.effects, "%s", effects);
    struct vw_gpu *gpu = test_gpu_open((struct vw_gpu_params){.timers = true});
    struct vw_trainer *trainer =
        test_trainer_open((struct vw_trainer_params){.gpu = gpu, .scene = scene, .config = &config, .validate = true});
    struct vw_trainer_stats stats;
    vw_trainer_get_stats(trainer, &stats);
    do ASSERT_OK(vw_trainer_advance(trainer, &records, &count));
    while (count);
    struct cost cost = {.param_count = stats.param_count,
                        .param_bytes = trainer->model.param_bytes,
                        .grid_and_weight_bytes =
                            vw_volume_of(&trainer->model)->grid.size_bytes + trainer->model.weights.size_bytes,
                        .device_bytes = stats.device_bytes,
                        .shared_bytes = shared_bytes(trainer)};
    const struct vw_gpu_timer *timers = vw_gpu_timers(gpu, &cost.pass_count);
    for (uint32_t i = 0; i < cost.pass_count; i++) {
        if (is_shared(timers[i].name)) continue;
        cost.other_passes++;
        if (!strcmp(effects, "none")) print_error("pass %s runs without any effect\n", timers[i].name);
    }
    test_release(trainer);
    cost.device_bytes -= vw_gpu_buffer_bytes(gpu); // buffers that the device layer keeps for transfers
    test_release(gpu);
    return cost;
}

static struct vw_scene *make_scene(void) {
    return synthetic_scene(
        &(struct synthetic_scene_params){.train_views = 4, .val_views = 2, .width_px = 24, .height_px = 18});
}

TEST(nothing_without_effects) {
    struct vw_scene *scene = make_scene();
    struct cost none = measure(scene, "none");
    assert_int_equal(none.other_passes, 0);
    // Every byte belongs to a buffer that any run has, or stands in for one that a pass leaves alone; a buffer
    // of push blocks is a multiple of as many.
    uint64_t stand_in_bytes = none.device_bytes - none.shared_bytes;
    assert_int_equal(stand_in_bytes % STAND_IN_BYTES, 0);
    assert_true(stand_in_bytes / STAND_IN_BYTES <= none.pass_count);
    assert_int_equal(none.param_bytes, none.grid_and_weight_bytes);
}

// Returns whether an effect is in the list with transient, or in the one without: transient cannot be beside
// visibility, nor pose beside unbounded, nor appearance_encoder beside other appearance, nor uncertainty beside
// either.
static bool is_in(const char *effect, bool beside_transient) {
    static const char *const not_beside[] = {"visibility", "unbounded", "appearance", "appearance_code", "uncertainty"},
                             *const apart[] = {"transient", "pose", "appearance_encoder", "uncertainty"};
    bool left_out = false;
    for (size_t i = 0; i < VW_ARRAY_COUNT(not_beside) && beside_transient; i++)
        left_out |= !strcmp(effect, not_beside[i]);
    for (size_t i = 0; i < VW_ARRAY_COUNT(apart) && !beside_transient; i++) left_out |= !strcmp(effect, apart[i]);
    return !left_out;
}

// Checks that effects add no more together than the sum of what each adds alone.
static void check_together(const struct vw_scene *scene, const struct vw_effect_verdict *effects,
                           const struct cost *costs, uint32_t count, struct cost none, bool beside_transient) {
    uint64_t params = none.param_count, passes = none.other_passes;
    char list[256] = "";
    for (uint32_t i = 0; i < count; i++) {
        if (!is_in(effects[i].name, beside_transient)) continue;
        size_t length = strlen(list);
        snprintf(list + length, sizeof list - length, "%s%s", length ? "," : "", effects[i].name);
        params += costs[i].param_count - none.param_count;
        passes += costs[i].other_passes;
    }
    struct cost together = measure(scene, list);
    assert_true(together.param_count <= params && together.other_passes <= passes); // passes of two may be one
}

// One effect on: the others add nothing to it.
TEST(nothing_beside_another_effect) {
    struct vw_scene *scene = make_scene();
    struct vw_effect_verdict effects[VW_EFFECT_COUNT_MAX];
    struct cost none = measure(scene, "none"), costs[VW_EFFECT_COUNT_MAX];
    uint32_t count;
    vw_effects_list(effects, &count);
    for (uint32_t i = 0; i < count; i++) {
        costs[i] = measure(scene, effects[i].name);
        print_message("%-16s adds %6llu params, %8lld bytes on the device, %u passes\n", effects[i].name,
                      (unsigned long long)(costs[i].param_count - none.param_count),
                      (long long)(costs[i].device_bytes - none.device_bytes), costs[i].other_passes);
        assert_true(costs[i].device_bytes >= costs[i].shared_bytes);
    }
    check_together(scene, effects, costs, count, none, false);
    check_together(scene, effects, costs, count, none, true);
}
