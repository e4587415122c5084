// The effect uncertainty in whole trainings: it finds what stands before the scene in single photos, by what photos
// show and by maps of features, with both renderers. (What all effects promise: test_effect_promises.)
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "base/random.h"
#include "gpu/compute.h"
#include "image/image.h"
#include "reference/reference.h"
#include "scene/features.h"
#include "support/feature_file.h"
#include "support/temporary_folder.h"
#include "support/tiny_scene.h"
#include "support/trainer_fixture.h"
#include "train/trainer.h"

// ---- Boxes before the scene -----------------------------------------------------------------------------------------

// Returns whether a box hides the pixel: every train photo has one of its own colour, a third of it wide and high.
static bool is_hidden(const struct vw_image *image, uint32_t view, uint32_t x_px, uint32_t y_px) {
    uint32_t left = (view * 7 % 3) * image->width_px / 3, top = (view * 5 % 3) * image->height_px / 3;
    return x_px >= left && x_px < left + image->width_px / 3 && y_px >= top && y_px < top + image->height_px / 3;
}

static void draw_box_colour(uint32_t view, uint8_t colour[3]) {
    uint32_t words[4];
    vw_random_words(7, VW_RANDOM_RECIPE, 0, view, 0, words);
    for (int c = 0; c < 3; c++) colour[c] = words[c] % 2 ? 250 : 5; // brighter or darker than the scene
}

static struct vw_scene *open_hidden(void) {
    struct vw_scene *scene = test_scene_open((struct vw_scene_params){.path = VW_SOURCE_FOLDER "/scenes/clean.json"});
    for (uint32_t view = 0; view < scene->view_count; view++) {
        const struct vw_image *image = &scene->views[view].image;
        uint8_t colour[3];
        draw_box_colour(view, colour);
        for (uint32_t i = 0; i < image->width_px * image->height_px && scene->views[view].split == VW_SPLIT_TRAIN; i++)
            if (is_hidden(image, view, i % image->width_px, i / image->width_px))
                memcpy((uint8_t *)image->pixels + 4 * i, colour, sizeof colour);
    }
    return scene;
}

// Returns the probability that a pixel of a box is held for less certain than one beside it, over all train photos.
static double find_auc(const struct vw_scene *scene, const struct vw_trainer *trainer, const float *params) {
    struct reference_params *reference = reference_params_create(&trainer->model, params);
    enum { BINS = 4096 };
    double counts[2][BINS] = {{0}}, totals[2] = {0}, above = 0.0, below = 0.0;
    for (uint32_t view = 0; view < scene->view_count; view++) {
        const struct vw_image *image = &scene->views[view].image;
        for (uint32_t i = 0; i < image->width_px * image->height_px && scene->views[view].split == VW_SPLIT_TRAIN;
             i++) {
            float numbers[VW_FEATURES];
            double inputs[REFERENCE_FEATURES];
            uint32_t x_px = i % image->width_px, y_px = i / image->width_px;
            vw_features_at(scene, view, (float)x_px + 0.5f, (float)y_px + 0.5f, numbers);
            for (uint32_t k = 0; k < VW_FEATURES; k++) inputs[k] = numbers[k];
            inputs[VW_FEATURES] = 1.0;
            uint32_t bin = (uint32_t)(reference_certainty(reference->uncertainty, inputs) * (BINS - 1));
            bool hidden = is_hidden(image, view, x_px, y_px);
            counts[hidden][bin]++;
            totals[hidden]++;
        }
    }
    for (uint32_t bin = 0; bin < BINS; bin++) {
        above += counts[0][bin] * (below + counts[1][bin] / 2.0);
        below += counts[1][bin];
    }
    return above / totals[0] / totals[1];
}

// Trains with the effect and returns how well it tells boxes; `psnr` is with it and without.
static double train(const struct vw_scene *scene, struct vw_config config, double psnr[2]) {
    double auc = 0.0;
    for (int with = 0; with < 2; with++) {
        strcpy(config.effects, with ? "uncertainty" : "none");
        struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 0);
        struct test_run *run = test_run_of(trainer);
        assert_int_equal(run->stats.nonfinite_steps, 0);
        psnr[with] = run->records[run->count - 1].val_psnr;
        if (with) auc = find_auc(scene, trainer, (const float *)run->params);
        test_release(trainer);
        test_release(run);
    }
    print_message("%s: %.2f dB with uncertainty, %.2f without; AUC of boxes %.3f\n", vw_field_name(config.field),
                  psnr[1], psnr[0], auc);
    return auc;
}

TEST(boxes_before_the_scene_are_uncertain) {
    double psnr[2];
    struct vw_config config = test_config();
    config.epochs = 20;
    config.rays = 100;
    config.levels = 6;
    assert_true(train(open_hidden(), config, psnr) > 0.7);
}

TEST(splats_have_it_too) {
    double psnr[2];
    struct vw_config config = test_config_of(VW_FIELD_SPLATS);
    config.epochs = 20;
    assert_true(train(open_hidden(), config, psnr) > 0.7);
}

// ---- Maps -----------------------------------------------------------------------------------------------------------

enum { PHOTOS = 8, WIDTH = 24, HEIGHT = 18 };

// The scene is grey; boxes have colours of their own that are as dark, and maps of a quarter of the resolution tell
// them.
FOLDER_TEST(maps_tell_boxes) {
    tiny_scene_write(*state, &(struct tiny_scene){0});
    temporary_file(*state, "features/none", "");
    for (uint32_t view = 0; view < PHOTOS; view++) {
        float pixels[HEIGHT * WIDTH * 3], map[HEIGHT / 2 * WIDTH / 2];
        const struct vw_image size = {.width_px = WIDTH, .height_px = HEIGHT};
        char photo[32], features[32];
        for (uint32_t i = 0; i < HEIGHT * WIDTH; i++)
            for (uint32_t c = 0; c < 3; c++)
                pixels[3 * i + c] = is_hidden(&size, view, i % WIDTH, i / WIDTH) ? (c == view % 3 ? 0.9f : 0.1f) : 0.4f;
        for (uint32_t i = 0; i < HEIGHT / 2 * WIDTH / 2; i++)
            map[i] = is_hidden(&size, view, 2 * (i % (WIDTH / 2)), 2 * (i / (WIDTH / 2))) ? 100.0f : 97.0f;
        snprintf(photo, sizeof photo, "images/%02u.png", view);
        snprintf(features, sizeof features, "features/%02u.npy", view);
        ASSERT_OK(vw_image_save(temporary_path(*state, photo), WIDTH, HEIGHT, 3, pixels));
        test_write_features(temporary_path(*state, features), WIDTH / 2, HEIGHT / 2, 1, map);
    }
    double psnr[2];
    struct vw_config config = test_config();
    config.epochs = 40;
    config.rays = 100;
    assert_true(train(tiny_scene_open(SCENE_PARAMS(.path = *state)), config, psnr) > 0.99);
}

TEST_GROUP(NULL, test_gpu_close)
