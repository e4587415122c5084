// The promises of every effect, as tables: off it takes no room and no effect changes where the field begins; bits do
// not depend on submissions or parts; validation sees the field alone; it is refused by name where it cannot be.
#include "base/memory.h"
#include "base/text.h"
#include "support/cmocka_test.h"
#include "support/trainer_fixture.h"
#include "train/adjoint/lasting.h"
#include "train/effects/registry.h"
#include "train/fields/registry.h"

static struct vw_config config_with(enum vw_field field, const char *effects) {
    struct vw_config config = test_config_of(field);
    strcpy(config.effects, effects);
    return config;
}

// The promises of each effect with params.
static const struct promise {
    const char *effects;
    enum vw_field field;
    uint64_t params;      // for 5 train photos, and all 8 where validation needs one
    bool field_alone;     // validation sees the field alone
    bool refuses_lasting; // --lasting cannot go back through it
} promises[] = {
    {"sky", VW_FIELD_HASH, 27, false, false},
    {"appearance", VW_FIELD_HASH, 6 * 5, false, false},
    {"appearance_code", VW_FIELD_HASH, 48 * (16 + 5), false, false},
    {"appearance,appearance_code", VW_FIELD_HASH, 6 * 5 + 48 * (16 + 5), false, false},
    {"pose", VW_FIELD_HASH, 5 * 6, true, true},
    {"visibility", VW_FIELD_HASH, 16 * 39 + 16 * 17 + 17 + 5 * 16, true, false},
    {"uncertainty", VW_FIELD_HASH, 16 * 32 + 16 * 17 + 17, true, true},
    {"uncertainty", VW_FIELD_MLP, 16 * 32 + 16 * 17 + 17, true, false},
    {"transient", VW_FIELD_HASH, 16 * (16 + 16 + 1) + 16 * 17 + 5 * 17 + 16 * 5, true, true},
    {"transient", VW_FIELD_MLP, 8 * (16 + 16 + 1) + 3 * 8 * 9 + 5 * 9 + 16 * 5, true, false},
    {"appearance_encoder", VW_FIELD_HASH, 9 * 4 * 16 + 16 + 2 * (9 * 16 * 16 + 16) + 16 * 48 + 48 + 48 * 16, false,
     true},
};

TEST(every_effect_promises) {
    for (size_t i = 0; vw_effect_kinds[i]; i++) {
        bool found = false;
        for (size_t k = 0; k < VW_ARRAY_COUNT(promises); k++)
            found |= !strcmp(promises[k].effects, vw_effect_kinds[i]->name);
        if (!found) fail_msg("effect %s has no row in test_effect_promises.c", vw_effect_kinds[i]->name);
    }
}

// Asserts that a trainer has no passes, buffers or params of any effect.
static void assert_no_effects(const struct vw_trainer *trainer) {
    static const struct vw_effect_sets no_passes;
    assert_memory_equal(&trainer->step.effects, &no_passes, sizeof no_passes);
    assert_null(vw_volume_step_of(&trainer->step)->gradient.of_rays.gradient_sky);
    for (uint32_t i = 0; i < VW_SLOT_COUNT; i++) {
        assert_null(trainer->step.effect_buffers[i]);
        assert_null(trainer->field.effect_buffers[i]);
        assert_int_equal(trainer->model.ranges[i].size_bytes, 0);
    }
    assert_int_equal(trainer->model.moved_columns, trainer->model.weight_columns);
}

TEST(what_is_off_takes_no_room) {
    struct vw_scene *scene = test_scene();
    for (size_t i = 0; i < VW_ARRAY_COUNT(promises); i++) {
        struct vw_config off = config_with(promises[i].field, "none"),
                         on = config_with(promises[i].field, promises[i].effects);
        off.consistency_weight = 0.001; // weight for an effect that is off
        struct vw_trainer *without = test_trainer_create(scene, &off, true, 1),
                          *with = test_trainer_create(scene, &on, true, 1);
        uint64_t shared = without->model.weights.offset_bytes + without->model.weights.size_bytes;
        assert_no_effects(without);
        assert_null(without->field.head_rows);
        assert_null(without->validation.evaluator.views);
        assert_null(without->validation.view_fit.pass);
        assert_null(without->validation.view_fit.fits);
        assert_int_equal(without->model.param_bytes, shared);
        if (with->model.param_count - without->model.param_count != promises[i].params)
            fail_msg("%s: %llu params", promises[i].effects,
                     (unsigned long long)(with->model.param_count - without->model.param_count));
        assert_memory_equal(test_read(without->field.params), test_read(with->field.params), shared);
        test_release(without);
        test_release(with);
    }
}

TEST(bits_do_not_depend_on_submissions_or_parts) {
    static const struct {
        const char *effects;
        enum vw_field field;
        uint32_t rays, epochs; // 1200 rays are several chunks; cameras move before a checkpoint of 20 epochs, too
        double beta1, consistency_weight;
        enum vw_loss loss;
        uint32_t importance_samples;
        bool parts, full; // full: with --full alone
    } cases[] = {
        {"pose", VW_FIELD_HASH, 60, 20, 0, 0, VW_LOSS_L2, 0, true, true},
        {"pose,sky,appearance,appearance_code,visibility", VW_FIELD_HASH, 60, 20, 0.9, 0, VW_LOSS_L2, 0, true},
        {"pose,distortion", VW_FIELD_HASH, 1200, 8, 0, 0, VW_LOSS_L2, 0, true},
        {"visibility", VW_FIELD_HASH, 60, 3, 0, 0, VW_LOSS_L1, 0, false, true},
        {"visibility,appearance,sky", VW_FIELD_HASH, 60, 3, 0.9, 0, VW_LOSS_HUBER, 0, false},
        {"uncertainty", VW_FIELD_HASH, 60, 3, 0, 0, VW_LOSS_L1, 0, true},
        {"uncertainty,appearance,sky", VW_FIELD_HASH, 1200, 3, 0.9, 0, VW_LOSS_HUBER, 0, false},
        {"appearance_encoder,sky", VW_FIELD_HASH, 60, 3, 0, 0.01, VW_LOSS_L2, 0, true},
        {"appearance_encoder,uncertainty", VW_FIELD_MLP, 60, 3, 0.9, 0.01, VW_LOSS_L2, 8, false},
        {"appearance_encoder,visibility,sky", VW_FIELD_MLP, 60, 3, 0.9, 0, VW_LOSS_L2, 8, false, true},
        {"appearance_encoder,visibility,sky", VW_FIELD_MLP, 60, 3, 0.9, 0.01, VW_LOSS_L2, 8, false},
    };
    struct vw_scene *scene = test_scene();
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        if (cases[i].full && !test_is_full()) continue;
        struct vw_config config = config_with(cases[i].field, cases[i].effects);
        config.rays = cases[i].rays;
        config.epochs = cases[i].epochs;
        config.beta1 = cases[i].beta1;
        config.consistency_weight = cases[i].consistency_weight;
        config.importance_samples = cases[i].importance_samples;
        config.loss = cases[i].loss;
        struct test_run *one = test_run(scene, &config, true, 1), *many = test_run(scene, &config, true, 7),
                        *parts = cases[i].parts ? test_run_in_parts(scene, &config) : NULL;
        test_run_assert_same(one, many);
        if (parts) test_run_assert_same(one, parts);
        assert_int_equal(one->stats.nonfinite_steps, 0);
        test_release(one);
        test_release(many);
    }
}

// Decision 1: the params that a field has without the effect render the same with it, in train photos too, whatever the
// effect has learned.
TEST(validation_sees_the_field_alone) {
    struct vw_scene *scene = test_scene();
    for (size_t i = 0; i < VW_ARRAY_COUNT(promises); i++) {
        if (!promises[i].field_alone) continue;
        struct vw_config on = config_with(promises[i].field, promises[i].effects),
                         off = config_with(promises[i].field, "none");
        on.epochs = 8; // cameras move after 32 steps
        struct test_run *run = test_allocate(1, sizeof *run);
        struct vw_trainer *trained = test_trainer_create(scene, &on, true, 0),
                          *plain = test_trainer_create(scene, &off, true, 0);
        uint64_t own = plain->model.param_bytes, bytes = trained->model.param_bytes;
        const char *before = test_read(trained->field.params);
        float *expected = NULL, *found = NULL;
        test_run_finish(trained, run);
        assert_memory_not_equal(before + own, (const char *)run->params + own, bytes - own); // it has learned
        ASSERT_OK(vw_buffer_write(plain->field.params, 0, run->params, own));
        for (uint32_t view = 0; view < 6; view += 5) { // trained on, and not
            const struct vw_image *image = &scene->views[view].image;
            ASSERT_OK(vw_trainer_render(trained, view, &found));
            ASSERT_OK(vw_trainer_render(plain, view, &expected));
            assert_memory_equal(found, expected, 3 * sizeof(float) * image->width_px * image->height_px);
            free(expected);
            free(found);
            expected = found = NULL;
        }
        test_release(trained);
        test_release(plain);
        test_release(run);
    }
}

TEST(what_cannot_be_together_is_refused_by_name) {
    static const struct {
        const char *option, *found; // as --effects says, and what is on before fields and effects are heard
        enum vw_field field;
        enum vw_loss loss;
        double consistency_weight;
        const char *refused; // the message; NULL: nothing is refused
        const char *left;    // effect that is left out unasked
    } cases[] = {
        {"+pose", "pose", VW_FIELD_MLP, VW_LOSS_L2, 0, "pose needs --field hash, not mlp", NULL},
        {"+pose", "pose", VW_FIELD_HASH, VW_LOSS_L2, 0, NULL, NULL},
        {"+pose", "pose,unbounded", VW_FIELD_HASH, VW_LOSS_L2, 0, "pose excludes unbounded", NULL},
        {"auto", "visibility,transient", VW_FIELD_HASH, VW_LOSS_L2, 0, NULL, "visibility"},
        {"+transient", "visibility,transient", VW_FIELD_HASH, VW_LOSS_L2, 0, NULL, "visibility"},
        {"transient,visibility", "visibility,transient", VW_FIELD_HASH, VW_LOSS_L2, 0,
         "visibility cannot be beside transient", NULL},
        {"uncertainty,visibility", "uncertainty,visibility", VW_FIELD_HASH, VW_LOSS_L2, 0,
         "visibility cannot be beside uncertainty", NULL},
        {"uncertainty,transient", "uncertainty,transient", VW_FIELD_MLP, VW_LOSS_L2, 0,
         "transient cannot be beside uncertainty", NULL},
        {"uncertainty", "uncertainty", VW_FIELD_SPLATS, VW_LOSS_L2, 0, NULL, NULL},
        {"auto", "transient", VW_FIELD_HASH, VW_LOSS_HUBER, 0, "needs --loss l2, not huber", NULL},
        {"+appearance_encoder", "appearance_encoder,appearance", VW_FIELD_HASH, VW_LOSS_L2, 0, NULL, "appearance"},
        {"+appearance_encoder", "appearance_encoder,appearance_code", VW_FIELD_HASH, VW_LOSS_L2, 0, NULL,
         "appearance_code"},
        {"+appearance_encoder,+appearance", "appearance_encoder,appearance", VW_FIELD_HASH, VW_LOSS_L2, 0,
         "appearance_encoder replaces appearance", NULL},
        {"+appearance_encoder,+appearance_code", "appearance_encoder,appearance_code", VW_FIELD_HASH, VW_LOSS_L2, 0,
         "appearance_encoder replaces appearance", NULL},
        {"appearance_encoder,transient", "appearance_encoder,transient", VW_FIELD_HASH, VW_LOSS_L2, 0, NULL, NULL},
        {"appearance_encoder,transient", "appearance_encoder,transient", VW_FIELD_HASH, VW_LOSS_L2, 0.001,
         "--consistency-weight", NULL},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        struct vw_effect_decision decisions[VW_EFFECT_COUNT_MAX];
        uint32_t count;
        struct vw_config config = config_with(cases[i].field, cases[i].option);
        config.loss = cases[i].loss;
        config.consistency_weight = cases[i].consistency_weight;
        vw_effects_list(decisions, &count);
        for (uint32_t k = 0; k < count; k++) decisions[k].on = vw_word_list_has(cases[i].found, decisions[k].name);
        enum vw_status status = vw_effects_follow_field(&config, decisions, count);
        if (cases[i].refused) ASSERT_FAILS(status, VW_ERROR_USAGE, cases[i].refused);
        else ASSERT_OK(status);
        for (uint32_t k = 0; k < count && !status; k++)
            assert_int_equal(decisions[k].on, vw_word_list_has(cases[i].found, decisions[k].name) &&
                                                  !(cases[i].left && !strcmp(decisions[k].name, cases[i].left)));
        if (!status && strstr(cases[i].option, "+appearance_encoder"))
            assert_true(vw_effects_halve_views(decisions, count) && !vw_effects_fit_views(decisions, count));
    }
}

TEST(lasting_credit_refuses_by_name) {
    struct vw_scene *scene = test_scene();
    for (size_t i = 0; i < VW_ARRAY_COUNT(promises); i++) {
        if (!promises[i].refuses_lasting) continue;
        char remedy[64];
        struct vw_config config = config_with(VW_FIELD_HASH, promises[i].effects);
        struct vw_trainer_params training = {.gpu = test_gpu(), .scene = scene, .config = &config, .validate = true};
        struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 0);
        training.effects = vw_trainer_effects(trainer, &training.effect_count);
        struct vw_lasting *lasting = NULL;
        snprintf(remedy, sizeof remedy, "--effects -%s", promises[i].effects);
        ASSERT_FAILS(vw_lasting_create(&(struct vw_lasting_params){.training = &training}, &lasting), VW_ERROR_USAGE,
                     remedy);
        test_release(trainer);
    }
}

TEST_GROUP(NULL, test_gpu_close)
