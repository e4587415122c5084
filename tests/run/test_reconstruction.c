// Measuring a reconstruction: whole photos that were not trained on, at one size, whatever size was trained at.
#include "support/cmocka_test.h"

#include "base/memory.h"

#include "image/image.h"
#include "run/outputs/reconstruction.h"
#include "support/trainer_fixture.h"

static struct vw_reconstruction measure(const struct vw_scene *scene, const char *options, enum vw_field field) {
    struct vw_config config = test_config_of(field);
    strcpy(config.effects, "none");
    struct vw_reconstruction measured;
    struct vw_trainer *trainer = test_trainer_create(scene, &config, false, 0);
    (void)test_run_of(trainer);
    ASSERT_OK(vw_reconstruction_measure(
        &(struct vw_reconstruction_params){
            .scene = scene, .scene_options_json = options, .gpu = test_gpu(), .trainer = trainer},
        &measured));
    test_release(trainer);
    return measured;
}

TEST(the_stored_size_is_divided_until_it_fits) {
    struct vw_scene *scene = test_scene();
    static const struct {
        uint32_t width_px, trained_downscale, downscale;
    } cases[] = {{640, 1, 1}, {641, 1, 2}, {480, 4, 3}, {120, 4, 1}, {1080, 4, 7}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        scene->views[1].camera.width_px = cases[i].width_px;
        assert_int_equal(vw_reconstruction_downscale(scene, cases[i].trained_downscale), cases[i].downscale);
    }
}

TEST(a_photo_that_a_train_photo_copies_does_not_count) {
    struct vw_scene *scene = test_scene();
    uint32_t view = scene->view_count - 1, twin = 0, train = 0;
    while (scene->views[train].split != VW_SPLIT_TRAIN) train++;
    assert_int_equal(scene->views[view].split, VW_SPLIT_VAL);
    const struct vw_reconstruction all = measure(scene, "{}", VW_FIELD_HASH);
    assert_int_equal(all.view_count, TEST_VALS);
    assert_false(all.of_test);
    twin = train;
    memcpy(scene->views[view].camera_to_world, scene->views[twin].camera_to_world,
           sizeof scene->views[view].camera_to_world);
    const struct vw_image *from = &scene->views[twin].image, *to = &scene->views[view].image;
    memcpy(to->pixels, from->pixels, vw_view_image_bytes(scene, twin));
    assert_int_equal(measure(scene, "{}", VW_FIELD_HASH).view_count, TEST_VALS - 1);
}

// Both fields are measured on the same pixels, which are those of the files: the mean colours are the same bits.
TEST(the_size_of_training_changes_nothing_of_what_is_measured) {
    double mean_colour_db[2][2];
    for (uint32_t downscale = 1; downscale <= 2; downscale++) {
        char options[32];
        struct vw_scene *scene = test_scene_open(
            (struct vw_scene_params){.path = VW_SOURCE_FOLDER "/tests/support/tiny.json", .downscale = downscale});
        snprintf(options, sizeof options, downscale > 1 ? "{\"downscale\":%u}" : "{}", downscale);
        for (int i = 0; i < 2; i++) {
            const struct vw_reconstruction seen = measure(scene, options, i ? VW_FIELD_SPLATS : VW_FIELD_HASH);
            assert_true(seen.of_test && seen.view_count == 1 && seen.psnr_db > 3 && isfinite(seen.ssim));
            assert_int_equal(seen.trained_px[0], 16 / downscale);
            assert_true(seen.measured_px[0] == 16 && seen.measured_px[1] == 12);
            mean_colour_db[downscale - 1][i] = seen.mean_colour_db;
        }
    }
    for (int i = 1; i < 4; i++) assert_true(mean_colour_db[i / 2][i % 2] == mean_colour_db[0][0]);
}
