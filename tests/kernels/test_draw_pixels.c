// draw_pixels against what the host draws (train/pixels.c), bit for bit: photos of every format, with and without
// masks.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "gpu/shaders.h"
#include "image/pixel.h"
#include "support/draws.h"
#include "support/gpu_fixture.h"
#include "support/synthetic_scene.h"
#include "train/device_photos.h"

// Sides that no tile divides; a photo has more channels than 16 bits have values.
enum { WIDTH = 150, HEIGHT = 131, PIXELS = WIDTH * HEIGHT, SIDE = 16, VIEWS = 4, MASKED = 2, RAYS = 700 };

static const enum vw_pixel_format formats[VIEWS] = {VW_PIXEL_UINT8, VW_PIXEL_UINT16, VW_PIXEL_FLOAT32, VW_PIXEL_UINT8};

// Gives a photo a format, and every value of it.
static void paint(struct vw_image *image, enum vw_pixel_format format) {
    free(image->pixels);
    image->format = format;
    image->pixels = vw_allocate(4 * (size_t)PIXELS, vw_pixel_channel_bytes(format));
    assert_non_null(image->pixels);
    for (uint32_t i = 0; i < 4 * PIXELS; i++)
        if (format == VW_PIXEL_UINT8) ((uint8_t *)image->pixels)[i] = (uint8_t)i;
        else if (format == VW_PIXEL_UINT16) ((uint16_t *)image->pixels)[i] = (uint16_t)i;
        else ((float *)image->pixels)[i] = (float)(0.5 + 0.5 * test_draw(5, i, 0));
}

static void leave_out(struct vw_view *view) {
    view->mask = vw_allocate(PIXELS, 1);
    view->image.unusable = vw_allocate(PIXELS, 1);
    assert_true(view->mask && view->image.unusable);
    for (uint32_t i = 0; i < PIXELS; i++) {
        view->mask[i] = i % 5 == 0 ? VW_MASK_HIDE : i % 7 == 0 ? VW_MASK_BEYOND_LENS : VW_MASK_KEEP;
        view->image.unusable[i] = i % 11 == 0;
    }
}

static struct vw_scene *make_scene(void) {
    struct vw_scene *scene =
        synthetic_scene(&(struct synthetic_scene_params){VIEWS - 1, 1, .width_px = WIDTH, .height_px = HEIGHT});
    for (uint32_t v = 0; v < VIEWS; v++) paint(&scene->views[v].image, formats[v]);
    leave_out(&scene->views[0]);
    leave_out(&scene->views[MASKED]);
    return scene;
}

struct drawing {
    struct vw_scene *scene;
    struct vw_device_photos *photos;
    struct vw_buffer *pixels, *tiles;
    struct vw_pass *anywhere, *in_tiles;
};

static void destroy_photos(void *photos) { vw_device_photos_destroy(&(struct vw_device_photos *){photos}); }

static struct vw_pass *make_pass(const struct drawing *d, const struct vw_shader *shader) {
    const struct vw_binding bindings[] = {{.slot = VW_SLOT_PHOTOS, .buffer = d->photos->buffer},
                                          {.slot = VW_SLOT_PIXELS, .buffer = d->pixels},
                                          {.slot = VW_SLOT_SPLAT_TILES, .buffer = d->tiles}};
    return test_pass(
        test_gpu(),
        (struct vw_pass_params){.shader = shader, .bindings = bindings, .binding_count = VW_ARRAY_COUNT(bindings)});
}

static struct drawing open_drawing(void) {
    static const uint32_t all[VIEWS] = {0, 1, 2, 3};
    struct drawing d = {.scene = make_scene()};
    ASSERT_OK(vw_device_photos_create(test_gpu(), d.scene, &d.photos));
    test_own(d.photos, destroy_photos);
    ASSERT_OK(vw_device_photos_keep(d.photos, all + 1, 1));
    ASSERT_OK(vw_device_photos_keep(d.photos, all, VIEWS));
    d.pixels = test_buffer(test_gpu(), "pixels", 2 * PIXELS * sizeof(struct vw_pixel));
    d.tiles = test_buffer(test_gpu(), "tiles", PIXELS / SIDE * sizeof(struct vw_splat_tile));
    d.anywhere = make_pass(&d, &vw_shader_draw_pixels);
    d.in_tiles = make_pass(&d, &vw_shader_draw_pixels_tiles);
    return d;
}

static void assert_draws(const struct drawing *d, const struct vw_pass *pass, const struct vw_push_draw *push,
                         const struct vw_pixel *expected) {
    struct vw_submission *submission = test_submission(test_gpu());
    struct vw_pixel *drawn = test_allocate(push->count, sizeof *drawn);
    vw_submission_begin(submission);
    vw_submission_dispatch(submission, pass, push, sizeof *push, push->count);
    test_submit(submission);
    ASSERT_OK(vw_buffer_read(d->pixels, push->first_pixel * sizeof *drawn, drawn, push->count * sizeof *drawn));
    for (uint32_t i = 0; i < push->count; i++) {
        if (!memcmp(&drawn[i], &expected[i], sizeof *drawn)) continue;
        fail_msg("view %u, pixel %u: at %g %g, weight %g, %.9g; the host's is at %g %g, weight %g, %.9g", push->view, i,
                 drawn[i].x_px, drawn[i].y_px, drawn[i].weight, drawn[i].rgba.x, expected[i].x_px, expected[i].y_px,
                 expected[i].weight, expected[i].rgba.x);
    }
}

TEST(pixels_are_those_that_the_host_draws) {
    static const uint32_t sides[] = {0, 7, 26};
    struct drawing d = open_drawing();
    struct vw_pixel expected[RAYS];
    for (uint32_t i = 0; i < 24; i++) {
        uint32_t view = i % VIEWS;
        const struct vw_pixel_draw draw = {UINT64_C(0x123456789) + i, (UINT64_C(5) << 32) + i, i / 8, sides[i % 3],
                                           i % 5 < 3};
        const struct vw_push_draw push = vw_device_photos_push(d.photos, view, &draw, 3 * i, RAYS);
        vw_pixels_draw(d.scene, view, &draw, RAYS, expected);
        assert_draws(&d, d.anywhere, &push, expected);
    }
}

// All tiles of a photo, the last ones partly beyond it, and one that is not listed.
TEST_CASES(tiles_are_those_that_the_host_takes, view, VIEWS) {
    struct drawing d = open_drawing();
    uint32_t columns = (WIDTH + SIDE - 1) / SIDE, rows = (HEIGHT + SIDE - 1) / SIDE, count = columns * rows;
    struct vw_splat_tile *tiles = test_allocate(count, sizeof *tiles);
    struct vw_pixel *expected = test_allocate((count + 1) * SIDE * SIDE, sizeof *expected);
    for (uint32_t masks = 0; masks < 2; masks++) {
        const struct vw_pixel_draw draw = {.masks = masks};
        struct vw_push_draw push =
            vw_device_photos_push(d.photos, (uint32_t)view, &draw, 64, (count + 1) * SIDE * SIDE);
        push.side = SIDE;
        push.first_tile = 2;
        push.listed = count * SIDE * SIDE;
        for (uint32_t i = 0; i < count; i++) {
            tiles[i].corner = i / columns << 16 | i % columns;
            const struct vw_photo_tile tile = {i % columns * SIDE, i / columns * SIDE};
            vw_pixels_take_tile(d.scene, (uint32_t)view, masks, tile, SIDE, expected + i * SIDE * SIDE);
        }
        for (uint32_t i = push.listed; i < push.count; i++) expected[i] = (struct vw_pixel){.view = (uint32_t)view};
        ASSERT_OK(vw_buffer_write(d.tiles, 2 * sizeof *tiles, tiles, count * sizeof *tiles));
        assert_draws(&d, d.in_tiles, &push, expected);
    }
}

// The host draws then.
TEST(photos_that_do_not_fit_are_refused) {
    struct vw_scene *scene = make_scene();
    struct vw_device_photos *photos = NULL;
    struct vw_gpu_limits clamp = *vw_gpu_get_limits(test_gpu());
    clamp.storage_binding_bytes = 4 * PIXELS;
    struct vw_gpu *gpu = test_gpu_open((struct vw_gpu_params){.validation = true, .clamp = &clamp});
    assert_int_equal(vw_device_photos_create(gpu, scene, &photos), VW_ERROR_DEVICE);
    assert_non_null(strstr(vw_error_message(), "MiB"));
    scene->views[1].camera.width_px = 70000;
    assert_int_equal(vw_device_photos_create(test_gpu(), scene, &photos), VW_ERROR_DEVICE);
    assert_non_null(strstr(vw_error_message(), "too large"));
    assert_null(photos);
}

TEST_GROUP(NULL, test_gpu_close)
