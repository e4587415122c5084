// The pixels of a step: anywhere in the photo, or the first of them as a picture of it, one in each cell of a grid.
// label: host
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "support/synthetic_scene.h"
#include "train/pixels.h"

enum { RAYS = 50, SIDE = 7 };

static struct vw_scene *make_scene(uint32_t width_px, uint32_t height_px) {
    return synthetic_scene(&(struct synthetic_scene_params){
        .train_views = 2, .val_views = 1, .width_px = width_px, .height_px = height_px});
}

// The pixel of each cell lies in it, where the cell holds any pixel.
TEST(a_picture_has_a_pixel_in_each_cell) {
    static const uint32_t sizes_px[][2] = {{24, 20}, {7, 7}, {5, 3}, {1, 1}};
    for (size_t i = 0; i < sizeof sizes_px / sizeof *sizes_px; i++) {
        uint32_t width_px = sizes_px[i][0], height_px = sizes_px[i][1];
        struct vw_scene *scene = make_scene(width_px, height_px);
        struct vw_pixel pixels[RAYS];
        vw_pixels_draw(scene, 1, &(struct vw_pixel_draw){7, 3, 0, SIDE}, RAYS, pixels);
        for (uint32_t ray = 0; ray < RAYS; ray++) {
            assert_int_equal(pixels[ray].view, 1);
            assert_true(pixels[ray].x_px > 0.0f && pixels[ray].x_px < (float)width_px);
            assert_true(pixels[ray].y_px > 0.0f && pixels[ray].y_px < (float)height_px);
            if (ray >= SIDE * SIDE) continue;
            double cell_x = (double)(ray % SIDE) * width_px / SIDE, cell_y = (double)(ray / SIDE) * height_px / SIDE;
            assert_true(floor(pixels[ray].x_px) >= floor(cell_x) && floor(pixels[ray].y_px) >= floor(cell_y));
            assert_true(floor(pixels[ray].x_px) <
                        fmax(floor(cell_x + (double)width_px / SIDE + 1e-9), floor(cell_x) + 1));
            assert_true(floor(pixels[ray].y_px) <
                        fmax(floor(cell_y + (double)height_px / SIDE + 1e-9), floor(cell_y) + 1));
        }
    }
}

// Pixels beside the picture are the same as without one; draws, steps and seeds differ.
TEST(draws_are_functions_of_their_numbers) {
    struct vw_scene *scene = make_scene(240, 200);
    static const struct vw_pixel_draw draws[] = {{7, 3, 0, SIDE}, {7, 3, 1, SIDE}, {7, 4, 0, SIDE}, {8, 3, 0, SIDE}};
    struct vw_pixel first[RAYS], other[RAYS];
    vw_pixels_draw(scene, 0, &draws[0], RAYS, first);
    for (size_t i = 0; i < sizeof draws / sizeof *draws; i++) {
        vw_pixels_draw(scene, 0, &draws[i], RAYS, other);
        assert_int_equal(memcmp(first, other, sizeof first) == 0, i == 0);
    }
    vw_pixels_draw(scene, 0, &(struct vw_pixel_draw){7, 3, 0, 0}, RAYS, other);
    assert_memory_equal(first + SIDE * SIDE, other + SIDE * SIDE, sizeof first - SIDE * SIDE * sizeof *first);
    assert_memory_not_equal(first, other, SIDE * SIDE * sizeof *first);
}

// A mask changes the order of the pixels, not which they are.
TEST(pixels_with_weight_come_first) {
    enum { WIDTH = 24, HEIGHT = 20 };
    struct vw_scene *scene = make_scene(WIDTH, HEIGHT);
    struct vw_pixel_draw draw = {7, 3, 0, 0, true};
    struct vw_pixel plain[RAYS], masked[RAYS];
    assert_int_equal(vw_pixels_draw(scene, 0, &draw, RAYS, plain), RAYS);
    scene->views[0].mask = vw_allocate(WIDTH * HEIGHT, 1);
    assert_non_null(scene->views[0].mask);
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++)
        scene->views[0].mask[i] = i % WIDTH < WIDTH / 2 ? VW_MASK_HIDE : VW_MASK_KEEP;
    scene->masked_view_count = 1;
    uint32_t counted = vw_pixels_draw(scene, 0, &draw, RAYS, masked), first = 0, last = RAYS;
    assert_in_range(counted, 1, RAYS - 1);
    for (uint32_t i = 0; i < RAYS; i++) {
        bool hidden = plain[i].x_px < WIDTH / 2;
        struct vw_pixel *found = &masked[hidden ? --last : first++];
        plain[i].weight = hidden ? 0.0f : 1.0f;
        assert_memory_equal(found, &plain[i], sizeof *found);
    }
    assert_int_equal(first, counted);
    draw.picture_side = SIDE;
    assert_int_equal(vw_pixels_draw(scene, 0, &draw, RAYS, masked), RAYS);
    draw = (struct vw_pixel_draw){7, 3, 0, 0, false};
    assert_int_equal(vw_pixels_draw(scene, 0, &draw, RAYS, masked), RAYS);
}

// Squares show the corner of a photo that a mask keeps, wherever their stratum does.
TEST(squares_are_chosen_where_a_mask_keeps_something) {
    enum { WIDTH = 240, HEIGHT = 160, SQUARE = 8, COUNT = 6 * SQUARE * SQUARE, KEPT = 8 };
    struct vw_scene *scene = make_scene(WIDTH, HEIGHT);
    struct vw_view *view = &scene->views[0];
    struct vw_pixel_columns all = vw_pixels_all_columns(scene, 0);
    struct vw_pixel pixels[COUNT];
    view->mask = vw_allocate(WIDTH * HEIGHT, 1);
    assert_non_null(view->mask);
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++)
        view->mask[i] = i % WIDTH < KEPT && i / WIDTH < KEPT ? VW_MASK_KEEP : VW_MASK_HIDE;
    for (uint64_t seed = 0; seed < 20; seed++) {
        bool masks = seed % 2 == 0; // the others do not look at it, and choose another square
        uint32_t kept = 0, count = vw_pixels_stratify_squares(scene, 0, all, seed, masks, SQUARE, COUNT, pixels);
        assert_int_equal(count, COUNT);
        for (uint32_t i = 0; i < count; i++) {
            bool keeps = vw_view_keeps(view, (uint32_t)pixels[i].x_px, (uint32_t)pixels[i].y_px);
            assert_true(pixels[i].weight == (keeps || !masks ? 1.0f : 0.0f));
            kept += keeps;
        }
        assert_int_equal(kept, masks ? SQUARE * SQUARE : 0); // one stratum of six shows it, in one square of 100
    }
}
