// Every field of the registry through the whole trainer: it learns, the same run has the same bits however its steps
// are grouped, a snapshot in a file carries on, and what it cannot do is refused by name.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "support/temporary_folder.h"
#include "support/trainer_fixture.h"
#include "train/fields/registry.h"

enum { FORMS = VW_FIELD_COUNT + 1 };

// Returns a config of every field, and of the mlp with a coarse network.
static struct vw_config config_of_form(uint32_t form) {
    struct vw_config config = test_config_of(form < VW_FIELD_COUNT ? (enum vw_field)form : VW_FIELD_MLP);
    if (form < VW_FIELD_COUNT) return config;
    config.samples = 8;
    config.importance_samples = 12;
    config.coarse_network = VW_COARSE_NETWORK_OWN;
    return config;
}

TEST(every_field_learns_whatever_its_submissions) {
    struct vw_scene *scene = test_scene();
    for (uint32_t form = 0; form < FORMS; form++) {
        struct vw_config config = config_of_form(form);
        config.epochs = 12;
        test_run_assert_learns(scene, &config, form < VW_FIELD_COUNT ? 0.6 : 0.7); // fewer samples
    }
}

// Each part in a trainer of its own, from the checkpoint of the one before.
TEST(a_run_in_parts_is_the_run) {
    struct vw_scene *scene = test_scene();
    static const char *const effects[] = {"sky,appearance,appearance_code,visibility",
                                          "sky,appearance_encoder,transient"};
    for (uint32_t i = 0; i < FORMS * VW_ARRAY_COUNT(effects); i++) {
        struct vw_config config = config_of_form(i / VW_ARRAY_COUNT(effects));
        config.beta1 = 0.9;
        config.burn_in_epochs = 0;
        strcpy(config.effects, effects[i % VW_ARRAY_COUNT(effects)]);
        struct test_run *whole = test_run(scene, &config, true, 0), *parts = test_run_in_parts(scene, &config);
        test_run_assert_same(whole, parts);
        test_release(whole);
        test_release(parts);
    }
}

TEST(a_saved_field_renders_as_the_trained_one) {
    char *folder = temporary_folder_create();
    const char *path = temporary_path(folder, "field.vwf");
    struct vw_scene *scene = test_scene();
    for (enum vw_field field = 0; field < VW_FIELD_COUNT; field++) {
        const struct vw_config config = test_config_of(field), other = test_config_of((field + 1) % VW_FIELD_COUNT);
        struct test_run *run = test_allocate(1, sizeof *run);
        struct vw_trainer *trainer = test_trainer_create(scene, &config, false, 0),
                          *loaded = test_trainer_create(scene, &config, false, 0),
                          *wrong = test_trainer_create(scene, &other, false, 0);
        float *trained_rgb = NULL, *loaded_rgb = NULL;
        test_run_finish(trainer, run);
        ASSERT_OK(vw_trainer_save_field(trainer, path));
        ASSERT_OK(vw_trainer_load_field(loaded, path));
        assert_int_equal(vw_trainer_load_field(wrong, path), VW_ERROR_INPUT);
        ASSERT_OK(vw_trainer_render(trainer, 0, &trained_rgb));
        ASSERT_OK(vw_trainer_render(loaded, 0, &loaded_rgb));
        const struct vw_image *image = &scene->views[0].image;
        assert_memory_equal(trained_rgb, loaded_rgb, 3 * sizeof(float) * image->width_px * image->height_px);
        free(trained_rgb);
        free(loaded_rgb);
        test_release(trainer);
        test_release(loaded);
        test_release(wrong);
        test_release(run);
    }
    temporary_folder_remove(folder);
}

TEST(what_a_field_cannot_have_is_refused_by_name) {
    struct vw_effect_verdict verdicts[VW_EFFECT_COUNT_MAX];
    struct vw_config config = test_config_of(VW_FIELD_MLP);
    uint32_t count;
    for (int named = 0; named < 2; named++) {
        vw_effects_list(verdicts, &count);
        for (uint32_t i = 0; i < count; i++) verdicts[i].on = strcmp(verdicts[i].name, "pose") != 0; // see test_pose
        strcpy(config.effects, named ? "+occupancy" : "auto");
        enum vw_status status = vw_effects_follow_field(&config, verdicts, count);
        assert_int_equal(status, named ? VW_ERROR_USAGE : VW_OK);
        if (named) assert_non_null(strstr(vw_error_message(), "occupancy is not there with --field mlp"));
        else assert_false(vw_effects_is_on(verdicts, count, "occupancy"));
        assert_true(vw_effects_is_on(verdicts, count, "sky"));
    }
    config.levels = 4;
    ASSERT_FAILS(vw_config_check(&config), VW_ERROR_USAGE, "need --field hash");
    config = test_config();
    config.mlp_depth = 3;
    ASSERT_FAILS(vw_config_check(&config), VW_ERROR_USAGE, "need --field mlp");
    config = test_config();
    config.width = 24;
    ASSERT_FAILS(vw_config_check(&config), VW_ERROR_USAGE, "16, 32 or 64 with --field hash");
}

TEST(configs_survive_json) {
    for (enum vw_field field = 0; field < VW_FIELD_COUNT; field++) {
        const struct vw_config config = test_config_of(field);
        struct vw_config back;
        char *text = vw_config_to_json(&config, true), *again;
        assert_non_null(strstr(text, "\"field\""));
        char *whole = vw_config_to_json(&config, false);
        ASSERT_OK(vw_config_from_json(whole, &back));
        again = vw_config_to_json(&back, true);
        assert_string_equal(text, again);
        assert_int_equal(back.mlp_depth, config.mlp_depth);
        free(text);
        free(whole);
        free(again);
    }
}

TEST_GROUP(NULL, test_gpu_close)
