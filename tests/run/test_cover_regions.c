// Regions that cover a photo, in panes of a wall whose depths and errors are made up here: found where nearby panes
// show the wall, and not where they share the error, do not see the place, or are too few.
#include "support/cmocka_test.h"

#include <string.h>

#include "base/memory.h"
#include "run/outputs/cover_regions.h"

enum { PANES = 7, WIDTH_PX = 48, HEIGHT_PX = 36, PIXELS = WIDTH_PX * HEIGHT_PX, COVERED = 3 };
static const double FAR_WORLD = 4, APART_WORLD = 0.2, SOUND = 0.02, LARGE = 0.4;

// Columns and rows, ends left out.
struct block {
    uint32_t left, right, top, bottom;
};
static const struct block block = {18, 30, 8, 24};

static struct world {
    struct vw_view views[PANES];
    struct vw_cover_pane list[PANES];
    float errors[PANES][PIXELS], depths[PANES][PIXELS];
    bool covered[PIXELS];
} world;

static bool is_within(const struct block *of, uint32_t x, uint32_t y) {
    return x >= of->left && x < of->right && y >= of->top && y < of->bottom;
}

static void set_block(float *values, double value) {
    for (uint32_t i = 0; i < PIXELS; i++)
        if (is_within(&block, i % WIDTH_PX, i / WIDTH_PX)) values[i] = (float)value;
}

// Turns axes and position of a camera about y and z: the world is not along its axes.
static void turn(double pose[3][4]) {
    double c = cos(0.7), s = sin(0.7), d = cos(0.4), t = sin(0.4);
    for (int column = 0; column < 4; column++) {
        double x = c * pose[0][column] + s * pose[2][column], z = c * pose[2][column] - s * pose[0][column];
        double y = pose[1][column];
        pose[0][column] = d * x - t * y, pose[1][column] = t * x + d * y, pose[2][column] = z;
    }
}

// Places cameras side by side that look at a wall. A step to the side moves the wall by 2 pixels.
static struct vw_cover_panes make_panes(void) {
    struct vw_cover_panes panes = {
        .list = world.list, .count = PANES, .scales = {.between_world = 1, .angle = 1, .copy_world = 0, .typical = 1}};
    for (uint32_t v = 0; v < PANES; v++) {
        double pose[3][4] = {{1, 0, 0, APART_WORLD * ((int)v - COVERED)}, {0, 1, 0, 0}, {0, 0, 1, FAR_WORLD}};
        const struct vw_camera camera = {.width_px = WIDTH_PX,
                                         .height_px = HEIGHT_PX,
                                         .focal_x_px = 40,
                                         .focal_y_px = 40,
                                         .centre_x_px = WIDTH_PX / 2,
                                         .centre_y_px = HEIGHT_PX / 2};
        turn(pose);
        memcpy(world.views[v].camera_to_world, pose, sizeof pose);
        world.views[v].camera = camera;
        for (uint32_t i = 0; i < PIXELS; i++) world.errors[v][i] = (float)SOUND, world.depths[v][i] = (float)FAR_WORLD;
        world.list[v] = (struct vw_cover_pane){.view = &world.views[v],
                                               .camera = camera,
                                               .tells = true,
                                               .errors = world.errors[v],
                                               .depths = world.depths[v]};
    }
    set_block(world.errors[COVERED], LARGE);
    return panes;
}

static double find(struct vw_cover_panes *panes) {
    double share = -1;
    ASSERT_OK(vw_cover_settle(panes));
    ASSERT_OK(vw_cover_find(panes, COVERED, world.covered, &share));
    return share;
}

static double block_share(void) { return (double)(block.right - block.left) * (block.bottom - block.top) / PIXELS; }

TEST(what_one_photo_has_alone_is_covered) {
    struct vw_cover_panes panes = make_panes();
    assert_true(fabs(find(&panes) - block_share()) < 1e-12);
    for (uint32_t i = 0; i < PIXELS; i++)
        assert_int_equal(world.covered[i], is_within(&block, i % WIDTH_PX, i / WIDTH_PX));
}

TEST(half_of_the_error_around_it_belongs_to_it) {
    struct vw_cover_panes panes = make_panes();
    const uint32_t beside = block.top * WIDTH_PX + block.right, apart = beside + 4;
    world.errors[COVERED][beside] = world.errors[COVERED][apart] = 0.09F; // from 0.05, half of 0.1, and SOUND
    (void)find(&panes);
    assert_true(world.covered[beside]);
    assert_false(world.covered[apart]);
}

// The field shows something badly in all photos, whatever it is.
TEST(an_error_that_others_share_covers_nothing) {
    struct vw_cover_panes panes = make_panes();
    for (uint32_t v = 0; v < PANES; v++) {
        const int moved_px = 2 * ((int)v - COVERED);
        for (uint32_t i = 0; i < PIXELS; i++)
            if (is_within(&block, i % WIDTH_PX + (uint32_t)moved_px, i / WIDTH_PX)) world.errors[v][i] = (float)LARGE;
    }
    assert_true(find(&panes) == 0);
}

TEST(two_sound_photos_of_the_place_are_enough_and_needed) {
    for (uint32_t sound = 1; sound <= 2; sound++) {
        struct vw_cover_panes panes = make_panes();
        for (uint32_t v = sound; v < PANES; v++) set_block(world.errors[v], LARGE);
        for (uint32_t v = sound; v < PANES; v++)
            if (v != COVERED)
                for (uint32_t i = 0; i < PIXELS; i++) world.errors[v][i] = (float)LARGE;
        panes.seed_error = 0;
        double share = -1;
        ASSERT_OK(vw_cover_settle(&panes));
        panes.seed_error = 0.1; // most panes are bad here, which moves the median
        ASSERT_OK(vw_cover_find(&panes, COVERED, world.covered, &share));
        assert_true(sound == 2 ? share > 0.5 * block_share() : share == 0);
    }
}

TEST(photos_that_do_not_see_the_place_tell_nothing) {
    struct vw_cover_panes panes = make_panes();
    for (uint32_t v = 0; v < PANES; v++) panes.list[v].tells = false;
    assert_true(find(&panes) == 0);
    panes = make_panes();
    for (uint32_t v = 0; v < PANES; v++) // something stands before the wall, but not for this photo
        for (uint32_t i = 0; i < PIXELS && v != COVERED; i++) world.depths[v][i] = (float)(FAR_WORLD / 2);
    assert_true(find(&panes) == 0);
    panes = make_panes();
    for (uint32_t v = 0; v < PANES; v++) // they look away
        for (int row = 0; row < 3 && v != COVERED; row++)
            for (int i = 0; i < 3; i += 2) world.views[v].camera_to_world[row][i] *= -1;
    assert_true(find(&panes) == 0);
}

// All see through to nothing, as beside an object on a plain ground: something in front of it is found.
TEST(something_before_nothing_is_found) {
    struct vw_cover_panes panes = make_panes();
    memset(world.depths, 0, sizeof world.depths);
    assert_true(fabs(find(&panes) - block_share()) < 1e-12);
}

TEST(pixels_that_do_not_count_and_small_regions_are_left_out) {
    struct vw_cover_panes panes = make_panes();
    set_block(world.errors[COVERED], NAN);
    assert_true(find(&panes) == 0);
    panes = make_panes();
    set_block(world.errors[COVERED], SOUND);
    for (uint32_t i = 0; i < 4; i++)
        world.errors[COVERED][5 * WIDTH_PX + 5 + i] = (float)LARGE; // 8.6 are half a percent
    assert_true(find(&panes) == 0);
    for (uint32_t i = 0; i < 9; i++) world.errors[COVERED][5 * WIDTH_PX + 5 + i] = (float)LARGE;
    assert_true(find(&panes) > 0.005);
}

// In a scene that is shown badly everywhere only larger errors tell: four medians.
TEST(the_limit_follows_the_scene) {
    struct vw_cover_panes panes = make_panes();
    for (uint32_t v = 0; v < PANES; v++)
        for (uint32_t i = 0; i < PIXELS; i++) world.errors[v][i] = 0.11F;
    set_block(world.errors[COVERED], LARGE);
    assert_true(find(&panes) == 0);
    assert_true(fabs(panes.seed_error - 0.44) < 1e-6);
}

// Light differs, and a third of the photo is covered: the errors of the rest are nothing all the same.
TEST(a_gain_and_a_bias_are_fitted_without_what_covers) {
    static float photo[3 * PIXELS], render[3 * PIXELS];
    static uint8_t counts[PIXELS];
    struct vw_panes panes = {{WIDTH_PX, HEIGHT_PX}, photo, render, counts};
    struct vw_cover_pane pane = {0};
    for (uint32_t i = 0; i < PIXELS; i++) {
        bool covers = i % WIDTH_PX < WIDTH_PX / 3;
        for (uint32_t c = 0; c < 3; c++) {
            render[3 * i + c] = (float)(0.3 + 0.2 * sin(0.7 * i + c) + 0.1 * cos(0.013 * i));
            photo[3 * i + c] = covers ? 0.9F : 0.8F * render[3 * i + c] + 0.03F * (float)c;
        }
        counts[i] = i % 11 != 0;
    }
    ASSERT_OK(vw_cover_make_errors(&panes, &pane));
    for (uint32_t i = 0; i < PIXELS; i++) {
        uint32_t column = i % WIDTH_PX;
        if (!counts[i]) assert_true(isnan(pane.errors[i]));
        else if (column >= WIDTH_PX / 3 + 2) assert_true(pane.errors[i] < 1e-5); // floats
        else if (column < WIDTH_PX / 3 - 2) assert_true(pane.errors[i] > 0.3);
    }
    free(pane.errors);
}

// Most is white in both, but for grains of the render; the object before it is shown nearly. White alone tells
// another gain.
TEST(a_plain_ground_does_not_tell_the_gain) {
    static float photo[3 * PIXELS], render[3 * PIXELS];
    static uint8_t counts[PIXELS];
    struct vw_panes panes = {{WIDTH_PX, HEIGHT_PX}, photo, render, counts};
    struct vw_cover_pane pane = {0};
    for (uint32_t i = 0; i < 3 * PIXELS; i++) {
        bool is_object = is_within(&block, i / 3 % WIDTH_PX, i / 3 / WIDTH_PX);
        render[i] = (float)(is_object ? 0.4 + 0.2 * sin(0.7 * i) : 0.999 + 0.001 * sin(1.3 * i));
        photo[i] = is_object ? render[i] + 0.03F : 0.5F + render[i] / 2;
        counts[i / 3] = 1;
    }
    ASSERT_OK(vw_cover_make_errors(&panes, &pane));
    for (uint32_t i = 0; i < PIXELS; i++) assert_true(pane.errors[i] < 0.05);
    free(pane.errors);
}
