// Places for the next photos in made-up worlds, whose depths are traced in double: they are new, clear of matter and
// see what known photos see. And depth maps against these worlds.
#include "support/cmocka_test.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/statistics.h"
#include "run/next/candidate_poses.h"
#include "run/next/make_candidates.h"
#include "run/next/move.h"
#include "run/next/reasons.h"
#include "scene/camera_path.h"

enum { POSITION = 3, CAMERAS = 24, SEED = 5 };

struct ball {
    double centre[3], radius;
};
struct wall { // the points p with normal . p = offset, seen from both sides, at most `radius` from the origin
    double normal[3], offset, radius; // 0: without an end
};
struct world {
    const char *name;
    struct ball balls[4];
    struct wall walls[6];
    uint32_t ball_count, wall_count;
    void (*place)(uint32_t number, double position[3], double target[3]); // places its cameras
};

// ---- Worlds --------------------------------------------------------------------------------------------------------

static void on_ring(uint32_t number, double position[3], double target[3]) {
    double angle = 2 * M_PI * number / CAMERAS;
    position[0] = 3 * cos(angle);
    position[1] = 3 * sin(angle);
    position[2] = number % 2;
    for (int i = 0; i < 3; i++) target[i] = 0;
}

static void on_grid(uint32_t number, double position[3], double target[3]) {
    uint32_t column = number % 6, row = number / 6;
    position[0] = target[0] = 0.4 * column - 1;
    position[1] = target[1] = 0.4 * row - 0.6;
    position[2] = 0;
    target[2] = -4;
}

static void in_room(uint32_t number, double position[3], double target[3]) {
    double angle = 2 * M_PI * number / CAMERAS;
    position[0] = 1.6 * cos(angle);
    position[1] = 1.6 * sin(angle);
    position[2] = target[2] = 0.3 * (number % 2);
    target[0] = 2 * cos(angle + 0.9);
    target[1] = 2 * sin(angle + 0.9);
}

static void on_walk(uint32_t number, double position[3], double target[3]) {
    position[0] = 0.4 * number;
    position[1] = 0.1 * (number % 3);
    position[2] = 0;
    target[0] = position[0] + 3;
    target[1] = number % 2 ? 2 : -2;
    target[2] = -0.5;
}

static void over_table(uint32_t number, double position[3], double target[3]) {
    double angle = 2 * M_PI * number / CAMERAS;
    position[0] = 2.2 * cos(angle); // round the table, above its top
    position[1] = 2.2 * sin(angle);
    position[2] = number % 2 ? 2 : 0.6;
    for (int i = 0; i < 3; i++) target[i] = 0;
}

static const struct world worlds[] = {
    // A ball to look at, and one that stands on the ring between two cameras.
    {"turntable", {{{0, 0, 0}, 0.8}, {{3, 0.38, 0.5}, 0.25}}, {{{0, 0, 1}, -0.9}}, 2, 1, on_ring},
    {"forward", {{{0, 0, -3}, 0.5}}, {{{0, 0, 1}, -4}, {{1, 0, 0}, 1.15}}, 1, 2, on_grid},
    {"room",
     {{{0, 0, 0}, 0.4}},
     {{{1, 0, 0}, 2}, {{1, 0, 0}, -2}, {{0, 1, 0}, 2}, {{0, 1, 0}, -2}, {{0, 0, 1}, 1}, {{0, 0, 1}, -1}},
     1,
     6,
     in_room},
    {"walk", {{{3, 1, 0}, 0.5}, {{6, -1.2, 0}, 0.5}}, {{{0, 0, 1}, -0.5}, {{0, 1, 0}, 3}}, 2, 2, on_walk},
    {"table", {{{0, 0, -0.1}, 0.3}}, {{{0, 0, 1}, -0.4, 1.9}}, 1, 1, over_table},
};

static double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// Returns how many `direction`s it is to the nearest matter; 0: none.
static double trace(const struct world *world, const double from[3], const double direction[3]) {
    double least = INFINITY;
    for (uint32_t b = 0; b < world->ball_count; b++) {
        double away[3];
        for (int i = 0; i < 3; i++) away[i] = from[i] - world->balls[b].centre[i];
        double a = dot(direction, direction), half = dot(direction, away),
               rest = dot(away, away) - world->balls[b].radius * world->balls[b].radius, root = half * half - a * rest;
        for (int sign = -1; sign <= 1 && root >= 0; sign += 2) {
            double steps = (-half + sign * sqrt(root)) / a;
            if (steps > 0 && steps < least) least = steps;
        }
    }
    for (uint32_t w = 0; w < world->wall_count; w++) {
        const struct wall *wall = &world->walls[w];
        double steps = (wall->offset - dot(wall->normal, from)) / dot(wall->normal, direction);
        double off = 0;
        for (int i = 0; i < 3; i++) off = hypot(off, from[i] + steps * direction[i]);
        if (steps > 0 && steps < least && (wall->radius == 0 || off <= wall->radius)) least = steps;
    }
    return isinf(least) ? 0 : least;
}

static enum vw_status render(void *context, const uint32_t *views, const struct vw_view *poses, uint32_t count,
                             float **depths_world) {
    uint32_t pixels = poses->camera.width_px * poses->camera.height_px;
    float *made = vw_allocate((size_t)count * pixels, sizeof *made);
    (void)views;
    for (uint32_t i = 0; i < count * pixels; i++) {
        const struct vw_view *pose = &poses[i / pixels];
        uint32_t column = i % pixels % pose->camera.width_px, row = i % pixels / pose->camera.width_px;
        double camera[3], from[3], direction[3] = {0};
        assert_true(vw_camera_unproject(&pose->camera, column + 0.5, row + 0.5, camera));
        for (int axis = 0; axis < 3; axis++) {
            from[axis] = pose->camera_to_world[axis][POSITION];
            for (int k = 0; k < 3; k++) direction[axis] += pose->camera_to_world[axis][k] * camera[k];
        }
        made[i] = (float)trace(context, from, direction);
    }
    *depths_world = made;
    return VW_OK;
}

// ---- A scene of a world --------------------------------------------------------------------------------------------

struct known {
    struct vw_scene scene;
    struct vw_view views[CAMERAS];
    uint32_t list[CAMERAS];
    struct vw_view_scales scales;
    struct vw_depth_map *maps;
    struct vw_candidate_params params;
};

static struct known *make_known(const struct world *world) {
    const double up[3] = {0, 0, 1};
    struct known *known = vw_allocate(1, sizeof *known);
    known->scene = (struct vw_scene){.path = (char *)world->name,
                                     .views = known->views,
                                     .view_count = CAMERAS,
                                     .split_count = {CAMERAS},
                                     .box = {{0, 0, 0}, 2}};
    for (uint32_t v = 0; v < CAMERAS; v++) {
        double position[3], target[3];
        known->list[v] = v;
        known->views[v].camera = (struct vw_camera){.width_px = 64,
                                                    .height_px = 48,
                                                    .focal_x_px = 60 + v % 5,
                                                    .focal_y_px = 60 + v % 5,
                                                    .centre_x_px = 32,
                                                    .centre_y_px = 24,
                                                    .k1 = 0.01};
        world->place(v, position, target);
        if (world->place == on_grid) // y is up there
            assert_true(vw_camera_look_at(position, target, (double[]){0, 1, 0}, known->views[v].camera_to_world));
        else assert_true(vw_camera_look_at(position, target, up, known->views[v].camera_to_world));
    }
    ASSERT_OK(vw_view_scales_find(&known->scene, &known->scales));
    known->params = (struct vw_candidate_params){.scene = &known->scene,
                                                 .scales = &known->scales,
                                                 .views = known->list,
                                                 .count = CAMERAS,
                                                 .depths = {render, (void *)world},
                                                 .seed = SEED};
    ASSERT_OK(vw_depth_maps_make(&known->params.depths, known->list, known->views, CAMERAS, &known->maps));
    known->params.maps = known->maps;
    return known;
}

static void free_known(struct known *known) {
    free(known->maps);
    free(known);
}

static double between(const double a[3][4], const double b[3][4]) {
    return sqrt(pow(a[0][3] - b[0][3], 2) + pow(a[1][3] - b[1][3], 2) + pow(a[2][3] - b[2][3], 2));
}

// ---- Tests ---------------------------------------------------------------------------------------------------------

static void assert_free(const struct world *world, const struct known *known, const double position[3]) {
    for (uint32_t b = 0; b < world->ball_count; b++) {
        double away[3];
        for (int i = 0; i < 3; i++) away[i] = position[i] - world->balls[b].centre[i];
        assert_true(dot(away, away) > world->balls[b].radius * world->balls[b].radius);
    }
    for (uint32_t w = 0; w < world->wall_count; w++) { // all cameras are on one side of each wall
        const double first[3] = {known->views[0].camera_to_world[0][3], known->views[0].camera_to_world[1][3],
                                 known->views[0].camera_to_world[2][3]};
        const struct wall *wall = &world->walls[w];
        assert_true((dot(wall->normal, position) - wall->offset) * (dot(wall->normal, first) - wall->offset) > 0);
    }
}

// Returns the share of what a map sees that two known photos see from the same side.
static double share_seen(const struct world *world, const struct known *known, const struct vw_depth_map *map) {
    uint32_t points = 0, seen = 0;
    for (uint32_t i = 0; i < VW_DEPTH_MAP_PIXELS; i++) {
        struct vw_sight sight;
        double own[3], out[3], place[3];
        if (!vw_depth_map_point(map, i, &sight)) continue;
        for (int k = 0; k < 3; k++) own[k] = sight.point_world[k] - sight.from_world[k];
        points++;
        uint32_t seeing = 0;
        for (uint32_t v = 0; v < CAMERAS && seeing < 2; v++) {
            const double(*to_world)[4] = known->views[v].camera_to_world;
            const struct vw_camera pinhole = vw_camera_pinhole(&known->views[v].camera);
            double from[3], column, row;
            for (int k = 0; k < 3; k++) from[k] = to_world[k][3], out[k] = sight.point_world[k] - from[k];
            for (int k = 0; k < 3; k++)
                place[k] = to_world[0][k] * out[0] + to_world[1][k] * out[1] + to_world[2][k] * out[2];
            bool in_picture =
                vw_camera_project(&pinhole, place, &column, &row) && column >= 0 && column < 64 && row >= 0 && row < 48;
            bool same_side = dot(own, out) >= 0.5 * sqrt(dot(own, own) * dot(out, out));
            seeing += in_picture && same_side && trace(world, from, out) > 0.9; // nothing is before the point
        }
        seen += seeing == 2;
    }
    return points ? seen / (double)points : 0;
}

static void assert_sees(const struct world *world, const struct known *known, const struct vw_view *pose,
                        const struct vw_depth_map *nearest) {
    const uint32_t view = 0;
    struct vw_depth_map *map = NULL;
    double counts[CAMERAS];
    ASSERT_OK(vw_depth_maps_make(&known->params.depths, &view, pose, 1, &map));
    for (uint32_t v = 0; v < CAMERAS; v++) counts[v] = known->maps[v].seen_count;
    assert_true(map->seen_count >= 0.5 * vw_median(counts, CAMERAS));
    assert_true(map->nearest_world >= 0.5 * nearest->nearest_world);
    assert_true(share_seen(world, known, map) > 0.35);
    free(map);
}

TEST(places_are_new_clear_of_matter_and_see_what_photos_see) {
    for (size_t w = 0; w < VW_ARRAY_COUNT(worlds); w++) {
        const struct world *world = &worlds[w];
        struct known *known = make_known(world);
        struct vw_candidate *candidates = NULL;
        uint32_t count = 0;
        ASSERT_OK(vw_next_candidates_make(&known->params, &candidates, &count));
        print_message("%s: %u places\n", world->name, count);
        assert_in_range(count, 50, 400);
        for (uint32_t c = 0; c < count; c++) {
            const double(*pose)[4] = candidates[c].pose.camera_to_world;
            const double position[3] = {pose[0][3], pose[1][3], pose[2][3]};
            uint32_t nearest = 0;
            for (uint32_t v = 0; v < CAMERAS; v++) {
                if (between(pose, known->views[v].camera_to_world) <
                    between(pose, known->views[nearest].camera_to_world))
                    nearest = v;
                assert_true(vw_view_apart(&known->scales, &candidates[c].pose, &known->views[v]) >= 0.25);
            }
            double away = between(pose, known->views[nearest].camera_to_world);
            assert_true(away <= 2 * known->scales.between_world * 1.000001);
            assert_free(world, known, position);
            assert_sees(world, known, &candidates[c].pose, &known->maps[nearest]);
            assert_int_equal(candidates[c].pose.camera.width_px, 64);
            assert_near(candidates[c].pose.camera.focal_x_px, 62, 0); // in the middle
            assert_near(candidates[c].pose.camera.k1, 0, 0);
        }
        vw_next_candidates_free(&candidates, count);
        free_known(known);
    }
}

TEST(a_seed_gives_the_same_places) {
    struct known *known = make_known(&worlds[0]);
    struct vw_candidate *first = NULL, *second = NULL, *other = NULL;
    uint32_t first_count = 0, second_count = 0, other_count = 0;
    ASSERT_OK(vw_next_candidates_make(&known->params, &first, &first_count));
    ASSERT_OK(vw_next_candidates_make(&known->params, &second, &second_count));
    known->params.seed = SEED + 1;
    ASSERT_OK(vw_next_candidates_make(&known->params, &other, &other_count));
    assert_int_equal(first_count, second_count);
    for (uint32_t c = 0; c < first_count; c++)
        assert_memory_equal(first[c].pose.camera_to_world, second[c].pose.camera_to_world,
                            sizeof first[c].pose.camera_to_world);
    assert_memory_not_equal(first->pose.camera_to_world, other->pose.camera_to_world,
                            sizeof first->pose.camera_to_world);
    vw_next_candidates_free(&first, first_count);
    vw_next_candidates_free(&second, second_count);
    vw_next_candidates_free(&other, other_count);
    free_known(known);
}

TEST(half_of_the_poses_lie_between_cameras_and_some_look_at_targets) {
    struct known *known = make_known(&worlds[0]);
    struct vw_pose_base bases[CAMERAS] = {0};
    uint32_t inside = 0, at_target = 0;
    for (uint32_t v = 0; v < CAMERAS; v++)
        bases[v] = (struct vw_pose_base){.view = v, .target_count = 1, .targets_world = {{0, 0, -0.5}}};
    const struct vw_pose_bases all = {&known->scene, &known->scales, bases, CAMERAS, SEED};
    for (uint32_t n = 0; n < 40 * CAMERAS; n++) {
        double pose[3][4], place[3], off_focus = 0, off_target = 0;
        assert_true(vw_pose_draw(&all, n % CAMERAS, n / CAMERAS, pose));
        for (int k = 0; k < 3; k++)
            place[k] = pose[0][k] * pose[0][3] + pose[1][k] * pose[1][3] + pose[2][k] * pose[2][3];
        off_focus = hypot(place[0], place[1]); // the origin's distance from the axis
        for (int k = 0; k < 2; k++) off_target = hypot(off_target, place[k] + 0.5 * pose[2][k]);
        assert_true(off_focus < 1e-9 || off_target < 1e-9);
        at_target += off_target < 1e-9;
        inside += hypot(pose[0][3], pose[1][3]) <= 3 + 1e-12 && pose[2][3] > -1e-12 && pose[2][3] < 1 + 1e-12;
    }
    assert_int_equal(at_target, 10 * CAMERAS);
    assert_true(inside >= 20 * CAMERAS);
    free_known(known);
}

TEST(maps_know_their_surface_and_who_sees_it) {
    const struct world *world = &worlds[0];
    struct known *known = make_known(world);
    for (uint32_t v = 0; v < CAMERAS; v++) {
        struct vw_sight sight;
        uint32_t seen = 0;
        for (uint32_t pixel = 0; pixel < VW_DEPTH_MAP_PIXELS; pixel++) {
            if (!vw_depth_map_point(&known->maps[v], pixel, &sight)) continue;
            const double *point = sight.point_world;
            seen++;
            double off = fabs(point[2] + 0.9);
            for (uint32_t b = 0; b < world->ball_count; b++) {
                double away[3];
                for (int i = 0; i < 3; i++) away[i] = point[i] - world->balls[b].centre[i];
                off = fmin(off, fabs(sqrt(dot(away, away)) - world->balls[b].radius));
            }
            assert_near(off, 0, 1e-5);
            assert_true(vw_depth_map_sees(&known->maps[v], &sight));
        }
        assert_int_equal(known->maps[v].seen_count, seen);
    }
    const struct vw_sight behind = {{3, 0.8, 1}, {-0.79, 0, 0}}, before = {{3, 0.8, 1}, {0.79, 0, 0}},
                          away = {{3, 0.8, 1}, {6, 0, 0.3}}, inside = {{0, 0, 0}, {0.79, 0, 0}};
    assert_true(vw_depth_map_sees(&known->maps[1], &before));
    assert_false(vw_depth_map_sees(&known->maps[1], &behind));
    assert_false(vw_depth_map_sees(&known->maps[1], &away));
    assert_false(vw_depth_map_sees(&known->maps[1], &inside)); // its other side
    assert_int_equal(vw_depth_maps_count_seeing(known->maps, CAMERAS, &before, 2), 2);
    free_known(known);
}

TEST(a_world_without_matter_has_no_places) {
    const struct world empty = {.name = "empty", .place = on_ring};
    struct known *known = make_known(&empty);
    struct vw_candidate *candidates = NULL;
    uint32_t count = 0;
    assert_int_equal(vw_next_candidates_make(&known->params, &candidates, &count), VW_ERROR_INPUT);
    assert_non_null(strstr(vw_error_message(), "empty: no place"));
    assert_null(candidates);
    free_known(known);
}

TEST(reasons_follow_from_photos_and_errors) {
    const double up[3] = {0, 0, 1};
    const struct place {
        double position[3], target[3];
        uint32_t reasons;
    } places[] = {
        {{2.9, -0.6, 0.5}, {0, 0, 0}, 1u << VW_BETWEEN_PHOTOS},
        {{-2.9, 0.6, 0.5}, {0, 0, 0}, 1u << VW_HIGH_ERROR},
        {{7, -1, 4}, {0, 0, 0}, 1u << VW_EXTRAPOLATES}, // through a long lens
        // Away from all: camera 12, across, looks in a like direction, but is too far.
        {{2.9, -0.6, 0.5}, {9, -2, -0.5}, 1u << VW_EXTRAPOLATES | 1u << VW_SEEN_BY_FEW},
        {{2.9, -0.6, 0.5}, {9, -2, 9}, 1u << VW_EXTRAPOLATES | 1u << VW_SEES_NOTHING},
        {{4.4, -0.9, 0.5}, {0, 0, 0}, 0}, // farther than usual, and seen
    };
    const uint32_t val_views[3] = {0, 12, 6};
    const double val_mse[3] = {0.01, 0.02, 0.015};
    struct known *known = make_known(&worlds[0]);
    struct vw_candidate candidates[VW_ARRAY_COUNT(places)] = {0};
    struct vw_proposal proposals[VW_ARRAY_COUNT(places)] = {0};
    for (uint32_t p = 0; p < VW_ARRAY_COUNT(places); p++) {
        struct vw_camera *camera = &candidates[p].pose.camera;
        *camera = vw_camera_pinhole(&known->views[0].camera);
        if (p == 2 || p == 5) camera->focal_x_px = camera->focal_y_px = 250;
        assert_true(vw_camera_look_at(places[p].position, places[p].target, up, candidates[p].pose.camera_to_world));
        proposals[p].candidate = p;
    }
    struct vw_known_views views = {.scene = &known->scene,
                                   .scales = known->scales,
                                   .views = known->list,
                                   .count = CAMERAS,
                                   .val_views = val_views,
                                   .val_mse = val_mse,
                                   .val_count = 3};
    struct vw_next next = {.candidates = candidates,
                           .candidate_count = VW_ARRAY_COUNT(places),
                           .proposals = proposals,
                           .proposal_count = VW_ARRAY_COUNT(places)};
    ASSERT_OK(vw_next_find_reasons(&views, known->maps, &known->params.depths, &next));
    for (uint32_t p = 0; p < VW_ARRAY_COUNT(places); p++) assert_int_equal(proposals[p].reasons, places[p].reasons);
    assert_int_equal(proposals[0].nearest_view, 23);
    assert_int_equal(proposals[1].nearest_view, 11);
    assert_true(proposals[0].seen_by > 2 * proposals[3].seen_by);
    for (uint32_t p = 0; p < VW_ARRAY_COUNT(places); p++) proposals[p].reasons = 0;
    views.val_count = 2; // too few for a median
    ASSERT_OK(vw_next_find_reasons(&views, known->maps, &known->params.depths, &next));
    assert_int_equal(proposals[1].reasons, 1u << VW_BETWEEN_PHOTOS);
    free_known(known);
}

TEST(a_move_is_along_the_axes_of_the_nearest_photo) {
    const double steps[3] = {0.4, -0.2, -0.1}, left = 40 * M_PI / 180, down = 20 * M_PI / 180;
    const double back[3] = {sin(left) * cos(down), sin(down), cos(left) * cos(down)};
    struct known *known = make_known(&worlds[0]);
    const struct vw_known_views views = {
        .scene = &known->scene, .scales = known->scales, .views = known->list, .count = CAMERAS};
    double usual_world = known->scales.between_world * known->scales.typical;
    known->views[7].name = (char *)"set/view_007";
    struct vw_view pose = known->views[7];
    char *same = vw_next_describe_move(&views, &pose);
    assert_string_equal(same, "view_007: the same place");
    free(same);
    for (int i = 0; i < 3; i++) {
        const double *row = known->views[7].camera_to_world[i];
        pose.camera_to_world[i][3] += usual_world * dot(row, steps);
        pose.camera_to_world[i][2] = dot(row, back);
    }
    char *move = vw_next_describe_move(&views, &pose);
    assert_string_equal(move, "view_007: 0.4 right, 0.2 down, 0.1 forward; turn 40 deg left, 20 deg down");
    free(move);
    free_known(known);
}

TEST(portraits_have_the_lens_of_landscapes) {
    struct vw_view views[] = {{.camera = {.width_px = 40, .height_px = 30, .focal_x_px = 30}},
                              {.camera = {.width_px = 30, .height_px = 40, .focal_x_px = 31}},
                              {.camera = {.width_px = 40, .height_px = 30, .focal_x_px = 32}}};
    const struct vw_scene scene = {.views = views, .view_count = 3};
    assert_int_equal(vw_usual_view(&scene, (uint32_t[]){0, 1, 2}, 3), 1);
}

TEST(words_of_reasons_are_known_and_joined) {
    char text[64];
    vw_next_print_reasons(1u << VW_SEEN_BY_FEW | 1u << VW_EXTRAPOLATES, text, sizeof text);
    assert_string_equal(text, "seen by few, extrapolates");
    vw_next_print_reasons(0, text, sizeof text);
    assert_string_equal(text, "");
    assert_true(vw_next_reason_is_known("high error"));
    assert_false(vw_next_reason_is_known("high"));
    assert_false(vw_next_reason_is_known(NULL));
}
