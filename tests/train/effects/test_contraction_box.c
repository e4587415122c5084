// The inner region of unbounded scenes: which box the field sees when the effect unbounded is on.
// label: host
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "train/effects/field_box.h"

enum { VIEWS = 24, NEAR_POINTS = 600, FAR_POINTS = 400, POINTS = NEAR_POINTS + FAR_POINTS };

// A ring of cameras of radius 3 around a heap of points within 1 of the middle, and points at a horizon of radius 1000.
// The box of the scene holds everything.
struct ring {
    struct vw_view views[VIEWS];
    struct vw_point points[POINTS];
    struct vw_scene scene;
};

static void make_ring(double offset_world, double scale, struct ring *ring) {
    *ring =
        (struct ring){.scene = {.view_count = VIEWS, .point_count = POINTS, .box.half_extent_world = 1000.0 * scale}};
    ring->scene.views = ring->views;
    ring->scene.points = ring->points;
    for (int axis = 0; axis < 3; axis++) ring->scene.box.centre_world[axis] = offset_world;
    for (int v = 0; v < VIEWS; v++) {
        double angle = 2.0 * M_PI * v / VIEWS;
        const double place[3] = {3.0 * cos(angle), 3.0 * sin(angle), 0.5};
        for (int axis = 0; axis < 3; axis++)
            ring->views[v].camera_to_world[axis][3] = offset_world + scale * place[axis];
    }
    for (int p = 0; p < POINTS; p++) {
        double angle = 2.4 * p, radius = p < NEAR_POINTS ? sqrt((p + 0.5) / NEAR_POINTS) : 1000.0;
        const double place[3] = {radius * cos(angle), radius * sin(angle), 0.1 * (p % 10)};
        for (int axis = 0; axis < 3; axis++) ring->points[p].position_world[axis] = offset_world + scale * place[axis];
    }
}

static struct vw_box box_of(const struct ring *ring) {
    struct vw_box box;
    struct vw_scene scene = ring->scene;
    assert_int_equal(vw_contraction_box(&scene, NULL, 0, &box), VW_OK);
    return box;
}

TEST(holds_cameras_and_what_they_look_at) {
    struct ring ring;
    make_ring(0.0, 1.0, &ring);
    struct vw_box box = box_of(&ring);
    assert_near(box.centre_world[0], 0.0, 0.15);
    assert_near(box.centre_world[1], 0.0, 0.15);
    assert_near(box.centre_world[2], 0.5, 0.1);
    assert_near(box.half_extent_world, 3.3, 0.2); // the ring, and a tenth more
}

// Metres or miles, here or 10^6 m away: the same box, but for the rounding of the coordinates.
TEST(follows_the_world) {
    static const double offsets[] = {0.0, 1e6}, scales[] = {1.0, 1e-3, 1609.0};
    struct ring ring;
    make_ring(0.0, 1.0, &ring);
    struct vw_box plain = box_of(&ring);
    for (size_t o = 0; o < VW_ARRAY_COUNT(offsets); o++) {
        for (size_t s = 0; s < VW_ARRAY_COUNT(scales); s++) {
            make_ring(offsets[o], scales[s], &ring);
            struct vw_box box = box_of(&ring);
            double rounding = 1e-9 + offsets[o] * 0x1p-50 / scales[s];
            assert_near(box.half_extent_world / scales[s], plain.half_extent_world, rounding);
            for (int axis = 0; axis < 3; axis++)
                assert_near((box.centre_world[axis] - offsets[o]) / scales[s], plain.centre_world[axis], rounding);
        }
    }
}

// All cameras on one side of a wall: the ball holds both.
TEST(holds_a_facade_and_its_cameras) {
    struct ring ring;
    make_ring(0.0, 1.0, &ring);
    for (int v = 0; v < VIEWS; v++)
        for (int axis = 0; axis < 3; axis++) ring.views[v].camera_to_world[axis][3] = axis == 0 ? -20.0 : 0.1 * v;
    struct vw_box box = box_of(&ring);
    assert_near(box.centre_world[0], -10.0, 0.5);
    assert_near(box.half_extent_world, 11.0, 1.0);
}

// Strays: a camera that is lost, and points that are few or none.
TEST(keeps_its_place) {
    struct ring ring;
    make_ring(0.0, 1.0, &ring);
    struct vw_box plain = box_of(&ring);
    ring.views[7].camera_to_world[1][3] = 1e9;
    assert_near(box_of(&ring).half_extent_world, plain.half_extent_world, 0.5);
    make_ring(0.0, 1.0, &ring);
    ring.views[7].camera_to_world[1][3] = 1e9;
    ring.views[7].split = VW_SPLIT_EXCLUDED;
    assert_near(box_of(&ring).half_extent_world, plain.half_extent_world, 0.5);
    make_ring(0.0, 1.0, &ring);
    ring.scene.point_count = 63;
    assert_near(box_of(&ring).half_extent_world, 1.1 * 3.0, 1e-9);
    ring.scene.point_count = 0;
    assert_near(box_of(&ring).half_extent_world, 1.1 * 3.0, 1e-9);
}

// A box that is smaller says where detail is wanted; a single camera without points says nothing.
TEST(a_smaller_box_stays) {
    struct ring ring;
    make_ring(0.0, 1.0, &ring);
    ring.scene.box = (struct vw_box){{0.25, 0.5, 0.75}, 2.0};
    struct vw_box box = box_of(&ring);
    assert_memory_equal(&box, &ring.scene.box, sizeof box);
    make_ring(0.0, 1.0, &ring);
    ring.scene.view_count = 1;
    ring.scene.point_count = 0;
    box = box_of(&ring);
    assert_memory_equal(&box, &ring.scene.box, sizeof box);
}

// The order in which cameras and points are listed does not count.
TEST(order_does_not_count) {
    struct ring ring;
    make_ring(0.0, 1.0, &ring);
    struct vw_box plain = box_of(&ring);
    for (int p = 0; p < POINTS / 2; p++) {
        struct vw_point kept = ring.points[p];
        ring.points[p] = ring.points[POINTS - 1 - p];
        ring.points[POINTS - 1 - p] = kept;
    }
    struct vw_box box = box_of(&ring);
    assert_memory_equal(&box, &plain, sizeof box);
}

// The box of the effect wide_box: by observations, and not by points, since a point that many photos see counts more.
TEST(a_wide_box_holds_what_photos_see) {
    struct ring ring;
    struct vw_box box;
    make_ring(0.0, 1.0, &ring);
    ring.scene.box.half_extent_world = 1.0;
    assert_int_equal(vw_wide_box(&ring.scene, &box), VW_OK); // no photo sees them: the same as without points
    assert_near(box.half_extent_world, 2.0, 1e-12);
    for (int p = 0; p < POINTS; p++) ring.points[p].track_count = p < NEAR_POINTS ? 100 : 1;
    ring.scene.track_count = 100 * NEAR_POINTS + FAR_POINTS;
    assert_int_equal(vw_wide_box(&ring.scene, &box), VW_OK); // 0.7 % of the observations are at the horizon
    assert_near(box.half_extent_world, 1.1, 0.02);
    assert_int_equal(vw_scene_count_outside(&ring.scene, &box), FAR_POINTS);
    for (int p = NEAR_POINTS; p < POINTS; p++) ring.points[p].track_count = 10;
    ring.scene.track_count += 9 * FAR_POINTS;
    assert_int_equal(vw_wide_box(&ring.scene, &box), VW_OK);
    assert_near(box.half_extent_world, 4.0, 1e-12);
    ring.scene.box.half_extent_world = 5000.0;
    assert_int_equal(vw_wide_box(&ring.scene, &box), VW_OK); // never narrower
    assert_near(box.half_extent_world, 5000.0, 1e-9);
    assert_int_equal(vw_scene_count_outside(&ring.scene, &box), 0);
}
