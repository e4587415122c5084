// Splats of a scene without points begin on what photos show, where they agree on it. Here they show a wall, whose
// place is known.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "support/draws.h"
#include "support/trainer_fixture.h"
#include "train/renderers/splats/splats.h"

enum { PHOTOS = 7, SIDE_PX = 48, SPLATS = 400 };
static const double WALL_Z = -0.4, AWAY = 2.5, AT_WALL = 0.3; // world units

// Returns the grey of the wall: random, blended between whole places; with `plain`, three quarters are one grey.
static double wall_at(double x, double y, bool plain) {
    double u = 9.0 * (x + 2.0), v = 9.0 * (y + 2.0), sum = 0.0;
    if (plain && ((uint32_t)(u / 4.0) + 2 * (uint32_t)(v / 4.0)) % 4) return 0.5;
    for (uint32_t i = 0; i < 4; i++) {
        double weight = (i % 2 ? u - floor(u) : 1.0 - u + floor(u)) * (i / 2 ? v - floor(v) : 1.0 - v + floor(v));
        sum += weight * test_draw(7, (uint32_t)u + i % 2, (uint32_t)v + i / 2);
    }
    return 0.5 + 0.45 * sum;
}

// Makes photos of the wall by cameras side by side; left of `transparent_x` it is not there.
static struct vw_scene *wall_scene(bool plain, double transparent_x, double brighter) {
    struct vw_scene *scene = synthetic_scene(&(struct synthetic_scene_params){
        .train_views = PHOTOS, .width_px = SIDE_PX, .height_px = SIDE_PX, .alpha = transparent_x > -10.0});
    for (uint32_t v = 0; v < PHOTOS; v++) {
        struct vw_view *view = &scene->views[v];
        const double at[3] = {0.4 * (v - 3.0), 0.25 * (v % 3), AWAY};
        for (int i = 0; i < 3; i++)
            for (int column = 0; column < 4; column++)
                view->camera_to_world[i][column] = column == 3 ? at[i] : column == i;
        uint8_t *pixel = view->image.pixels;
        for (uint32_t i = 0; i < SIDE_PX * SIDE_PX; i++, pixel += 4) {
            double depth = AWAY - WALL_Z, focal = view->camera.focal_x_px,
                   x = at[0] + depth * (i % SIDE_PX + 0.5 - 0.5 * SIDE_PX) / focal,
                   y = at[1] - depth * (i / SIDE_PX + 0.5 - 0.5 * SIDE_PX) / focal;
            double grey = wall_at(x, y, plain) * (v % 2 ? brighter : 1.0);
            memset(pixel, (int)lrint(255.0 * fmin(fmax(grey, 0.0), 1.0)), 3);
            pixel[3] = x < transparent_x ? 0 : 255;
        }
    }
    return scene;
}

// Returns the means and, after them, the colours of splats that begin without points.
static float (*places_of(struct vw_scene *scene, uint64_t seed))[3] {
    struct vw_config config = test_config_of(VW_FIELD_SPLATS);
    struct vw_trainer *trainer = test_trainer_create(scene, &config, false, 0);
    float(*places)[3] = test_allocate(2 * SPLATS, sizeof *places);
    for (uint32_t i = 0; i < 2 * SPLATS; i++)
        for (int axis = 0; axis < 3; axis++) places[i][axis] = -1.0f;
    ASSERT_OK(vw_splats_place_by_photos(&trainer->model, scene, seed, SPLATS, places, places + SPLATS));
    test_release(trainer);
    return places;
}

// Returns the share of splats that begin at the wall, within what photos tell: at 0.3 from it, neighbours show a place
// a pixel apart (by z^2 / (focal * baseline), in world units 2.9^2 / (58 * 0.5)).
static double share_at_wall(float (*places)[3]) {
    uint32_t near = 0;
    for (uint32_t i = 0; i < SPLATS; i++) near += fabs((places[i][2] - 0.5) * 2.0 - WALL_Z) < AT_WALL;
    return (double)near / SPLATS;
}

TEST(splats_begin_on_what_photos_show) {
    static const double brighter[] = {1.0, 0.7};
    for (size_t i = 0; i < VW_ARRAY_COUNT(brighter); i++) { // a correlation takes exposures off
        double share = share_at_wall(places_of(wall_scene(false, -99.0, brighter[i]), i));
        if (share < 0.85) fail_msg("exposures that differ by %g: %.2f of splats begin at the wall", brighter[i], share);
    }
}

TEST(where_nothing_is_to_be_seen_splats_begin_beside_what_is) {
    double share = share_at_wall(places_of(wall_scene(true, -99.0, 1.0), 3));
    if (share < 0.8) fail_msg("%.2f of splats begin at the wall", share);
}

TEST(no_splat_begins_where_photos_are_transparent) {
    const double edge_x = -0.6;
    float(*places)[3] = places_of(wall_scene(false, edge_x, 1.0), 4);
    double share = share_at_wall(places);
    if (share < 0.8) fail_msg("%.2f of splats begin at the wall", share);
    for (uint32_t i = 0; i < SPLATS; i++) { // no farther beyond the edge than a ray goes where it may miss the wall
        double x = (places[i][0] - 0.5) * 2.0, z = (places[i][2] - 0.5) * 2.0;
        if (fabs(z - WALL_Z) < AT_WALL) assert_true(x > edge_x - 0.5 * AT_WALL);
    }
}

TEST(colours_are_those_of_the_wall) {
    float(*places)[3] = places_of(wall_scene(false, -99.0, 1.0), 5);
    for (uint32_t i = 0; i < SPLATS; i++) {
        if (fabs((places[i][2] - 0.5) * 2.0 - WALL_Z) > 0.02) continue;
        double grey = wall_at((places[i][0] - 0.5) * 2.0, (places[i][1] - 0.5) * 2.0, false);
        assert_near(places[SPLATS + i][1], grey, 0.08); // the wall changes by 0.06 in what 0.02 of depth shifts
    }
}

TEST(a_seed_draws_the_same_and_another_others) {
    struct vw_scene *scene = wall_scene(false, -99.0, 1.0);
    float(*first)[3] = places_of(scene, 6), (*again)[3] = places_of(scene, 6), (*other)[3] = places_of(scene, 7);
    assert_memory_equal(first, again, 2 * SPLATS * sizeof *first);
    assert_memory_not_equal(first, other, 2 * SPLATS * sizeof *first);
}

TEST(what_photos_tell_nothing_of_stays) {
    float(*places)[3] = places_of(wall_scene(false, 99.0, 1.0), 8); // all is transparent
    for (uint32_t i = 0; i < 2 * SPLATS; i++) assert_true(places[i][0] == -1.0f);
}

TEST_GROUP(NULL, test_gpu_close)
