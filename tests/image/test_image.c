// Photos: formats, alpha, linear light, what is masked and clamped, downscaling, writing.
#include "support/cmocka_test.h"

#include <fcntl.h>
#include <unistd.h>

#include "image/image.h"
#include "support/temporary_folder.h"
#include "support/tiny_scene.h"

// ---- A minimal TIFF, which can hold every kind of pixel that viewworth reads ----------------------------------------

enum alpha { ALPHA_NONE = -1, ALPHA_ASSOCIATED = 1, ALPHA_STRAIGHT = 2 }; // as TIFF counts them

enum photometric {
    PHOTOMETRIC_GREY_OR_RGB,
    PHOTOMETRIC_PALETTE = 3,
    PHOTOMETRIC_CMYK = 5
}; // from 1 on as TIFF counts them

struct tiff {
    uint32_t width_px, height_px, channels, bits;
    bool is_float;
    enum alpha alpha;
    const void *pixels;
    enum photometric photometric;
    uint32_t orientation;    // as EXIF counts; 0: not given
    const uint16_t *palette; // 256 reds, 256 greens, 256 blues
};

struct tiff_field {
    uint16_t tag, type; // type 3: 16 bit, 4: 32 bit
    uint32_t count, value;
};

static const char *write_tiff(const char *folder, const char *name, const struct tiff *tiff) {
    enum {
        HEADER = 8,
        FIELDS_MAX = 14,
        BITS_AT = HEADER + 2 + FIELDS_MAX * 12 + 4,
        KINDS_AT = BITS_AT + 8,
        PALETTE_AT = KINDS_AT + 8,
        PALETTE_COUNT = 3 * 256,
        PIXELS_AT = PALETTE_AT + 2 * PALETTE_COUNT
    };
    uint32_t pixel_bytes = tiff->width_px * tiff->height_px * tiff->channels * tiff->bits / 8;
    uint32_t channels = tiff->channels, kind = tiff->is_float ? 3 : 1;
    const struct tiff_field fields[] = {
        {256, 4, 1, tiff->width_px},
        {257, 4, 1, tiff->height_px},
        {258, 3, channels, channels < 3 ? tiff->bits * 0x10001 : BITS_AT},
        {259, 3, 1, 1}, // uncompressed
        {262, 3, 1,
         tiff->photometric ? tiff->photometric
         : channels < 3    ? 1
                           : 2}, // grey or RGB
        {273, 4, 1, PIXELS_AT},
        {274, 3, tiff->orientation ? 1 : 0, tiff->orientation},
        {277, 3, 1, channels},
        {278, 4, 1, tiff->height_px},
        {279, 4, 1, pixel_bytes},
        {284, 3, 1, 1}, // interleaved
        {320, 3, tiff->palette ? PALETTE_COUNT : 0, PALETTE_AT},
        {338, 3, tiff->alpha == ALPHA_NONE ? 0 : 1, (uint32_t)tiff->alpha},
        {339, 3, channels, channels < 3 ? kind * 0x10001 : KINDS_AT},
    };
    uint16_t field_count = 0; // fields without values are left out
    AUTO_FREE uint8_t *file = calloc(1, PIXELS_AT + pixel_bytes);
    assert_non_null(file);
    memcpy(file, "II*\0\x08\0\0", HEADER);
    for (size_t i = 0; i < VW_ARRAY_COUNT(fields); i++)
        if (fields[i].count) memcpy(file + HEADER + 2 + 12 * field_count++, &fields[i], 12);
    memcpy(file + HEADER, &field_count, 2);
    if (tiff->palette) memcpy(file + PALETTE_AT, tiff->palette, 2 * PALETTE_COUNT);
    for (uint32_t c = 0; c < 4; c++) {
        memcpy(file + BITS_AT + 2 * c, &tiff->bits, 2);
        memcpy(file + KINDS_AT + 2 * c, &kind, 2);
    }
    memcpy(file + PIXELS_AT, tiff->pixels, pixel_bytes);
    const char *path = temporary_path(folder, name);
    ASSERT_OK(vw_file_write(path, file, PIXELS_AT + pixel_bytes));
    return path;
}

static void clear_image(void *image) { vw_image_clear(image); }

// Loads an image that the test owns.
static struct vw_image *load(const char *path, uint32_t downscale) {
    struct vw_image *image = test_allocate(1, sizeof *image);
    ASSERT_OK(vw_image_load(path, downscale, image));
    return test_own(image, clear_image);
}

static void check_pixel(const struct vw_image *image, uint32_t x_px, uint32_t y_px, const float expected[4],
                        double tolerance) {
    float rgba[4];
    vw_image_pixel(image, x_px, y_px, rgba);
    for (int c = 0; c < 4; c++)
        if (!(fabs(rgba[c] - expected[c]) <= tolerance))
            fail_msg("pixel (%u, %u) is %g %g %g %g, not %g %g %g %g", x_px, y_px, rgba[0], rgba[1], rgba[2], rgba[3],
                     expected[0], expected[1], expected[2], expected[3]);
}

static double srgb(double linear) {
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
}

// ---- Formats --------------------------------------------------------------------------------------------------------

FOLDER_TEST(png_round_trips) {
    const char *path = temporary_path(*state, "a.png");
    const float pixels[2 * 3 * 4] = {1,    0,    0,    1,    0,      1, 0, 1, /**/ 0, 0,    1,    1,
                                     0.2f, 0.4f, 0.6f, 0.5f, /**/ 1, 1, 1, 0, 0.1f,   0.1f, 0.1f, 1};
    ASSERT_OK(vw_image_save(path, 2, 3, 4, pixels));
    struct vw_image_header header;
    ASSERT_OK(vw_image_probe(path, VW_IMAGE_OF_PATH, &header));
    assert_int_equal(header.width_px, 2);
    assert_int_equal(header.height_px, 3);
    struct vw_image *image = load(path, 1);
    assert_int_equal(image->format, VW_PIXEL_UINT8);
    assert_true(image->has_alpha);
    for (uint32_t i = 0; i < 6; i++)
        check_pixel(image, i % 2, i / 2, pixels + 4 * i, 0.5 / 255 + 1e-6); // straight, even below alpha 0
    vw_image_clear(image);
    assert_null(image->pixels);
}

FOLDER_TEST(exr_round_trips) {
    const char *path = temporary_path(*state, "a.exr");
    const float pixels[2 * 4] = {0.9f, 0.5f, 0.02f, 1, 0.8f, 0.1f, 0.3f, 0.25f};
    ASSERT_OK(vw_image_save(path, 2, 1, 4, pixels));
    struct vw_image *image = load(path, 1);
    assert_int_equal(image->format, VW_PIXEL_FLOAT32);
    check_pixel(image, 0, 0, pixels, 1e-5);
    check_pixel(image, 1, 0, pixels + 4, 1e-5);
}

FOLDER_TEST(an_opaque_image_has_no_alpha) {
    const char *path = temporary_path(*state, "a.png");
    const float rgb[3] = {0.2f, 0.4f, 0.6f};
    ASSERT_OK(vw_image_save(path, 1, 1, 3, rgb));
    struct vw_image *image = load(path, 1);
    assert_false(image->has_alpha);
    check_pixel(image, 0, 0, (const float[]){0.2f, 0.4f, 0.6f, 1}, 0.5 / 255);
    const float rgba[4] = {0.2f, 0.4f, 0.6f, 1}; // an alpha channel, but nothing transparent
    ASSERT_OK(vw_image_save(path, 1, 1, 4, rgba));
    image = load(path, 1);
    assert_false(image->has_alpha);
}

FOLDER_TEST(grey_becomes_three_channels) {
    const uint8_t one[2] = {51, 102}, two[2] = {51, 102};
    struct tiff tiff = {2, 1, 1, 8, false, ALPHA_NONE, .pixels = one};
    struct vw_image *image = load(write_tiff(*state, "grey.tif", &tiff), 1);
    check_pixel(image, 0, 0, (const float[]){0.2f, 0.2f, 0.2f, 1}, 1e-6);
    check_pixel(image, 1, 0, (const float[]){0.4f, 0.4f, 0.4f, 1}, 1e-6);
    tiff = (struct tiff){1, 1, 2, 8, false, ALPHA_STRAIGHT, .pixels = two};
    image = load(write_tiff(*state, "grey_alpha.tif", &tiff), 1);
    check_pixel(image, 0, 0, (const float[]){0.2f, 0.2f, 0.2f, 0.4f}, 1e-6);
    assert_true(image->has_alpha);
}

FOLDER_TEST(sixteen_bits_are_kept) {
    const uint16_t pixels[2][4] = {{1, 256, 65534, 65535}, {40000, 20000, 10000, 32768}};
    const struct tiff tiff = {2, 1, 4, 16, false, ALPHA_STRAIGHT, .pixels = pixels};
    struct vw_image *image = load(write_tiff(*state, "a.tif", &tiff), 1);
    assert_int_equal(image->format, VW_PIXEL_UINT16);
    assert_memory_equal(image->pixels, pixels, sizeof pixels); // bit for bit
    assert_true(image->has_alpha);
}

FOLDER_TEST(an_alpha_of_sixteen_bits_is_opaque_at_its_most) {
    static const uint16_t alphas[] = {0x00FF, 0xFF00, 0xFFFF};
    for (int i = 0; i < 3; i++) {
        const uint16_t pixel[4] = {1, 2, 3, alphas[i]};
        const struct tiff tiff = {1, 1, 4, 16, false, ALPHA_STRAIGHT, .pixels = pixel};
        assert_true(load(write_tiff(*state, "a.tif", &tiff), 1)->has_alpha == (i < 2));
    }
}

TEST(luminance_weighs_channels_over_the_background) {
    uint8_t pixels[] = {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 51}; // the last a fifth opaque
    const struct vw_image image = {.width_px = 2, .height_px = 2, .format = VW_PIXEL_UINT8, .pixels = pixels};
    const float background[3] = {0.5f, 0, 0};
    const double expected[] = {0.2126, 0.7152, 0.0722, 0.2 + 0.8 * 0.5 * 0.2126};
    for (uint32_t i = 0; i < 4; i++) // in floats, but for the sum
        assert_true(fabs(vw_image_luminance(&image, i % 2, i / 2, background) - expected[i]) < 1e-6);
}

FOLDER_TEST(associated_alpha_is_divided_out) {
    const uint8_t pixels[4] = {64, 32, 0, 128};
    const struct tiff tiff = {1, 1, 4, 8, false, ALPHA_ASSOCIATED, .pixels = pixels};
    struct vw_image *image = load(write_tiff(*state, "a.tif", &tiff), 1);
    check_pixel(image, 0, 0, (const float[]){0.5f, 0.25f, 0, 128 / 255.0f}, 0.5 / 255 + 1e-6);
}

FOLDER_TEST(palettes_are_looked_up) {
    const uint8_t indices[2] = {7, 200};
    static uint16_t palette[3][256];
    palette[0][7] = 0xffff, palette[1][7] = 0x8080, palette[2][7] = 0;
    palette[0][200] = 0x1010, palette[1][200] = 0x2020, palette[2][200] = 0x3030;
    const struct tiff tiff = {
        2, 1, 1, 8, false, ALPHA_NONE, .pixels = indices, .photometric = PHOTOMETRIC_PALETTE, .palette = palette[0]};
    struct vw_image *image = load(write_tiff(*state, "palette.tif", &tiff), 1);
    check_pixel(image, 0, 0, (const float[]){1, 128 / 255.0f, 0, 1}, 1e-6);
    check_pixel(image, 1, 0, (const float[]){16 / 255.0f, 32 / 255.0f, 48 / 255.0f, 1}, 1e-6);
}

// Inks darken: red is what cyan and black leave, (1 - C)(1 - K). JPEG files hold the inks' complements, as Adobe writes
// them.
FOLDER_TEST(cmyk_becomes_rgb) {
    const float expected[4] = {0.8f * 0.9f, 0.6f * 0.9f, 0.4f * 0.9f, 1};
    const uint8_t inks[4] = {51, 102, 153, 26};
    struct tiff tiff = {1, 1, 4, 8, false, ALPHA_NONE, .pixels = inks, .photometric = PHOTOMETRIC_CMYK};
    struct vw_image *image = load(write_tiff(*state, "cmyk.tif", &tiff), 1);
    check_pixel(image, 0, 0, expected, 1.0 / 255);
    assert_false(image->has_alpha); // the fourth channel is ink
    const uint16_t fine_inks[4] = {13107, 26214, 39321, 6554};
    tiff.bits = 16;
    tiff.pixels = fine_inks;
    image = load(write_tiff(*state, "cmyk16.tif", &tiff), 1);
    check_pixel(image, 0, 0, expected, 2.0 / 65535);
    static const uint8_t jpeg[] = {
        // 8 x 8 pixels of 204 153 102 230
        0xff, 0xd8, 0xff, 0xee, 0x00, 0x0e, 0x41, 0x64, 0x6f, 0x62, 0x65, 0x00, 0x64, 0x00, 0x00, 0x00, 0x00, 0x00,
        0xff, 0xdb, 0x00, 0x43, 0x00, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01,
        0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01,
        0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01,
        0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0x01, 0xff, 0xc0, 0x00,
        0x14, 0x08, 0x00, 0x08, 0x00, 0x08, 0x04, 0x43, 0x11, 0x00, 0x4d, 0x11, 0x00, 0x59, 0x11, 0x00, 0x4b, 0x11,
        0x00, 0xff, 0xc4, 0x00, 0x15, 0x00, 0x01, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
        0x00, 0x00, 0x00, 0x00, 0x08, 0x0a, 0xff, 0xc4, 0x00, 0x14, 0x10, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
        0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0xff, 0xda, 0x00, 0x0e, 0x04, 0x43, 0x00, 0x4d,
        0x00, 0x59, 0x00, 0x4b, 0x00, 0x00, 0x3f, 0x00, 0xa6, 0x03, 0x20, 0x2f, 0x59, 0x83, 0xff, 0xd9,
    };
    const char *path = temporary_path(*state, "cmyk.jpg");
    ASSERT_OK(vw_file_write(path, jpeg, sizeof jpeg));
    image = load(path, 1);
    assert_int_equal(image->width_px, 8);
    check_pixel(image, 7, 7, expected, 1.0 / 255);
}

// Poses belong to the pixels as stored, whichever way up a camera was held.
FOLDER_TEST(orientation_is_ignored) {
    const uint8_t pixels[3 * 2] = {0, 51, 102, 153, 204, 255};
    for (uint32_t orientation = 1; orientation <= 8; orientation++) {
        const struct tiff tiff = {3, 2, 1, 8, false, ALPHA_NONE, .pixels = pixels, .orientation = orientation};
        const char *path = write_tiff(*state, "turned.tif", &tiff);
        struct vw_image *image = load(path, 1);
        struct vw_image_header header;
        ASSERT_OK(vw_image_probe(path, VW_IMAGE_OF_PATH, &header));
        assert_int_equal(header.orientation, orientation); // told, for who looks for defects
        assert_int_equal(image->width_px, 3);
        for (uint32_t i = 0; i < 6; i++) {
            float grey = (float)i / 5;
            check_pixel(image, i % 3, i / 3, (const float[]){grey, grey, grey, 1}, 1e-6);
        }
    }
}

// ---- Floats: linear light, masks, clamps ----------------------------------------------------------------------------

FOLDER_TEST(floats_are_encoded_masked_and_clamped) {
    float pixels[100][3];
    for (int i = 0; i < 100; i++) pixels[i][0] = 0.5f, pixels[i][1] = 0.002f, pixels[i][2] = 1;
    pixels[3][1] = NAN;
    pixels[4][0] = -0.01f;
    pixels[5][2] = INFINITY;
    pixels[6][0] = 7, pixels[6][1] = 1.5f;
    const struct tiff tiff = {10, 10, 3, 32, true, ALPHA_NONE, .pixels = pixels};
    struct vw_image *image = load(write_tiff(*state, "a.tif", &tiff), 1);
    assert_int_equal(image->format, VW_PIXEL_FLOAT32);
    assert_int_equal(image->masked_count, 3);
    assert_int_equal(image->clamped_count, 2);
    assert_false(image->has_alpha); // masked is not transparent
    check_pixel(image, 0, 0, (const float[]){(float)srgb(0.5), (float)srgb(0.002), 1, 1}, 1e-6);
    for (uint32_t x = 3; x < 6; x++) check_pixel(image, x, 0, (const float[]){0, 0, 0, 0}, 0);
    for (uint32_t i = 0; i < 100; i++) assert_int_equal(image->unusable[i], i >= 3 && i < 6);
    check_pixel(image, 6, 0, (const float[]){1, 1, 1, 1}, 1e-6);
}

FOLDER_TEST(too_many_masked_pixels_are_refused) {
    float pixels[100][3];
    for (int i = 0; i < 100; i++) pixels[i][0] = pixels[i][1] = pixels[i][2] = i < 5 ? NAN : 0.5f;
    const struct tiff tiff = {10, 10, 3, 32, true, ALPHA_NONE, .pixels = pixels};
    struct vw_image *image = load(write_tiff(*state, "five.tif", &tiff), 1); // 5 % is allowed
    assert_int_equal(image->masked_count, 5);
    pixels[50][0] = -1;
    struct vw_image refused;
    const char *path = write_tiff(*state, "six.tif", &tiff);
    ASSERT_FAILS(vw_image_load(path, 1, &refused), VW_ERROR_INPUT, "six.tif", "6.0 %");
}

// ---- Downscaling ----------------------------------------------------------------------------------------------------

FOLDER_TEST(downscale_keeps_constants) {
    static float pixels[37 * 23 * 3];
    for (int i = 0; i < 37 * 23; i++) pixels[3 * i] = 0.2f, pixels[3 * i + 1] = 1, pixels[3 * i + 2] = 0;
    const char *path = temporary_path(*state, "a.png");
    ASSERT_OK(vw_image_save(path, 37, 23, 3, pixels));
    struct vw_image *image = load(path, 4);
    assert_int_equal(image->width_px, 9);
    assert_int_equal(image->height_px, 5);
    assert_int_equal(image->format, VW_PIXEL_UINT16);
    for (uint32_t i = 0; i < 45; i++) check_pixel(image, i % 9, i / 9, (const float[]){0.2f, 1, 0, 1}, 1.0 / 65535);
    image = load(path, 100);
    assert_int_equal(image->width_px * image->height_px, 1);
}

// A ramp along x: each small pixel shows the ramp at its own centre, so nothing shifts and the mean stays.
FOLDER_TEST(downscale_keeps_ramps) {
    enum { WIDTH = 64, HEIGHT = 8 };
    static uint16_t pixels[HEIGHT][WIDTH][3];
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++)
            for (int c = 0; c < 3; c++) pixels[y][x][c] = (uint16_t)(1000 + 900 * x);
    const struct tiff tiff = {WIDTH, HEIGHT, 3, 16, false, ALPHA_NONE, .pixels = pixels};
    struct vw_image *image = load(write_tiff(*state, "a.tif", &tiff), 4);
    double mean = 0;
    for (uint32_t x = 0; x < 16; x++) {
        double centre = (x + 0.5) * 4 - 0.5;
        float expected = (float)((1000 + 900 * centre) / 65535), rgba[4];
        if (x >= 3 && x < 13)
            check_pixel(image, x, 1, (const float[]){expected, expected, expected, 1}, 2e-4); // away from the edges
        vw_image_pixel(image, x, 1, rgba);
        mean += rgba[0] / 16;
    }
    assert_near(mean, (1000 + 900 * 31.5) / 65535, 1e-3);
}

// Green beside transparent red: none of the hidden red may show, and the green must not darken.
FOLDER_TEST(downscale_has_no_fringe) {
    enum { SIDE = 32 };
    static float pixels[SIDE][SIDE][4];
    for (int y = 0; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++) pixels[y][x][x < 14 ? 1 : 0] = 1, pixels[y][x][3] = x < 14 ? 1 : 0;
    const char *path = temporary_path(*state, "a.png");
    ASSERT_OK(vw_image_save(path, SIDE, SIDE, 4, &pixels[0][0][0]));
    struct vw_image *image = load(path, 4);
    assert_true(image->has_alpha);
    for (uint32_t x = 0; x < 8; x++) {
        float rgba[4];
        vw_image_pixel(image, x, 4, rgba);
        assert_near(rgba[0], 0, 1e-4);
        if (rgba[3] > 0.001f) assert_near(rgba[1], 1, 1e-3);
        if (x == 3) assert_near(rgba[3], 0.5, 0.05); // half covered
        if (x > 4) assert_near(rgba[3], 0, 0.06);
    }
}

FOLDER_TEST(downscale_ignores_masked_pixels) {
    float pixels[64 * 64][3];
    for (int i = 0; i < 64 * 64; i++) pixels[i][0] = pixels[i][1] = pixels[i][2] = 0.5f;
    pixels[64 * 32 + 33][1] = NAN;                                              // one of the 16 of its small pixel
    for (int i = 0; i < 16; i++) pixels[64 * (8 + i / 4) + 8 + i % 4][0] = NAN; // all 16 of another
    const struct tiff tiff = {64, 64, 3, 32, true, ALPHA_NONE, .pixels = pixels};
    struct vw_image *image = load(write_tiff(*state, "a.tif", &tiff), 4);
    assert_int_equal(image->format, VW_PIXEL_FLOAT32);
    assert_int_equal(image->masked_count, 17);
    float grey = (float)srgb(0.5);
    for (uint32_t i = 0; i < 16 * 16; i++) {
        bool masked = i % 16 == 2 && i / 16 == 2;
        assert_int_equal(image->unusable[i], masked);
        check_pixel(image, i % 16, i / 16, masked ? (const float[]){0, 0, 0, 0} : (const float[]){grey, grey, grey, 1},
                    1e-5);
    }
}

// ---- Errors ---------------------------------------------------------------------------------------------------------

static void check_refused(const char *path, enum vw_status expected, const char *said) {
    struct vw_image image = {0};
    ASSERT_FAILS(vw_image_load(path, 1, &image), expected, path, said);
    assert_null(image.pixels);
}

FOLDER_TEST(unreadable_images_are_refused) {
    check_refused(temporary_path(*state, "none.png"), VW_ERROR_INPUT, "no such image");
    check_refused(temporary_file(*state, "text.png", "not an image"), VW_ERROR_INPUT, "cannot open");
    check_refused(temporary_file(*state, "empty.jpg", ""), VW_ERROR_INPUT, "cannot open");
    const uint8_t pixel[3] = {0};
    const struct tiff huge = {1u << 15, 1u << 14, 3, 8, false, ALPHA_NONE, .pixels = pixel}; // 2^29 pixels
    struct tiff small = huge;
    small.width_px = small.height_px = 1;
    const char *path = write_tiff(*state, "huge.tif", &small);
    int file = open(path, O_WRONLY);
    const uint32_t size[2] = {huge.width_px, huge.height_px};
    assert_int_equal(pwrite(file, &size[0], 4, 8 + 2 + 8), 4); // the values of the first two fields
    assert_int_equal(pwrite(file, &size[1], 4, 8 + 2 + 12 + 8), 4);
    close(file);
    check_refused(path, VW_ERROR_INPUT, "limit of 268435456");
}

// A small file that asks for 30 GB.
FOLDER_TEST(an_image_bomb_is_refused) {
    static const uint8_t png[] = {
        0x89, 'P', 'N', 'G',  '\r', '\n', 0x1a, '\n', 0,    0, 0,    13,   'I',  'H',  'D', 'R',  0,    1,    0x86,
        0xa0, 0,   1,   0x86, 0xa0, 8,    2,    0,    0,    0, 0x27, 0x30, 0x9c, 0x9f, 0,   0,    0,    12,   'I',
        'D',  'A', 'T', 0x78, 0x9c, 0x63, 0x60, 0xa0, 0x3d, 0, 0,    0,    0x64, 0,    1,   0x86, 0x64, 0x3c, 0x35};
    const char *path = temporary_path(*state, "bomb.png");
    ASSERT_OK(vw_file_write(path, png, sizeof png));
    check_refused(path, VW_ERROR_INPUT, "100000 x 100000");
}

// Not of a PNG: OpenImageIO itself leaks a string when one ends early.
FOLDER_TEST(truncated_pixels_are_refused) {
    static float pixels[64 * 64 * 3];
    for (size_t i = 0; i < VW_ARRAY_COUNT(pixels); i++) pixels[i] = (float)(i * i * 7919 % 251) / 255;
    const char *path = temporary_path(*state, "cut.jpg");
    ASSERT_OK(vw_image_save(path, 64, 64, 3, pixels));
    size_t size_bytes;
    AUTO_FREE void *whole = temporary_read(path, &size_bytes);
    ASSERT_OK(vw_file_write(path, whole, size_bytes / 2));
    check_refused(path, VW_ERROR_IO, "cannot decode");
    const struct tiff tiff = {64, 64, 3, 8, false, ALPHA_NONE, .pixels = pixels};
    path = write_tiff(*state, "cut.tif", &tiff);
    assert_int_equal(truncate(path, 4000), 0);
    check_refused(path, VW_ERROR_IO, "cannot decode");
}

FOLDER_TEST(an_image_that_cannot_be_saved_is_refused) {
    const float pixel[3] = {0};
    ASSERT_FAILS(vw_image_save(temporary_path(*state, "a.unknown"), 1, 1, 3, pixel), VW_ERROR_USAGE, "a.unknown");
    assert_int_equal(vw_image_save(temporary_path(*state, "no/folder/a.png"), 1, 1, 3, pixel), VW_ERROR_IO);
}

TEST_GROUP(tiny_decoder_hold, NULL)
