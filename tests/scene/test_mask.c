// Masks: where they are found, what they keep, and that training and the scene's hash heed them.
#include "support/cmocka_test.h"

#include <unistd.h>

#include "image/image.h"
#include "scene/builder.h"
#include "support/temporary_folder.h"
#include "support/tiny_scene.h"
#include "train/pixels.h"

// Writes a mask that is given as text: '#' is black, '+' is dark grey, '-' is light grey, '.' is white.
static const char *write_mask(const char *folder, const char *name, uint32_t width_px, uint32_t height_px,
                              const char *text) {
    AUTO_FREE float *pixels = vw_allocate(width_px * height_px * 3, sizeof *pixels);
    for (uint32_t i = 0; i < width_px * height_px * 3; i++)
        pixels[i] = text[i / 3] == '#' ? 0 : text[i / 3] == '+' ? 0.45f : text[i / 3] == '-' ? 0.55f : 1;
    const char *path = temporary_file(folder, name, "");
    ASSERT_OK(vw_image_save(path, width_px, height_px, 3, pixels));
    return path;
}

// Checks that the mask, written as text again, is the expected one.
static void check_mask(const uint8_t *mask, const char *expected) {
    assert_non_null(mask);
    char text[256] = "";
    for (size_t i = 0; i < strlen(expected); i++) text[i] = mask[i] ? '.' : '#';
    assert_string_equal(text, expected);
}

static enum vw_status load_mask(const char *path, uint32_t photo_width_px, uint32_t photo_height_px, uint32_t downscale,
                                uint8_t **mask) {
    struct vw_image_header header;
    struct vw_image file = {0};
    enum vw_status status = vw_mask_probe(NULL, path, photo_width_px, photo_height_px, &header);
    if (!status) status = vw_image_load(path, 1, &file);
    if (!status) status = vw_mask_make(path, &file, photo_width_px, photo_height_px, downscale, mask);
    vw_image_clear(&file);
    return status;
}

static void check_load(const char *path, uint32_t photo_width_px, uint32_t photo_height_px, uint32_t downscale,
                       const char *expected) {
    AUTO_FREE uint8_t *mask = NULL;
    ASSERT_OK(load_mask(path, photo_width_px, photo_height_px, downscale, &mask));
    check_mask(mask, expected);
}

FOLDER_TEST(white_keeps) {
    check_load(write_mask(*state, "m.png", 4, 2, ".#+--..#"), 4, 2, 1, ".##....#");
    const float rgba[2 * 4] = {1, 1, 1, 1, 1, 1, 1, 0.2f}; // transparent white does not keep
    const char *path = temporary_path(*state, "alpha.png");
    ASSERT_OK(vw_image_save(path, 2, 1, 4, rgba));
    check_load(path, 2, 1, 1, ".#");
}

FOLDER_TEST(a_mask_of_another_size_is_scaled) {
    const char *path = write_mask(*state, "m.png", 2, 2,
                                  ".#"
                                  "#.");
    check_load(path, 4, 4, 1,
               "..##"
               "..##"
               "##.."
               "##..");
    check_load(path, 1, 1, 1, "."); // its centre lies in the last mask pixel
    check_load(write_mask(*state, "large.png", 6, 3,
                          "##..##"
                          "#.####"
                          "......"),
               2, 1, 1, ".#"); // centres at 1.5 and 4.5: mask pixels 1 and 4 of row 1
}

FOLDER_TEST(downscale_keeps_whole_footprints) {
    const char *path = write_mask(*state, "m.png", 6, 4,
                                  "......"
                                  "...#.."
                                  "......"
                                  "#.....");
    check_load(path, 6, 4, 2,
               ".#."
               "#..");
    // 7 photo pixels become 3 of 2 1/3: the third of them belongs to the first and to the second.
    check_load(write_mask(*state, "odd.png", 7, 1, "..#...."), 7, 1, 2, "##.");
}

FOLDER_TEST(bad_masks_are_refused) {
    struct vw_image_header header;
    uint8_t *mask = NULL;
    const char *path = write_mask(*state, "m.png", 4, 2, ".......#");
    ASSERT_FAILS(load_mask(path, 4, 3, 1, &mask), VW_ERROR_INPUT, "4 x 2", "4 x 3");
    assert_int_equal(vw_mask_probe(NULL, path, 3, 2, &header), VW_ERROR_INPUT);
    ASSERT_OK(vw_mask_probe(NULL, path, 8, 4, &header));
    path = write_mask(*state, "black.png", 4, 2, "########");
    ASSERT_FAILS(load_mask(path, 4, 2, 1, &mask), VW_ERROR_INPUT, "hides the whole photo");
    assert_int_equal(load_mask(temporary_path(*state, "none.png"), 4, 2, 1, &mask), VW_ERROR_INPUT);
    assert_null(mask);
}

// ---- In scenes ------------------------------------------------------------------------------------------------------

static const char half[] = "####...." // mask of a photo of 8 x 6
                           "####...."
                           "####...."
                           "####...."
                           "####...."
                           "####....";
static const char most[] = "......##"
                           "........"
                           "........"
                           "........"
                           "........"
                           "........";

static struct vw_scene *open_scene(const char *folder) { return tiny_scene_open(SCENE_PARAMS(.path = folder)); }

FOLDER_TEST(masks_lie_beside_images) {
    static const char *const mask_names[] = {"masks/01.png", "masks/01.png.png"};
    for (size_t i = 0; i < VW_ARRAY_COUNT(mask_names); i++) {
        tiny_scene_write(*state, &(struct tiny_scene){.count = 4});
        write_mask(*state, mask_names[i], 8, 6, half);
        struct vw_scene *scene = open_scene(*state);
        assert_int_equal(scene->masked_view_count, 1);
        assert_null(scene->views[0].mask);
        check_mask(scene->views[1].mask, half);
        assert_int_equal(scene->note_count, 1);
        check_note(scene, "1 of 4 photos have a mask");
        assert_int_equal(unlink(temporary_path(*state, mask_names[i])), 0);
    }
}

// Photos are often JPEG while masks are PNG: the extension may be replaced.
FOLDER_TEST(masks_have_other_extensions) {
    tiny_scene_write(*state, &(struct tiny_scene){.count = 3, .name_suffix = ".jpg"});
    for (int i = 0; i < 3; i++) {
        char name[32], mask[32];
        snprintf(name, sizeof name, "images/0%d.jpg", i);
        snprintf(mask, sizeof mask, "masks/0%d.png", i);
        tiny_photo_write(temporary_path(*state, name), 0);
        write_mask(*state, mask, 8, 6, half);
    }
    struct vw_scene *scene = open_scene(*state);
    assert_int_equal(scene->masked_view_count, 3);
    check_mask(scene->views[2].mask, half);
    assert_int_equal(scene->note_count, 0);
}

FOLDER_TEST(mask_path_names_the_mask) {
    tiny_scene_write(*state, &(struct tiny_scene){.count = 3, .frame_keys = "\"mask_path\": \"./shapes/m.png\","});
    tiny_folder_refused(*state, "frame 0", "mask_path", "does not exist");
    write_mask(*state, "shapes/m.png", 8, 6, most);
    write_mask(*state, "masks/01.png", 8, 6, half); // the frame's word wins
    struct vw_scene *scene = open_scene(*state);
    assert_int_equal(scene->masked_view_count, 3);
    check_mask(scene->views[1].mask, most);
    write_mask(*state, "shapes/m.png", 8, 5, most);
    tiny_scene_refused(SCENE_PARAMS(.path = *state, .headers_only = true), VW_ERROR_INPUT, "m.png", "8 x 5");
    static const char *const outside[] = {"\"mask_path\": \"../m.png\",", "\"mask_path\": \"/m.png\",",
                                          "\"mask_path\": 3,"};
    for (size_t i = 0; i < VW_ARRAY_COUNT(outside); i++) {
        tiny_scene_write(*state, &(struct tiny_scene){.count = 3, .frame_keys = outside[i]});
        tiny_folder_refused(*state, "frame 0", "mask_path");
    }
}

FOLDER_TEST(masks_stay_in_the_folder) {
    AUTO_FOLDER char *elsewhere = temporary_folder_create();
    write_mask(elsewhere, "m.png", 8, 6, half);
    tiny_scene_write(*state, &(struct tiny_scene){.count = 3});
    ASSERT_OK(vw_folder_create(temporary_path(*state, "masks")));
    assert_int_equal(symlink(temporary_path(elsewhere, "m.png"), temporary_path(*state, "masks/02.png")), 0);
    tiny_folder_refused(*state, "masks/02.png", "through a link");
}

FOLDER_TEST(hidden_pixels_weigh_nothing) {
    tiny_scene_write(*state, &(struct tiny_scene){.count = 3});
    write_mask(*state, "masks/01.png", 8, 6, half);
    struct vw_scene *scene = open_scene(*state);
    ASSERT_OK(vw_scene_decode_all(scene));
    for (uint32_t i = 0; i < 48; i++) {
        assert_true(vw_pixels_at(scene, 1, true, i % 8, i / 8).weight == (i % 8 < 4 ? 0 : 1));
        assert_true(vw_pixels_at(scene, 1, false, i % 8, i / 8).weight == 1);
        assert_true(vw_pixels_at(scene, 0, true, i % 8, i / 8).weight == 1);
    }
}

FOLDER_TEST(masks_are_hashed) {
    uint8_t hashes[3][VW_HASH_BYTES];
    tiny_scene_write(*state, &(struct tiny_scene){.count = 3});
    for (int i = 0; i < 3; i++) {
        if (i) write_mask(*state, "masks/01.png", 8, 6, i == 1 ? half : most);
        struct vw_scene *scene = open_scene(*state);
        memcpy(hashes[i], scene->hash, VW_HASH_BYTES);
        for (int j = 0; j < i; j++) assert_memory_not_equal(hashes[i], hashes[j], VW_HASH_BYTES);
    }
}

TEST(masks_of_statue_of_liberty_are_read) {
    const char *path = real_scene_path("statue_of_liberty");
    if (!path) skip();
    struct vw_scene *scene = tiny_scene_open(SCENE_PARAMS(.path = path));
    assert_int_equal(scene->masked_view_count, 135);
    const uint8_t *mask = scene->views[0].mask; // the statue is in the middle, sky in the corners
    assert_int_equal(mask[0], 0);
    assert_int_equal(mask[192 * 256 + 128], 255);
}

TEST_GROUP(tiny_decoder_hold, NULL)
