// The effect appearance_encoder in whole trainings: every view has the code of its own photo, whole views show it their
// left halves alone, and it learns photos that differ in exposure. (What all effects promise: test_effect_promises.)
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "gpu/compute.h"
#include "support/trainer_fixture.h"
#include "train/effects/appearance_encoder.h"
#include "train/trainer.h"

// ---- Codes of views -------------------------------------------------------------------------------------------------

static struct vw_trainer *train(const struct vw_scene *scene, const struct vw_config *config) {
    struct vw_trainer *trainer = test_trainer_create(scene, config, true, 0);
    test_run_of(trainer);
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
    for (enum vw_field field = 0; field < VW_FIELD_SPLATS; field++) { // splats have no encoder
        struct vw_config config = test_config_of(field);
        strcpy(config.effects, "appearance_encoder");
        config.val_rays = 101;
        config.samples = 7;
        struct vw_trainer *trainer = train(scene, &config);
        uint32_t count = trainer->validation.ray_count, changed = 0;
        vw_float4 *before = test_allocate(count, sizeof *before), *after = test_allocate(count, sizeof *after),
                  colour = {0};
        const struct vw_pixel *pixels = vw_buffer_map(trainer->validation.evaluator.pixels);
        struct vw_evaluator one = {0};
        ASSERT_OK(vw_evaluator_create(&trainer->field, 1, false, &one));
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
        test_release(trainer);
    }
}

static void brighten(struct vw_scene *scene, uint32_t view, uint32_t first, uint32_t end) {
    const struct vw_image *image = &scene->views[view].image;
    for (uint32_t i = 0; i < image->width_px * image->height_px; i++)
        if (i % image->width_px >= first && i % image->width_px < end) memset((uint8_t *)image->pixels + 4 * i, 250, 3);
}

// The render depends on the left half alone; afterwards the whole photo is seen again.
TEST(whole_views_show_their_left_halves) {
    struct vw_scene *scene = test_scene();
    struct vw_config config = test_config_with("appearance_encoder");
    struct vw_trainer *trainer = train(scene, &config);
    struct vw_whole_view seen[3] = {0};
    float *renders[2] = {NULL};
    uint32_t view = trainer->validation.views[0], width = scene->views[view].image.width_px,
             count = width * scene->views[view].image.height_px;
    ASSERT_OK(vw_trainer_render(trainer, view, &renders[0]));
    ASSERT_OK(vw_trainer_measure_whole(trainer, view, 0, &seen[0]));
    ASSERT_OK(vw_trainer_render(trainer, view, &renders[1]));
    assert_memory_equal(renders[0], renders[1], 3 * count * sizeof *renders[0]);
    brighten(scene, view, width / 2 + 1, width);
    ASSERT_OK(vw_trainer_measure_whole(trainer, view, 0, &seen[1]));
    assert_memory_equal(seen[0].rendered, seen[1].rendered, 3 * count * sizeof *seen[0].rendered);
    assert_true(seen[0].error.mse != seen[1].error.mse);
    brighten(scene, view, 0, width / 2);
    ASSERT_OK(vw_trainer_measure_whole(trainer, view, 0, &seen[2]));
    assert_memory_not_equal(seen[0].rendered, seen[2].rendered, 3 * count * sizeof *seen[0].rendered);
    for (uint32_t i = 0; i < count; i++) assert_int_equal(seen[0].counts[i], i % width >= (width + 1) / 2);
    for (int i = 0; i < 3; i++) vw_whole_view_free(&seen[i]);
    free(renders[0]);
    free(renders[1]);
}

// ---- Beside others --------------------------------------------------------------------------------------------------

// Its weight is part of what a run is.
TEST(the_weight_of_consistency_is_in_the_config) {
    struct vw_config config = vw_config_default, read = vw_config_default;
    char *text = vw_config_to_json(&config, true);
    assert_non_null(strstr(text, "\"consistency_weight\":0.0"));
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

// ---- Learning -------------------------------------------------------------------------------------------------------

static double trained_psnr(const struct vw_scene *scene, const char *effects) {
    struct vw_config config = test_config_with(effects);
    config.epochs = 20;
    config.rays = 100;
    config.levels = 6;
    struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 0);
    struct test_run *run = test_allocate(1, sizeof *run);
    double psnr = 0.0;
    test_run_finish(trainer, run);
    for (uint32_t i = run->count - 20; i < run->count; i++) psnr += run->records[i].val_psnr / 20.0;
    return psnr;
}

TEST(photos_of_their_own_exposure_are_learned) {
    struct vw_scene *scene =
        test_scene_open((struct vw_scene_params){.path = VW_SOURCE_FOLDER "/scenes/exposure.json", .downscale = 2});
    double without = trained_psnr(scene, "none"), with = trained_psnr(scene, "appearance_encoder");
    print_message("%.2f dB with the encoder, %.2f without\n", with, without);
    assert_true(with > without + 1.0);
}

TEST_GROUP(NULL, test_gpu_close)
