// The learned sky and the random form of the background in whole trainings: what they change, what they must not, and
// what a sky buys.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "gpu/compute.h"
#include "support/temporary_folder.h"
#include "support/trainer_fixture.h"
#include "train/trainer.h"

static struct vw_scene *transparent_scene(void) {
    return synthetic_scene(&(struct synthetic_scene_params){
        .train_views = 5, .val_views = TEST_VALS, .width_px = 24, .height_px = 18, .alpha = true});
}

static struct vw_config config_with(const char *effects, enum vw_background_form form) {
    struct vw_config config = test_config();
    strcpy(config.effects, effects);
    config.background = form;
    return config;
}

TEST(runs_repeat_bit_for_bit) {
    struct vw_scene *scene = transparent_scene();
    const struct vw_config configs[] = {config_with("sky", VW_BACKGROUND_FIXED),
                                        config_with("background", VW_BACKGROUND_RANDOM),
                                        config_with("background,sky", VW_BACKGROUND_FIXED)};
    for (size_t i = 0; i < VW_ARRAY_COUNT(configs); i++) {
        struct test_run *first = test_run(scene, &configs[i], true, 1),
                        *grouped = test_run(scene, &configs[i], true, 7);
        test_run_assert_same(first, grouped);
        test_release(first);
        test_release(grouped);
    }
}

// A sky takes the background's place, and the targets stay on the scene's colour.
TEST(a_sky_leaves_nothing_to_the_form_of_the_background) {
    struct vw_scene *scene = transparent_scene();
    struct vw_config config = config_with("background,sky", VW_BACKGROUND_FIXED);
    struct test_run *fixed = test_run(scene, &config, true, 0);
    config.background = VW_BACKGROUND_RANDOM;
    struct test_run *random = test_run(scene, &config, true, 0);
    test_run_assert_same(fixed, random);
}

// Renders a view by a trainer with these params.
static float *render_field(const struct vw_scene *scene, const struct vw_config *config, const void *params,
                           uint32_t view) {
    struct vw_trainer *trainer = test_trainer_create(scene, config, true, 0);
    float *rgb = NULL;
    ASSERT_OK(vw_buffer_write(trainer->field.params, 0, params, trainer->model.param_bytes));
    ASSERT_OK(vw_trainer_render(trainer, view, &rgb));
    test_release(trainer);
    return rgb;
}

// Decision 1: the form is training's alone.
TEST(validation_knows_no_form_of_the_background) {
    struct vw_scene *scene = transparent_scene();
    struct vw_config forms[] = {config_with("background", VW_BACKGROUND_FIXED),
                                config_with("background", VW_BACKGROUND_RANDOM)};
    struct test_run *runs[2];
    float *rendered[2];
    for (int i = 0; i < 2; i++) runs[i] = test_run(scene, &forms[i], true, 0);
    for (int i = 0; i < 2; i++) rendered[i] = render_field(scene, &forms[i], runs[1]->params, 5);
    assert_memory_equal(rendered[0], rendered[1], 3 * 24 * 18 * sizeof(float));
    assert_memory_equal(runs[0]->views[0], runs[1]->views[0], sizeof runs[0]->views[0]); // both untrained
    assert_false(test_same_bits(runs[0]->records[1].train_loss, runs[1]->records[1].train_loss));
    for (int i = 0; i < 2; i++) {
        test_release(runs[i]);
    }
}

// 9 rgb coefficients, and what the step needs to learn them; without the effect none of it.
TEST(a_sky_costs_27_params) {
    struct vw_scene *scene = test_scene();
    struct vw_config without = config_with("none", VW_BACKGROUND_FIXED), with = config_with("sky", VW_BACKGROUND_FIXED);
    struct vw_trainer *trainers[2] = {test_trainer_create(scene, &without, true, 0),
                                      test_trainer_create(scene, &with, true, 0)};
    const struct vw_step_passes *steps[2] = {&trainers[0]->step, &trainers[1]->step};
    struct vw_trainer_stats stats[2];
    for (int i = 0; i < 2; i++) vw_trainer_get_stats(trainers[i], &stats[i]);
    assert_int_equal(stats[1].param_count - stats[0].param_count, 27);
    struct vw_buffer *const grown[][2] = {{trainers[0]->field.params, trainers[1]->field.params},
                                          {steps[0]->d_weights, steps[1]->d_weights},
                                          {steps[0]->weight_moments, steps[1]->weight_moments}};
    for (int i = 0; i < 3; i++) // the moments are two
        assert_int_equal(vw_buffer_size_bytes(grown[i][1]) - vw_buffer_size_bytes(grown[i][0]),
                         (i == 2 ? 2 : 1) * 16 * VW_SKY_COLUMNS);
    assert_int_equal(vw_buffer_size_bytes(steps[1]->effect_buffers[VW_SLOT_D_SKY]), 16 * steps[1]->padded_rays);
    test_trainer_has_no_effects(trainers[0]);
}

// The field's file holds the sky, and is refused where there is none.
TEST(a_field_keeps_its_sky) {
    char *folder = temporary_folder_create();
    const char *path = temporary_path(folder, "field.vwf");
    struct vw_scene *scene = test_scene();
    struct vw_config with = config_with("sky", VW_BACKGROUND_FIXED), without = config_with("none", VW_BACKGROUND_FIXED);
    struct test_run *run = test_allocate(1, sizeof *run);
    struct vw_trainer *trainer = test_trainer_create(scene, &with, true, 0),
                      *loaded = test_trainer_create(scene, &with, true, 0);
    float *trained = NULL, *again = NULL;
    test_run_finish(trainer, run);
    ASSERT_OK(vw_trainer_render(trainer, 5, &trained));
    ASSERT_OK(vw_trainer_save_field(trainer, path));
    ASSERT_OK(vw_trainer_load_field(loaded, path));
    ASSERT_OK(vw_trainer_render(loaded, 5, &again));
    assert_memory_equal(trained, again, 3 * 24 * 18 * sizeof(float));
    loaded = test_trainer_create(scene, &without, true, 0);
    assert_int_equal(vw_trainer_load_field(loaded, path), VW_ERROR_INPUT);
    free(trained);
    free(again);
    temporary_folder_remove(folder);
}

// scenes/sky.json at a quarter of its pixels: 3.9 dB were gained after 15 epochs, over three seeds.
TEST(a_sky_is_worth_its_params) {
    double psnr[2];
    struct vw_scene *scene =
        test_scene_open((struct vw_scene_params){.path = VW_SOURCE_FOLDER "/scenes/sky.json", .downscale = 2});
    for (int with = 0; with < 2; with++) {
        struct vw_config config = config_with(with ? "sky" : "none", VW_BACKGROUND_FIXED);
        config.epochs = 8;
        config.rays = 200;
        struct test_run *run = test_run(scene, &config, true, 0);
        psnr[with] = run->records[run->count - 1].val_psnr;
        test_release(run);
    }
    if (!(psnr[1] > psnr[0] + 1.0)) fail_msg("%.2f dB with a sky, %.2f dB without", psnr[1], psnr[0]);
}

TEST_GROUP(NULL, test_gpu_close)
