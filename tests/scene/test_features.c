// Features of pixels: which files are found, how maps are scaled and interpolated, and what photos say without them.
#include "support/cmocka_test.h"

#include <inttypes.h>
#include <math.h>
#include <pthread.h>
#include <string.h>
#include <unistd.h>

#include "base/random.h"
#include "base/text.h"
#include "scene/features.h"
#include "support/feature_file.h"
#include "support/temporary_folder.h"
#include "support/tiny_scene.h"
#include "viewworth/log.h"

enum { PHOTOS = 8 };

// Writes a map for each photo but the last ones; number k of cell i of photo v is v + i (k + 1).
static struct vw_scene *open_with_maps(const char *folder, uint32_t maps, uint32_t channels) {
    tiny_scene_write(folder, &(struct tiny_scene){0});
    temporary_file(folder, "features/none", "");
    for (uint32_t v = 0; v < maps; v++) {
        AUTO_FREE float *numbers = vw_allocate(6 * channels, sizeof *numbers);
        char name[32];
        for (uint32_t i = 0; i < 6 * channels; i++) numbers[i] = (float)(v + (i / channels) * (i % channels + 1));
        snprintf(name, sizeof name, "features/%02u.npy", v);
        test_write_features(temporary_path(folder, name), 3, 2, channels, numbers);
    }
    return tiny_scene_open(SCENE_PARAMS(.path = folder));
}

// Photos 1, 2, 3, 5, 6 and 7 train: the mean of the first channel is 4 + 2.5, its variance 28 / 6 + 35 / 12.
FOLDER_TEST(maps_are_scaled_and_interpolated) {
    struct vw_scene *scene = open_with_maps(*state, PHOTOS, 2);
    assert_string_equal(scene->notes[scene->note_count - 1],
                        "8 photos with a file in features/, which the effect uncertainty reads");
    float numbers[VW_FEATURES];
    double deviation = sqrt(28.0 / 6.0 + 35.0 / 12.0);
    ASSERT_OK(vw_features_open(scene));
    vw_features_at(scene, 3, 0.5f, 0.5f, numbers); // the corner: cell 0
    assert_near(numbers[0], (3 - 6.5) / deviation, 1e-6);
    for (int i = 2; i < VW_FEATURES; i++) assert_near(numbers[i], 0, 0);
    vw_features_at(scene, 3, 4.0f, 1.5f, numbers); // the centre of cell 1
    assert_near(numbers[0], (3 + 1 - 6.5) / deviation, 1e-6);
    vw_features_at(scene, 3, 4.0f, 3.0f, numbers); // half way to cell 4
    assert_near(numbers[0], (3 + 2.5 - 6.5) / deviation, 1e-6);
    assert_near(numbers[1], (3 + 5 - 9) / sqrt(28.0 / 6.0 + 4 * 35.0 / 12.0), 1e-6);
    vw_features_at(scene, 3, 1e9f, 1e9f, numbers); // beyond the photo: cell 5
    assert_near(numbers[0], (3 + 5 - 6.5) / deviation, 1e-6);
}

static void keep_line(void *kept, enum vw_log_level level, const char *line) {
    (void)level;
    strncat(kept, line, 99 - strlen(kept));
}

// A preview of a photo in features/ is not taken for a map.
FOLDER_TEST(it_is_said_once_what_features_are_of) {
    char kept[100] = "";
    struct vw_scene *scene = open_with_maps(*state, PHOTOS, 2);
    tiny_photo_write(temporary_path(*state, "features/01.png"), 1);
    struct vw_scene *with_preview = tiny_scene_open(SCENE_PARAMS(.path = *state));
    assert_memory_equal(with_preview->hash, scene->hash, VW_HASH_BYTES);
    vw_log_set_sink(keep_line, kept);
    for (int i = 0; i < 2; i++) ASSERT_OK(vw_features_open(with_preview));
    assert_string_equal(kept, "uncertainty: by maps of 6 photos");
    *kept = 0;
    for (uint32_t v = 0; v < PHOTOS; v++) {
        AUTO_FREE char *name = vw_format_text("features/%02" PRIu32 ".npy", v);
        assert_int_equal(unlink(temporary_path(*state, name)), 0);
    }
    ASSERT_OK(vw_features_open(tiny_scene_open(SCENE_PARAMS(.path = *state))));
    vw_log_set_sink(NULL, NULL);
    assert_string_equal(kept, "uncertainty: by the photos, which have no maps in features/");
}

static void *open_in_thread(void *scene) { return vw_features_open(scene) ? NULL : scene; }

// Maps are read once for all trainings of a scene: files that have gone since are not missed. Those of validation and
// test photos are not read.
FOLDER_TEST(the_scene_keeps_the_maps_of_train_photos) {
    struct vw_scene *scene = open_with_maps(*state, PHOTOS, 2);
    const char *names[] = {"features/00.npy", "features/04.npy", "features/07.npy"};
    pthread_t threads[4];
    for (int i = 0; i < 2; i++) temporary_file(*state, names[i], "changed");
    for (int i = 0; i < 4; i++) assert_int_equal(pthread_create(&threads[i], NULL, open_in_thread, scene), 0);
    for (int i = 0; i < 4; i++) {
        void *opened = NULL;
        assert_int_equal(pthread_join(threads[i], &opened), 0);
        assert_non_null(opened);
    }
    temporary_file(*state, names[2], "changed");
    ASSERT_OK(vw_features_open(scene));
}

// Number k of all maps is v s + i c, the sums of signs and of signs times k + 1. The mean of v is 4, that of i is 2.5.
FOLDER_TEST(many_channels_are_projected) {
    struct vw_scene *scene = open_with_maps(*state, PHOTOS, 384);
    float first[VW_FEATURES], last[VW_FEATURES];
    double s = 0, c = 0;
    for (uint32_t channel = 0; channel < 384; channel++) {
        uint32_t words[4];
        vw_random_words(0, VW_RANDOM_PROJECTION, 0, channel, 0, words);
        s += words[0] >> 5 & 1 ? 1.0 : -1.0;
        c += words[0] >> 5 & 1 ? channel + 1.0 : -1.0 - channel;
    }
    ASSERT_OK(vw_features_open(scene));
    vw_features_at(scene, 1, 0.5f, 0.5f, first);
    vw_features_at(scene, 1, 7.5f, 5.5f, last);
    double deviation = sqrt(s * s * 28.0 / 6.0 + c * c * 35.0 / 12.0);
    assert_near(first[5], (-3.0 * s - 2.5 * c) / deviation, 1e-5);
    assert_near(last[5], (-3.0 * s + 2.5 * c) / deviation, 1e-5);
    assert_true(fabsf(first[5] - first[6]) > 1e-3f);
}

FOLDER_TEST(a_number_that_never_changes_is_0) {
    float numbers[VW_FEATURES];
    const float same[] = {1e20f};
    tiny_scene_write(*state, &(struct tiny_scene){.count = 3});
    temporary_file(*state, "features/none", "");
    for (uint32_t v = 0; v < 3; v++) {
        char name[32];
        snprintf(name, sizeof name, "features/%02u.png.npy", v); // the other name
        test_write_features(temporary_path(*state, name), 1, 1, 1, same);
    }
    struct vw_scene *scene = tiny_scene_open(SCENE_PARAMS(.path = *state));
    ASSERT_OK(vw_features_open(scene));
    vw_features_at(scene, 2, 3.0f, 3.0f, numbers);
    assert_near(numbers[0], 0, 0);
}

FOLDER_TEST(what_does_not_fit_is_refused) {
    const float number[] = {1};
    struct vw_scene *scene = open_with_maps(*state, PHOTOS - 1, 2);
    ASSERT_FAILS(vw_features_open(scene), VW_ERROR_INPUT, "images/07.png", "has no file in features/");
    const char *path = temporary_path(*state, "features/07.npy");
    test_write_features(path, 1, 1, 1, number);
    scene = tiny_scene_open(SCENE_PARAMS(.path = *state));
    ASSERT_FAILS(vw_features_open(scene), VW_ERROR_INPUT, "07.npy", "has 1 numbers a cell, but other files 2");
    temporary_file(*state, "features/07.npy", "other");
    ASSERT_FAILS(vw_features_open(scene), VW_ERROR_IO, "07.npy", "changed since the scene was opened");
    scene = tiny_scene_open(SCENE_PARAMS(.path = *state));
    ASSERT_FAILS(vw_features_open(scene), VW_ERROR_INPUT, "07.npy", "no .npy file");
    assert_int_equal(rename(path, temporary_path(*state, "features/07.exr")), 0);
    scene = tiny_scene_open(SCENE_PARAMS(.path = *state));
    ASSERT_FAILS(vw_features_open(scene), VW_ERROR_INPUT, "07.exr", "no .npy file");
    assert_int_equal(symlink("/etc/hostname", path), 0);
    tiny_folder_refused(*state, "07.npy");
}

FOLDER_TEST(the_hash_of_the_scene_covers_maps) {
    const float number[] = {1};
    tiny_scene_write(*state, &(struct tiny_scene){0});
    struct vw_scene *without = tiny_scene_open(SCENE_PARAMS(.path = *state));
    struct vw_scene *with = open_with_maps(*state, PHOTOS, 2);
    assert_memory_not_equal(without->hash, with->hash, VW_HASH_BYTES);
    test_write_features(temporary_path(*state, "features/05.npy"), 1, 1, 1, number);
    struct vw_scene *changed = tiny_scene_open(SCENE_PARAMS(.path = *state));
    assert_memory_not_equal(changed->hash, with->hash, VW_HASH_BYTES);
}

// A photo that becomes brighter by 20 / 255 a pixel to the right.
FOLDER_TEST(photos_have_features_of_their_own) {
    float numbers[VW_FEATURES];
    const uint32_t view = 1;
    tiny_scene_write(*state, &(struct tiny_scene){0});
    struct vw_scene *scene = tiny_scene_open(SCENE_PARAMS(.path = *state));
    ASSERT_OK(vw_scene_decode(scene, &view, 1));
    uint8_t *pixels = scene->views[view].image.pixels;
    for (uint32_t i = 0; i < TINY_WIDTH_PX * TINY_HEIGHT_PX * 4; i++)
        pixels[i] = i % 4 == 3 ? 255 : (uint8_t)(20 * (i / 4 % TINY_WIDTH_PX));
    ASSERT_OK(vw_features_open(scene));
    vw_features_at(scene, view, 3.5f, 2.5f, numbers);
    const double step = 20.0 / 255.0, colour = 4 * 3 * step - 2,
                 expected[] = {colour, colour, colour, 5 * 2 * step,
                               colour, colour, colour, 10 * step * sqrt(2.0 / 3),
                               colour, colour, colour, 20 * step * sqrt(2.0 / 3)};
    for (int k = 0; k < VW_FEATURES; k++) assert_near(numbers[k], k < 12 ? expected[k] : 0.0, 1e-5);
    vw_features_at(scene, view, 0.5f, 0.5f, numbers); // in the corner the edge goes on
    assert_near(numbers[0], -2, 0);
    assert_near(numbers[3], 5 * step, 1e-6);
    assert_near(numbers[4], 4 * step * (0 + 0 + 1) / 3 - 2, 1e-6);
}

TEST_GROUP(tiny_decoder_hold, NULL)
