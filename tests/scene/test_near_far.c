// Near and far of each view, and the box, as the points tell them.
#include "base/memory.h"
#include "scene/builder.h"
#include "support/cmocka_test.h"
#include "support/synthetic_scene.h"

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
