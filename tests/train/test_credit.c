// That errors are what they are said to be, and credited to the right photo. The box is out of every camera's sight, so
// that whatever the field is, it renders black: the error of a photo is its own brightness, which differs from photo to
// photo.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "base/random.h"
#include "image/image.h"
#include "support/trainer_fixture.h"
#include "train/pixels.h"
#include "train/trainer.h"

static const double FLOAT_TOLERANCE = 1e-6; // brightness and its error are floats

static uint8_t byte_of(uint32_t view) { return (uint8_t)(20 + 25 * view); }
static double brightness(uint32_t view) { return byte_of(view) / 255.0; }

static struct vw_scene *grey_scene(void) {
    struct vw_scene *scene = test_scene();
    for (uint32_t v = 0; v < scene->view_count; v++) {
        struct vw_image *image = &scene->views[v].image;
        uint8_t *pixels = image->pixels;
        for (uint32_t i = 0; i < 4 * image->width_px * image->height_px; i++) pixels[i] = i % 4 == 3 ? 255 : byte_of(v);
    }
    scene->box.centre_world[2] = 1e3;
    return scene;
}

TEST(a_step_counts_for_the_photo_it_trained_on) {
    struct vw_scene *scene = grey_scene();
    struct vw_config config = test_config();
    config.loss = VW_LOSS_L1; // the error itself
    struct test_run *run = test_run(scene, &config, true, 0);
    assert_true(run->count > 1);
    for (uint32_t i = 1; i < run->count; i++)
        assert_near(run->records[i].train_loss, brightness(run->records[i].view), FLOAT_TOLERANCE);
}

// Also where views have different numbers of usable pixels.
TEST(an_error_counts_for_the_view_it_is_of) {
    struct vw_scene *scene = grey_scene();
    struct vw_config config = test_config();
    uint32_t count, pixel_count = scene->views[0].image.width_px * scene->views[0].image.height_px;
    struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 0);
    const uint32_t *views = vw_trainer_validation_views(trainer, &count);
    assert_int_equal(count, TEST_VALS);
    scene->views[views[1]].image.unusable = vw_allocate(pixel_count, 1);
    for (uint32_t i = 0; i < pixel_count; i += 3) scene->views[views[1]].image.unusable[i] = 1;
    struct test_run *run = test_run(scene, &config, true, 0);
    for (uint32_t i = 0; i < run->count; i++) {
        for (uint32_t v = 0; v < count; v++) {
            assert_near(run->views[i][v].l1, brightness(views[v]), FLOAT_TOLERANCE);
            assert_near(run->views[i][v].mse, brightness(views[v]) * brightness(views[v]), FLOAT_TOLERANCE);
        }
    }
}

// A target is half the background where a photo is half transparent, and the render is all of it.
TEST(the_background_is_behind_what_is_transparent) {
    static const uint8_t rgba[4] = {40, 230, 90, 128};
    static const float background[3] = {0.9f, 0.4f, 0.1f};
    struct vw_scene *scene = grey_scene();
    struct vw_config config = test_config();
    config.loss = VW_LOSS_L1; // the error itself
    double expected = 0.0;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        struct vw_image *image = &scene->views[v].image;
        image->has_alpha = true;
        for (uint32_t i = 0; i < 4 * image->width_px * image->height_px; i++)
            ((uint8_t *)image->pixels)[i] = rgba[i % 4];
    }
    scene->has_alpha = true;
    memcpy(scene->background, background, sizeof background);
    for (int c = 0; c < 3; c++) expected += rgba[3] / 255.0 * fabs(background[c] - rgba[c] / 255.0) / 3.0;
    struct test_run *run = test_run(scene, &config, true, 0);
    for (uint32_t i = 0; i < run->count; i++) {
        if (i > 0) assert_near(run->records[i].train_loss, expected, FLOAT_TOLERANCE);
        assert_near(run->records[i].val_l1, expected, FLOAT_TOLERANCE);
    }
}

// An order that comes back would credit the same photo twice with what its place in the epoch is worth.
TEST(every_epoch_has_an_order_of_its_own) {
    enum { EPOCHS = 40, PHOTOS = 20 };
    uint32_t orders[EPOCHS][PHOTOS];
    for (uint32_t epoch = 0; epoch < EPOCHS; epoch++) {
        vw_random_order(1, epoch, PHOTOS, orders[epoch]);
        for (uint32_t earlier = 0; earlier < epoch; earlier++)
            if (!memcmp(orders[earlier], orders[epoch], sizeof orders[epoch]))
                fail_msg("epochs %u and %u", earlier, epoch);
    }
}

TEST(pixels_are_taken_at_their_centres) {
    struct vw_scene *scene = test_scene();
    float rgba[4];
    vw_image_pixel(&scene->views[1].image, 7, 3, rgba);
    struct vw_pixel pixel = vw_pixels_at(scene, 1, true, 7, 3);
    assert_true(pixel.x_px == 7.5f && pixel.y_px == 3.5f && pixel.view == 1 && pixel.weight == 1.0f);
    assert_true(pixel.rgba.x == rgba[0] && pixel.rgba.y == rgba[1] && pixel.rgba.z == rgba[2] &&
                pixel.rgba.w == rgba[3]);
}

TEST_GROUP(NULL, test_gpu_close)
