// The effect `appearance_encoder` in whole trainings: that off it takes no room, that bits do not depend on batches,
// that every view has the code of its own photo, that whole views show it their left halves alone, what it replaces and
// refuses, and that it learns photos that differ in exposure.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "gpu/compute.h"
#include "support/trainer_fixture.h"
#include "train/adjoint/adjoint_passes.h"
#include "train/effects/encoder.h"
#include "train/trainer.h"

static struct vw_config config_with(const char *effects) {
    struct vw_config config = test_config();
    strcpy(config.effects, effects);
    return config;
}

TEST(what_is_off_takes_no_room) {
    struct vw_scene *scene = test_scene();
    struct vw_config off = config_with("none"), on = config_with("appearance_encoder");
    off.consistency_weight = 0.001; // of an effect that is off
    struct vw_trainer *without = test_trainer_create(scene, &off, true, 1),
                      *with = test_trainer_create(scene, &on, true, 1);
    uint64_t width = 4 * with->model.specialization.width4;
    test_trainer_has_no_effects(without);
    assert_null(without->step.consistency);
    assert_null(with->step.consistency);
    assert_null(without->validation.evaluator.views);
    assert_int_equal(with->model.param_count - without->model.param_count,
                     9 * 4 * 16 + 16 + 2 * (9 * 16 * 16 + 16) + 16 * 48 + 48 + 48 * width);
    assert_int_equal(with->model.param_bytes - without->model.param_bytes,
                     4 * (with->model.param_count - without->model.param_count));
    assert_int_equal(with->validation.view_fit.fits != NULL, 0);
    vw_trainer_destroy(&without);
    vw_trainer_destroy(&with);
    vw_scene_close(&scene);
}

TEST(bits_do_not_depend_on_batches) {
    struct vw_scene *scene = test_scene();
    for (int other = 0; other < 3; other++) {
        struct vw_config config = other ? test_config_of(VW_FIELD_MLP) : test_config();
        config.consistency_weight = other == 1 ? 0.0 : 0.01;
        strcpy(config.effects, other ? "appearance_encoder,visibility,sky" : "appearance_encoder");
        config.beta1 = other ? 0.9 : 0.0;
        config.importance_samples = other ? 8 : 0;
        struct test_run *one = test_run(scene, &config, true, 1), *many = test_run(scene, &config, true, 7);
        test_run_assert_same(one, many);
        assert_int_equal(one->stats.nonfinite_steps, 0);
        test_run_free(one);
        test_run_free(many);
    }
    vw_scene_close(&scene);
}

// ---- Codes of views -------------------------------------------------------------------------------------------------

static struct vw_trainer *train(const struct vw_scene *scene, const struct vw_config *config) {
    struct test_run *run = vw_allocate(1, sizeof *run);
    struct vw_trainer *trainer = test_trainer_create(scene, config, true, 0);
    test_run_finish(trainer, run);
    test_run_free(run);
    return trainer;
}

static void read_colours(struct vw_trainer *trainer, vw_float4 *colours, uint32_t count) {
    struct vw_evaluator *evaluator = &trainer->validation.evaluator;
    ASSERT_OK(vw_evaluator_run(evaluator));
    ASSERT_OK(vw_buffer_read(evaluator->colours, 0, colours, count * sizeof *colours));
}

// Views whose rays fill no whole groups: validation sees each pixel as a render of its view does, and another photo's
// thumbnail changes its own view alone.
TEST(every_view_has_the_code_of_its_photo) {
    struct vw_scene *scene = test_scene();
    for (enum vw_field field = 0; field < VW_FIELD_COUNT; field++) {
        struct vw_config config = test_config_of(field);
        strcpy(config.effects, "appearance_encoder");
        config.val_rays = 101;
        config.samples = 7;
        struct vw_trainer *trainer = train(scene, &config);
        uint32_t count = trainer->validation.ray_count, changed = 0;
        vw_float4 *before = vw_allocate(count, sizeof *before), *after = vw_allocate(count, sizeof *after),
                  colour = {0};
        const struct vw_pixel *pixels = vw_buffer_map(trainer->validation.evaluator.pixels);
        struct vw_evaluator one = {0};
        ASSERT_OK(vw_evaluator_create(&trainer->field, 1, &one));
        read_colours(trainer, before, count);
        for (uint32_t i = 0; i < count; i += 5) {
            ASSERT_OK(vw_evaluator_render(&one, &pixels[i], 1, &colour));
            assert_memory_equal(&colour, &before[i], sizeof colour);
        }
        uint32_t view = trainer->validation.views[1];
        const struct vw_thumbnail_choice corner = {{0, 1}, true};
        ASSERT_OK(vw_encoder_set_thumbnail(&trainer->field, scene, view, &corner));
        read_colours(trainer, after, count);
        for (uint32_t i = 0; i < count; i++) {
            bool differs = memcmp(&before[i], &after[i], sizeof *before) != 0;
            if (pixels[i].view != view) assert_false(differs);
            changed += differs;
        }
        assert_true(changed > 20);
        vw_evaluator_destroy(&one);
        vw_trainer_destroy(&trainer);
        free(before);
        free(after);
    }
    vw_scene_close(&scene);
}

static void brighten(struct vw_scene *scene, uint32_t view, uint32_t first, uint32_t end) {
    const struct vw_image *image = &scene->views[view].image;
    for (uint32_t i = 0; i < image->width_px * image->height_px; i++)
        if (i % image->width_px >= first && i % image->width_px < end) memset((uint8_t *)image->pixels + 4 * i, 250, 3);
}

// What is rendered depends on the left half alone; afterwards the whole photo is seen again.
TEST(whole_views_show_their_left_halves) {
    struct vw_scene *scene = test_scene();
    struct vw_config config = config_with("appearance_encoder");
    struct vw_trainer *trainer = train(scene, &config);
    struct vw_whole_view seen[3] = {0};
    float *renders[2] = {NULL};
    uint32_t view = trainer->validation.views[0], width = scene->views[view].image.width_px,
             count = width * scene->views[view].image.height_px;
    ASSERT_OK(vw_trainer_render(trainer, view, &renders[0]));
    ASSERT_OK(vw_trainer_measure_whole(trainer, view, &seen[0]));
    ASSERT_OK(vw_trainer_render(trainer, view, &renders[1]));
    assert_memory_equal(renders[0], renders[1], 3 * count * sizeof *renders[0]);
    brighten(scene, view, width / 2 + 1, width);
    ASSERT_OK(vw_trainer_measure_whole(trainer, view, &seen[1]));
    assert_memory_equal(seen[0].rendered, seen[1].rendered, 3 * count * sizeof *seen[0].rendered);
    assert_true(seen[0].error.mse != seen[1].error.mse);
    brighten(scene, view, 0, width / 2);
    ASSERT_OK(vw_trainer_measure_whole(trainer, view, &seen[2]));
    assert_memory_not_equal(seen[0].rendered, seen[2].rendered, 3 * count * sizeof *seen[0].rendered);
    for (uint32_t i = 0; i < count; i++) assert_int_equal(seen[0].counts[i], i % width >= (width + 1) / 2);
    for (int i = 0; i < 3; i++) vw_whole_view_free(&seen[i]);
    free(renders[0]);
    free(renders[1]);
    vw_trainer_destroy(&trainer);
    vw_scene_close(&scene);
}

// ---- Beside others --------------------------------------------------------------------------------------------------

TEST(it_replaces_other_appearance) {
    static const char *const others[] = {"appearance", "appearance_code"};
    struct vw_effect_verdict verdicts[VW_EFFECT_COUNT_MAX];
    uint32_t count;
    for (int named = 0; named < 2; named++)
        for (size_t i = 0; i < VW_ARRAY_COUNT(others); i++) {
            struct vw_config config = config_with("+appearance_encoder");
            if (named) strcat(strcat(config.effects, ",+"), others[i]);
            vw_effects_list(verdicts, &count);
            for (uint32_t k = 0; k < count; k++)
                verdicts[k].on =
                    !strcmp(verdicts[k].name, "appearance_encoder") || !strcmp(verdicts[k].name, others[i]);
            assert_int_equal(vw_effects_follow_field(&config, verdicts, count), named ? VW_ERROR_USAGE : VW_OK);
            if (named) assert_non_null(strstr(vw_error_message(), "appearance_encoder replaces appearance"));
            else assert_false(vw_effects_is_on(verdicts, count, others[i]));
            assert_true(vw_effects_is_on(verdicts, count, "appearance_encoder"));
            if (!named) assert_true(vw_effects_halve_views(verdicts, count) && !vw_effects_fit_views(verdicts, count));
        }
}

TEST(the_consistency_loss_is_not_beside_transients) {
    struct vw_config config = config_with("appearance_encoder,transient");
    struct vw_effect_verdict verdicts[VW_EFFECT_COUNT_MAX];
    uint32_t count;
    vw_effects_list(verdicts, &count);
    for (int weighs = 0; weighs < 2; weighs++) {
        config.consistency_weight = weighs ? 0.001 : 0.0;
        ASSERT_OK(vw_effects_choose(config.effects, verdicts, count));
        assert_int_equal(vw_effects_follow_field(&config, verdicts, count), weighs ? VW_ERROR_USAGE : VW_OK);
    }
    assert_non_null(strstr(vw_error_message(), "--consistency-weight"));
}

// Its weight is part of what a run is, and absent where it is 0, as in runs from before there was one.
TEST(the_weight_of_consistency_is_in_the_config) {
    struct vw_config config = vw_config_default, read = vw_config_default;
    char *text = vw_config_to_json(&config, true);
    assert_null(strstr(text, "consistency"));
    free(text);
    config.consistency_weight = 0.001;
    text = vw_config_to_json(&config, true);
    assert_non_null(strstr(text, "\"consistency_weight\":0.001"));
    free(text);
    text = vw_config_to_json(&config, false);
    ASSERT_OK(vw_config_from_json(text, &read));
    assert_true(read.consistency_weight == 0.001);
    free(text);
    config.consistency_weight = -0.001;
    assert_int_equal(vw_config_check(&config), VW_ERROR_USAGE);
}

TEST(the_sweep_refuses_it) {
    struct vw_scene *scene = test_scene();
    struct vw_config config = config_with("appearance_encoder");
    struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 0);
    struct vw_adjoint_passes sweep;
    const struct vw_adjoint_params params = {.batch_steps = 1};
    ASSERT_FAILS(vw_adjoint_create(vw_trainer_context(trainer), &params, &sweep), VW_ERROR_USAGE,
                 "--effects -appearance_encoder");
    vw_trainer_destroy(&trainer);
    vw_scene_close(&scene);
}

// ---- Learning -------------------------------------------------------------------------------------------------------

static double trained_psnr(const struct vw_scene *scene, const char *effects) {
    struct vw_config config = config_with(effects);
    config.epochs = 20;
    config.rays = 100;
    config.levels = 6;
    struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 0);
    struct test_run *run = vw_allocate(1, sizeof *run);
    double psnr = 0.0;
    test_run_finish(trainer, run);
    for (uint32_t i = run->count - 20; i < run->count; i++) psnr += run->records[i].val_psnr / 20.0;
    vw_trainer_destroy(&trainer);
    test_run_free(run);
    return psnr;
}

TEST(photos_of_their_own_exposure_are_learned) {
    struct vw_scene *scene = NULL;
    const struct vw_scene_params params = {
        .path = VW_SOURCE_FOLDER "/scenes/exposure.json", .downscale = 2, .gpu = test_gpu()};
    ASSERT_OK(vw_scene_open(&params, &scene));
    double without = trained_psnr(scene, "none"), with = trained_psnr(scene, "appearance_encoder");
    print_message("%.2f dB with the encoder, %.2f without\n", with, without);
    assert_true(with > without + 1.0);
    vw_scene_close(&scene);
}

TEST_GROUP(NULL, test_gpu_close)
