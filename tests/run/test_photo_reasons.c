// Reasons of photos: which of synthetic photos are called blurred, noisy, wrongly posed or occluded, and that sound and
// dark ones are not.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "run/outputs/photo_reasons.h"
#include "support/draws.h"

enum { PHOTOS = 12, WIDTH_PX = 64, HEIGHT_PX = 48, BLURRED = 2, NOISY = 5, DARK = 7, PLAIN = 9 };

// ---- Pixels --------------------------------------------------------------------------------------------------------

// Returns waves of some pixels' length, a little other in every photo.
static double wave(uint32_t photo, double x_px, double y_px) {
    return 0.5 + 0.4 * sin(x_px * (1.1 + 0.02 * photo)) * sin(y_px * (0.9 + 0.01 * photo) + photo);
}

static double value_of(uint32_t photo, uint32_t x_px, uint32_t y_px) {
    double value = wave(photo, x_px, y_px), mean = 0.5;
    if (photo == PLAIN) return 0.5;
    if (photo == DARK) return 0.3 * value;
    if (photo == BLURRED) return mean + 0.1 * (wave(photo, x_px / 5.0, y_px / 5.0) - mean);
    return value + (photo == NOISY ? 0.15 * test_normal(photo, x_px, y_px) : 0);
}

static struct vw_luminance measure(uint32_t photo) {
    static const float black[3];
    AUTO_FREE uint8_t *pixels = vw_allocate(WIDTH_PX * HEIGHT_PX, 4);
    for (uint32_t i = 0; i < WIDTH_PX * HEIGHT_PX * 4; i++) {
        double value = value_of(photo, i / 4 % WIDTH_PX, i / 4 / WIDTH_PX);
        pixels[i] = i % 4 == 3 ? 255 : (uint8_t)lrint(255 * fmin(fmax(value, 0), 1));
    }
    const struct vw_image image = {
        .width_px = WIDTH_PX, .height_px = HEIGHT_PX, .format = VW_PIXEL_UINT8, .pixels = pixels};
    struct vw_luminance measured;
    ASSERT_OK(vw_image_measure_luminance(&image, black, &measured));
    return measured;
}

TEST(blur_and_noise_stand_out) {
    struct vw_luminance measured[PHOTOS];
    const char *reasons[PHOTOS] = {NULL};
    for (uint32_t i = 0; i < PHOTOS; i++) measured[i] = measure(i);
    ASSERT_OK(vw_photo_reasons_of_luminance(measured, PHOTOS, reasons));
    for (uint32_t i = 0; i < PHOTOS; i++) {
        if (i == BLURRED) assert_string_equal(reasons[i], "blur");
        else if (i == NOISY) assert_string_equal(reasons[i], "noise");
        else assert_null(reasons[i]);
    }
}

// Among photos of many kinds, one that has a third of the median sharpness is not called blurred.
TEST(nothing_stands_out_among_photos_of_many_kinds) {
    struct vw_luminance measured[PHOTOS];
    const char *reasons[PHOTOS] = {NULL};
    for (uint32_t i = 0; i < PHOTOS; i++)
        measured[i] = (struct vw_luminance){.contrast = 1, .sharpness = exp(0.5 * i), .noise = exp(0.25 * i)};
    ASSERT_OK(vw_photo_reasons_of_luminance(measured, PHOTOS, reasons));
    for (uint32_t i = 0; i < PHOTOS; i++) assert_null(reasons[i]);
}

// ---- Renders -------------------------------------------------------------------------------------------------------

// Makes a photo that the render shows moved to the right, but for small errors everywhere.
static struct vw_panes make_panes(double moved_px) {
    struct vw_panes panes = {.size_px = {WIDTH_PX, HEIGHT_PX}};
    panes.photo = vw_allocate(WIDTH_PX * HEIGHT_PX, 3 * sizeof *panes.photo);
    panes.render = vw_allocate(WIDTH_PX * HEIGHT_PX, 3 * sizeof *panes.render);
    panes.counts = vw_allocate(WIDTH_PX * HEIGHT_PX, 1);
    for (uint32_t i = 0; i < WIDTH_PX * HEIGHT_PX; i++) {
        double x = i % WIDTH_PX / 3.0, y = i / WIDTH_PX / 3.0;
        for (uint32_t c = 0; c < 3; c++) {
            panes.photo[3 * i + c] = (float)(wave(c, x, y) + 0.03 * test_draw(c, i, 0));
            panes.render[3 * i + c] = (float)wave(c, x - moved_px / 3, y);
        }
        panes.counts[i] = 1;
    }
    return panes;
}

static void cover(struct vw_panes *panes, uint32_t left_px, uint32_t side_px, bool masked) {
    for (uint32_t i = 0; i < WIDTH_PX * HEIGHT_PX; i++) {
        uint32_t x = i % WIDTH_PX, y = i / WIDTH_PX;
        if (x < left_px || x >= left_px + side_px || y < 10 || y >= 10 + side_px) continue;
        for (uint32_t c = 0; c < 3; c++) panes->photo[3 * i + c] = c == 0;
        panes->counts[i] = !masked;
    }
}

static const char *reason_of(const struct vw_panes *panes) {
    const char *reason = "noise";
    ASSERT_OK(vw_photo_reason_of_panes(panes, &reason));
    return reason;
}

TEST(renders_tell_pose_and_occluder) {
    AUTO(vw_panes_free) struct vw_panes sound = make_panes(0), moved = make_panes(4);
    assert_string_equal(reason_of(&sound), "noise"); // as it was
    assert_string_equal(reason_of(&moved), "pose");
    cover(&sound, 20, 15, false); // too small
    assert_string_equal(reason_of(&sound), "noise");
    vw_panes_free(&sound);

    sound = make_panes(0);
    cover(&sound, 5, 30, false);
    assert_string_equal(reason_of(&sound), "occluder");
    for (uint32_t i = 0; i < WIDTH_PX * HEIGHT_PX; i++) // stripes, of which every other one looks as the photo does
        if (i % WIDTH_PX % 6 < 3) memcpy(sound.photo + 3 * i, sound.render + 3 * i, 3 * sizeof *sound.photo);
    assert_string_equal(reason_of(&sound), "occluder");
    cover(&sound, 5, 30, true);
    assert_string_equal(reason_of(&sound), "noise");
    vw_panes_free(&sound);

    sound = make_panes(0); // two regions of equal error
    cover(&sound, 2, 25, false);
    cover(&sound, 37, 25, false);
    assert_string_equal(reason_of(&sound), "noise");
    vw_panes_free(&moved);
}
