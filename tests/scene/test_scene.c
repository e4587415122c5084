// Opening a scene: the box, downscaling, transparency, the hash, and the real scenes.
#include <unistd.h>

#include "base/hash.h"
#include "base/memory.h"
#include "image/image.h"
#include "scene/builder.h"
#include "support/cmocka_test.h"
#include "support/synthetic_scene.h"
#include "support/temporary_folder.h"
#include "support/tiny_scene.h"

// ---- The box --------------------------------------------------------------------------------------------------------

static void check_box(const struct vw_box *box, double x, double y, double z, double half_extent, double tolerance) {
    assert_near(box->centre_world[0], x, tolerance);
    assert_near(box->centre_world[1], y, tolerance);
    assert_near(box->centre_world[2], z, tolerance);
    assert_near(box->half_extent_world, half_extent, tolerance);
}

FOLDER_TEST(boxes_follow_cameras_and_keys) {
    static const char axes[] = "closest to all optical axes", scaled[] = "\"camera_angle_x\": 0.7, \"aabb_scale\": 4,";
    const double half_extent = 1.1 * 4 * tan(0.35);
    const struct {
        struct tiny_scene tiny;
        const char *source;
        double x, y, z, half_extent, tolerance;
    } cases[] = {
        // Cameras that look inward have a box around their axes.
        {{0}, axes, 0, 0, 0, half_extent, 1e-12},
        {{.offset_world = {1e6, -2e6, 3e6}}, axes, 1e6, -2e6, 3e6, half_extent, 1e-8}, // doubles near 3e6 resolve 5e-10
        {{.scale_world = 1e6}, axes, 0, 0, 0, 1e6 * half_extent, 1e-6},
        // The box of instant-ngp is read: 0.5 * world + offset covers -0.5 ... 1.5.
        {{.keys = "\"fl_x\": 8, \"aabb_scale\": 4,"}, "aabb_scale 4", 0, 0, 0, 2 / 0.33, 1e-12},
        {{.keys = "\"fl_x\": 8, \"aabb_scale\": 2, \"scale\": 0.5, \"offset\": [0.25, 0.5, 1],"},
         "aabb_scale 2",
         0.5,
         0,
         -1,
         2,
         1e-12},
        // It is ignored in a scene of other coordinates.
        {{.keys = scaled, .offset_world = {1e6}}, axes, 1e6, 0, 0, half_extent, 1e-8},
        {{.keys = scaled, .scale_world = 1e3}, axes, 0, 0, 0, 1e3 * half_extent, 1e-8},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        tiny_scene_write(*state, &cases[i].tiny);
        const struct vw_scene *scene = tiny_scene_open(SCENE_PARAMS(.path = *state, .headers_only = true));
        if (!strstr(scene->box_source, cases[i].source)) fail_msg("case %zu: source '%s'", i, scene->box_source);
        check_box(&scene->box, cases[i].x, cases[i].y, cases[i].z, cases[i].half_extent, cases[i].tolerance);
    }
}

// Returns the box of four cameras on a square of side 2 that look along -z, or away from its centre if `outward`.
static struct vw_box box_of_square(const char *folder, bool outward) {
    tiny_scene_write(folder, &(struct tiny_scene){.count = 4});
    char *frames[4], *json;
    for (int i = 0; i < 4; i++) {
        int x = i % 2 ? 1 : -1, y = i / 2 ? 1 : -1;
        const double r = sqrt(0.5);
        const double away[3][3] = {{y * r, 0, -x * r}, {-x * r, 0, -y * r}, {0, 1, 0}};
        const double ahead[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
        const double(*m)[3] = outward ? away : ahead;
        frames[i] =
            vw_format_text("{\"file_path\": \"images/0%d.png\", \"transform_matrix\": [[%.17g,%.17g,%.17g,%d],"
                           "[%.17g,%.17g,%.17g,%d],[%.17g,%.17g,%.17g,0],[0,0,0,1]]}",
                           i, m[0][0], m[0][1], m[0][2], x, m[1][0], m[1][1], m[1][2], y, m[2][0], m[2][1], m[2][2]);
    }
    json = vw_format_text("{\"fl_x\": 8, \"frames\": [%s,%s,%s,%s]}", frames[0], frames[1], frames[2], frames[3]);
    temporary_file(folder, "transforms.json", json);
    for (int i = 0; i < 4; i++) free(frames[i]);
    free(json);
    struct vw_scene *scene = tiny_scene_open(SCENE_PARAMS(.path = folder, .headers_only = true));
    assert_non_null(strstr(scene->box_source, "no common point"));
    struct vw_box box = scene->box;
    return box;
}

FOLDER_TEST(axes_without_a_common_point_have_a_box) {
    double depth = 4 * sqrt(2);
    struct vw_box box = box_of_square(*state, false);
    check_box(&box, 0, 0, -depth, 1.1 * depth, 1e-12);
    box = box_of_square(*state, true);
    check_box(&box, 0, 0, 0, 1.1 * depth, 1e-12);
}

// ---- Photos ---------------------------------------------------------------------------------------------------------

FOLDER_TEST(a_downscale_fits_the_camera) {
    tiny_scene_write(*state, &(struct tiny_scene){.keys = "\"fl_x\": 12, \"fl_y\": 9, \"cx\": 5, \"cy\": 2,"});
    for (int headers_only = 0; headers_only < 2; headers_only++) {
        struct vw_scene *scene =
            tiny_scene_open(SCENE_PARAMS(.path = *state, .downscale = 3, .headers_only = headers_only));
        const struct vw_camera *camera = &scene->views[0].camera;
        assert_int_equal(camera->width_px, 2); // floor(8 / 3)
        assert_int_equal(camera->height_px, 2);
        assert_near(camera->focal_x_px, 12 * 2.0 / 8, 1e-12);
        assert_near(camera->focal_y_px, 9 * 2.0 / 6, 1e-12);
        assert_near(camera->centre_x_px, 5 * 2.0 / 8, 1e-12);
        assert_near(camera->centre_y_px, 2 * 2.0 / 6, 1e-12);
        assert_int_equal(scene->views[0].image.width_px, headers_only ? 0 : 2);
    }
}

FOLDER_TEST(the_background_follows_alpha) {
    tiny_scene_write(*state, &(struct tiny_scene){.count = 3});
    struct vw_scene *scene = tiny_scene_open(SCENE_PARAMS(.path = *state));
    assert_false(scene->has_alpha);
    assert_true(scene->background[0] == 0 && scene->background[1] == 0 && scene->background[2] == 0);
    float pixels[TINY_WIDTH_PX * TINY_HEIGHT_PX * 4] = {0}; // all transparent
    ASSERT_OK(vw_image_save(temporary_path(*state, "images/01.png"), TINY_WIDTH_PX, TINY_HEIGHT_PX, 4, pixels));
    scene = tiny_scene_open(SCENE_PARAMS(.path = *state));
    assert_true(scene->has_alpha);
    assert_true(scene->background[0] == 1 && scene->background[1] == 1 && scene->background[2] == 1);
}

FOLDER_TEST(excluded_views_are_not_decoded) {
    tiny_scene_write(*state, &(struct tiny_scene){.count = 4});
    const char *train = temporary_file(*state, "train.txt", "images/01.png\nimages/02.png\n");
    struct vw_scene *scene = tiny_scene_open(SCENE_PARAMS(.path = *state, .train_list = train));
    assert_int_equal(scene->views[3].split, VW_SPLIT_EXCLUDED);
    ASSERT_OK(vw_scene_decode_all(scene));
    assert_null(scene->views[3].image.pixels);
    assert_non_null(scene->views[2].image.pixels);
    const uint8_t zero[VW_HASH_BYTES] = {0};
    assert_memory_not_equal(scene->views[3].sha256, zero, VW_HASH_BYTES); // but they are in the ledger
}

// ---- The hash -------------------------------------------------------------------------------------------------------

FOLDER_TEST(the_hash_names_all_that_is_read) {
    struct vw_scene_params params = {.path = *state};
    tiny_scene_write(*state, &(struct tiny_scene){0});
    const uint8_t *first = tiny_scene_open(&params)->hash;
#define ASSERT_SAME_HASH(params) assert_memory_equal(tiny_scene_open(params)->hash, first, VW_HASH_BYTES)
#define ASSERT_OTHER_HASH(params) assert_memory_not_equal(tiny_scene_open(params)->hash, first, VW_HASH_BYTES)

    AUTO_FOLDER char *elsewhere = temporary_folder_create(); // the folder does not matter
    tiny_scene_write(elsewhere, &(struct tiny_scene){0});
    ASSERT_SAME_HASH(SCENE_PARAMS(.path = elsewhere));
    ASSERT_SAME_HASH(SCENE_PARAMS(.path = *state, .downscale = 1)); // the default, spelled out
    ASSERT_OTHER_HASH(SCENE_PARAMS(.path = *state, .downscale = 2));
    const char *val = temporary_file(*state, "val.txt", "images/01.png\n"); // a split
    ASSERT_OTHER_HASH(SCENE_PARAMS(.path = *state, .val_list = val));
    static const struct tiny_scene others[] = {{.keys = "\"camera_angle_x\": 0.7, \"k1\": 1e-12,"},
                                               {.keys = "\"camera_angle_x\": 0.7, \"k3\": 1e-12,"},
                                               {.keys = "\"camera_angle_x\": 0.7, \"is_fisheye\": true,"},
                                               {.offset_world = {1e-12}}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(others); i++) {
        tiny_scene_write(*state, &others[i]);
        ASSERT_OTHER_HASH(&params);
    }
    tiny_scene_write(*state, &(struct tiny_scene){0});
    ASSERT_SAME_HASH(&params);
    tiny_photo_write(temporary_path(*state, "images/06.png"), 7); // pixels
    ASSERT_OTHER_HASH(&params);
}

FOLDER_TEST(headers_only_reads_no_pixels) {
    tiny_scene_write(*state, &(struct tiny_scene){0});
    struct vw_scene *scene = NULL;
    ASSERT_OK(vw_scene_open(SCENE_PARAMS(.path = *state, .headers_only = true), &scene));
    const uint8_t zero[VW_HASH_BYTES] = {0};
    assert_memory_equal(scene->hash, zero, VW_HASH_BYTES);
    assert_memory_equal(scene->views[0].sha256, zero, VW_HASH_BYTES);
    assert_null(scene->views[0].image.pixels);
    assert_int_equal(scene->split_count[VW_SPLIT_VAL], 1);
    vw_scene_close(&scene);
    assert_null(scene);
    vw_scene_close(&scene); // closing twice is fine
}

FOLDER_TEST(a_clamped_share_is_noted) {
    tiny_scene_write(*state, &(struct tiny_scene){.count = 3, .name_suffix = ".exr"});
    for (int i = 0; i < 3; i++) {
        float pixels[TINY_WIDTH_PX * TINY_HEIGHT_PX * 3] = {0};
        char name[32];
        if (i == 1) pixels[0] = pixels[1] = 2;
        snprintf(name, sizeof name, "images/0%d.exr", i);
        ASSERT_OK(vw_image_save(temporary_path(*state, name), TINY_WIDTH_PX, TINY_HEIGHT_PX, 3, pixels));
    }
    struct vw_scene *scene = tiny_scene_open(SCENE_PARAMS(.path = *state));
    assert_int_equal(scene->note_count, 1);
    check_note(scene, "1 photo: 0.35 %"); // 2 of 3 * 48 pixels * 4 channels
}

// ---- Real scenes ----------------------------------------------------------------------------------------------------

TEST(fox_is_read) {
    const char *path = real_scene_path("fox");
    if (!path) skip();
    struct vw_scene *scene = tiny_scene_open(SCENE_PARAMS(.path = path));
    assert_int_equal(scene->view_count, 50);
    assert_int_equal(scene->split_count[VW_SPLIT_VAL], 7);
    assert_int_equal(scene->split_count[VW_SPLIT_TEST], 6);
    assert_string_equal(scene->views[0].name, "images/0001.jpg");
    assert_int_equal(scene->views[49].image.height_px, 480);
    assert_near(scene->box.half_extent_world, 2 / 0.33, 1e-12);
    assert_near(scene->views[0].camera.k2, -0.0805099, 0);
    assert_false(scene->has_alpha);
    for (uint32_t row = 0; row <= 480; row += 32) {
        for (uint32_t column = 0; column <= 270; column += 30) {
            double direction[3], x_px, y_px;
            assert_true(vw_camera_unproject(&scene->views[0].camera, column, row, direction));
            assert_true(vw_camera_project(&scene->views[0].camera, direction, &x_px, &y_px));
            assert_true(hypot(x_px - column, y_px - row) < 0.01);
        }
    }
}

TEST(chair_synthetic_is_read) {
    const char *path = real_scene_path("chair_synthetic");
    if (!path) skip();
    struct vw_scene *scene = tiny_scene_open(SCENE_PARAMS(.path = path));
    assert_int_equal(scene->split_count[VW_SPLIT_TRAIN], 100);
    assert_int_equal(scene->split_count[VW_SPLIT_VAL], 20);
    assert_int_equal(scene->split_count[VW_SPLIT_TEST], 20);
    assert_string_equal(scene->views[0].name, "train/r_0");
    assert_near(scene->views[0].camera.focal_x_px, 100 / tan(0.5 * 0.6911112070083618), 1e-9);
    assert_true(scene->has_alpha);
    assert_true(scene->background[1] == 1);
    check_box(&scene->box, 0, 0, 0, 1.55, 0.06);
}

// ---- Near and far --------------------------------------------------------------------------------------------------

// Makes a scene whose view 0 sees every point and view 1 every `stride`th. The test owns the scene, which owns the
// points.
static struct vw_scene *scene_with_points(uint32_t count, uint32_t stride, double offset_world) {
    struct vw_scene *scene = synthetic_scene(&(struct synthetic_scene_params){
        .train_views = 4, .val_views = 2, .width_px = 8, .height_px = 6, .world_offset = offset_world});
    scene->points = vw_allocate(count, sizeof *scene->points);
    scene->tracks = vw_allocate(2 * (size_t)count, sizeof *scene->tracks);
    scene->point_count = count;
    for (uint32_t p = 0; p < count; p++) {
        struct vw_point *point = &scene->points[p];
        point->first_track = scene->track_count;
        scene->tracks[scene->track_count++].view = 0;
        if (p % stride == 0) scene->tracks[scene->track_count++].view = 1;
        point->track_count = scene->track_count - point->first_track;
    }
    return scene;
}

// Puts a point at a depth along a view's axis and some way off it.
static void place(const struct vw_view *view, double depth, double aside, struct vw_point *point) {
    for (int i = 0; i < 3; i++)
        point->position_world[i] =
            view->camera_to_world[i][3] - depth * view->camera_to_world[i][2] + aside * view->camera_to_world[i][0];
}

TEST(near_and_far_are_percentiles) {
    struct vw_scene *scene = scene_with_points(1001, 1001, 0);
    for (uint32_t p = 0; p < 1001; p++)
        place(&scene->views[0], 1 + 0.001 * (p * 8 % 1001), p * 0.01 - 5, &scene->points[p]); // any order
    ASSERT_OK(vw_near_far_measure(scene));
    assert_near(scene->views[0].near_world, 1.001, 1e-12); // the second and the last but one of 1001
    assert_near(scene->views[0].far_world, 1.999, 1e-12);
    assert_true(scene->views[1].near_world == 0 && scene->views[1].far_world == 0); // one point is too few
    assert_true(scene->views[5].near_world == 0 && scene->views[5].far_world == 0); // none at all
    scene->point_count = 501;
    for (uint32_t p = 0; p < 501; p++)
        place(&scene->views[0], p < 100 ? -5 : 1 + 0.01 * (p - 100), 0, &scene->points[p]);
    ASSERT_OK(vw_near_far_measure(scene));
    assert_near(scene->views[0].near_world, 1.004,
                1e-12); // interpolated among 401 points; those behind the camera do not count
    assert_near(scene->views[0].far_world, 4.996, 1e-12);
}

TEST(each_view_has_its_own) {
    struct vw_scene *scene = scene_with_points(400, 4, 1e6);
    for (uint32_t p = 0; p < 400; p++) {
        place(&scene->views[1], 2, 0, &scene->points[p]); // at one place: all depths are equal
        scene->points[p].position_world[0] += 1e-3 * (p % 4);
    }
    ASSERT_OK(vw_near_far_measure(scene));
    assert_near(scene->views[1].near_world, 2, 1e-9); // it sees the points with p % 4 == 0
    assert_near(scene->views[1].far_world, 2, 1e-9);
    assert_true(scene->views[0].far_world > scene->views[0].near_world);
}

// ---- The box --------------------------------------------------------------------------------------------------------

// Spreads 1000 points over a box of 2 x 1 x 0.5 around (0.5, 0, 0), and 20 strays up to 1000 units away.
static void scatter(struct vw_scene *scene, double offset_world) {
    for (uint32_t p = 0; p < scene->point_count; p++) {
        double *position = scene->points[p].position_world;
        double stray = p % 51 == 50 ? 50.0 * (p / 51 + 1) * (p % 2 ? 1 : -1) : 0;
        position[0] = offset_world + 0.5 + 2.0 * (p % 100 / 99.0 - 0.5) + stray;
        position[1] = offset_world + 1.0 * (p * 7 % 100 / 99.0 - 0.5) + stray;
        position[2] = offset_world + 0.5 * (p * 13 % 100 / 99.0 - 0.5) + stray;
    }
}

TEST(the_box_holds_the_points) {
    static const double offsets[] = {0, 1e6, -1e6};
    struct vw_box boxes[VW_ARRAY_COUNT(offsets)];
    for (size_t i = 0; i < VW_ARRAY_COUNT(offsets); i++) {
        struct vw_scene *scene = scene_with_points(1020, 1, offsets[i]);
        scatter(scene, offsets[i]);
        ASSERT_OK(vw_bounds_choose(NULL, scene));
        boxes[i] = scene->box;
        assert_non_null(strstr(scene->box_source, "SfM points"));
        assert_near(scene->box.centre_world[0] - offsets[i], 0.5, 0.05);
        assert_near(scene->box.centre_world[1] - offsets[i], 0, 0.05);
        assert_near(scene->box.centre_world[2] - offsets[i], 0, 0.05);
        assert_near(scene->box.half_extent_world, 1.1,
                    0.05); // half of 2, less what the percentiles take, and a tenth more
        assert_near(scene->box.half_extent_world, boxes[0].half_extent_world,
                    1e-8); // exact but for the coordinates' own rounding
    }
}

// The box contains what the cameras look at, even where no points are: the synthetic cameras look at the origin.
TEST(the_box_holds_what_is_looked_at) {
    struct vw_scene *scene = scene_with_points(1000, 1, 0);
    for (uint32_t p = 0; p < 1000; p++)
        for (int i = 0; i < 3; i++)
            scene->points[p].position_world[i] =
                (i == 0 ? 5 : 0) + 0.5 * (p * (3 + 4u * (uint32_t)i) % 100 / 99.0 - 0.5);
    ASSERT_OK(vw_bounds_choose(NULL, scene));
    assert_true(scene->box.centre_world[0] - scene->box.half_extent_world <= 1e-9);
    assert_true(scene->box.centre_world[0] + scene->box.half_extent_world >= 5.2);
    assert_near(scene->box.half_extent_world, 2.6, 0.1);
}

TEST(a_declared_box_wins_over_points) {
    struct vw_scene *scene = scene_with_points(1020, 1, 0);
    scatter(scene, 0);
    const struct vw_ngp_box declared = {.aabb_scale = 1, .scale = 0.25, .offset = {0.5, 0.5, 0.5}};
    ASSERT_OK(vw_bounds_choose(&declared, scene)); // aabb_scale wins over points
    assert_true(scene->box.half_extent_world == 2 && strstr(scene->box_source, "aabb_scale"));
    ASSERT_OK(vw_bounds_choose(NULL, scene));
    assert_non_null(strstr(scene->box_source, "SfM points"));
    scene->point_count = 10; // too few
    ASSERT_OK(vw_bounds_choose(NULL, scene));
    assert_non_null(strstr(scene->box_source, "cameras"));
}
