// Places for the next photos in made-up worlds, whose depths are traced in double: they are new, clear of matter and
// see what known photos see. And depth maps against these worlds.
#include "support/cmocka_test.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "run/next/next_private.h"

enum { CAMERAS = 24, SEED = 5 };

struct ball {
    double centre[3], radius;
};
struct wall { // the points p with normal . p = offset, seen from both sides
    double normal[3], offset;
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
        if (steps > 0 && steps < least) least = steps;
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
            from[axis] = pose->camera_to_world[axis][VW_POSE_POSITION];
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
    struct vw_view views[CAMERAS + 3]; // the last three validate, in the places of cameras 0, 12 and 6
    struct vw_known_photos photos;
};

static void place_view(const struct world *world, uint32_t number, struct vw_view *view) {
    double position[3], target[3];
    const double *up = world->place == on_grid ? (double[]){0, 1, 0} : (double[]){0, 0, 1};
    view->name = (char *)"photo";
    view->camera = (struct vw_camera){.width_px = 64,
                                      .height_px = 48,
                                      .focal_x_px = 60 + number % 5,
                                      .focal_y_px = 60 + number % 5,
                                      .centre_x_px = 32,
                                      .centre_y_px = 24,
                                      .k1 = 0.01};
    world->place(number, position, target);
    assert_true(vw_camera_look_at(position, target, up, view->camera_to_world));
}

static struct known *make_known(const struct world *world) {
    struct known *known = vw_allocate(1, sizeof *known);
    known->scene = (struct vw_scene){.path = (char *)world->name,
                                     .views = known->views,
                                     .view_count = CAMERAS + 3,
                                     .split_count = {CAMERAS, 3},
                                     .box = {{0, 0, 0}, 2}};
    for (uint32_t v = 0; v < CAMERAS; v++) place_view(world, v, &known->views[v]);
    for (uint32_t v = 0; v < 3; v++) {
        place_view(world, (uint32_t[]){0, 12, 6}[v], &known->views[CAMERAS + v]);
        known->views[CAMERAS + v].split = VW_SPLIT_VAL;
    }
    ASSERT_OK(vw_known_photos_create(&known->scene, SEED, render, (void *)world, &known->photos));
    memcpy(known->photos.val_mse, (double[]){0.01, 0.02, 0.015}, 3 * sizeof(double));
    known->photos.usual_mse = 0.015;
    return known;
}

static void free_known(struct known *known) {
    vw_known_photos_destroy(&known->photos);
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
        double point[3], own[3], out[3], place[3];
        if (!vw_depth_map_point(map, i, point)) continue;
        for (int k = 0; k < 3; k++) own[k] = point[k] - map->pose.camera_to_world[k][3];
        points++;
        uint32_t seeing = 0;
        for (uint32_t v = 0; v < CAMERAS && seeing < 2; v++) {
            const double(*to_world)[4] = known->views[v].camera_to_world;
            const struct vw_camera pinhole = vw_camera_pinhole(&known->views[v].camera);
            double from[3], column, row;
            for (int k = 0; k < 3; k++) from[k] = to_world[k][3], out[k] = point[k] - from[k];
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
    ASSERT_OK(vw_depth_maps_make(&known->photos, &view, pose, 1, &map));
    for (uint32_t v = 0; v < CAMERAS; v++) counts[v] = known->photos.maps[v].seen_count;
    assert_true(map->seen_count >= 0.5 * vw_median(counts, CAMERAS));
    assert_true(map->nearest_world >= 0.5 * nearest->nearest_world);
    assert_true(share_seen(world, known, map) > 0.35);
    free(map);
}

TEST(places_are_new_clear_of_matter_and_see_what_photos_see) {
    for (size_t w = 0; w < VW_ARRAY_COUNT(worlds); w++) {
        const struct world *world = &worlds[w];
        struct known *known = make_known(world);
        struct vw_camera_path candidates;
        ASSERT_OK(vw_next_candidates_make(&known->photos, &candidates));
        print_message("%s: %u places\n", world->name, candidates.count);
        assert_in_range(candidates.count, 50, 400);
        for (uint32_t c = 0; c < candidates.count; c++) {
            const struct vw_view *candidate = &candidates.frames[c];
            const double(*pose)[4] = candidate->camera_to_world;
            const double position[3] = {pose[0][3], pose[1][3], pose[2][3]};
            uint32_t nearest = 0;
            for (uint32_t v = 0; v < CAMERAS; v++) {
                if (between(pose, known->views[v].camera_to_world) <
                    between(pose, known->views[nearest].camera_to_world))
                    nearest = v;
                assert_true(vw_view_apart(&known->photos.scales, candidate, &known->views[v]) >= 0.25);
            }
            double away = between(pose, known->views[nearest].camera_to_world);
            assert_true(away <= 2 * known->photos.scales.between_world * 1.000001);
            assert_free(world, known, position);
            assert_sees(world, known, candidate, &known->photos.maps[nearest]);
            assert_int_equal(candidate->camera.width_px, 64);
            assert_near(candidate->camera.focal_x_px, 62, 0); // in the middle
            assert_near(candidate->camera.k1, 0, 0);
        }
        vw_camera_path_free(&candidates);
        free_known(known);
    }
}

TEST(half_of_the_poses_lie_between_cameras_and_some_look_at_targets) {
    struct known *known = make_known(&worlds[0]);
    uint32_t inside = 0, at_target = 0;
    for (uint32_t v = 0; v < CAMERAS; v++) { // all look at the origin, and few photos see one point
        const double(*pose)[4] = known->views[v].camera_to_world;
        known->photos.maps[v].median_world = sqrt(pow(pose[0][3], 2) + pow(pose[1][3], 2) + pow(pose[2][3], 2));
        known->photos.points[v] = (struct vw_seen_points){.count = 1, .points_world = {{0, 0, -0.5}}};
    }
    for (uint32_t n = 0; n < 40 * CAMERAS; n++) {
        double pose[3][4], place[3], off_focus = 0, off_target = 0;
        assert_true(vw_next_draw_pose(&known->photos, n % CAMERAS, n / CAMERAS, pose));
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
        const double(*pose)[4] = known->views[v].camera_to_world, from[] = {pose[0][3], pose[1][3], pose[2][3]};
        uint32_t seen = 0;
        for (uint32_t pixel = 0; pixel < VW_DEPTH_MAP_PIXELS; pixel++) {
            double point[3];
            if (!vw_depth_map_point(&known->photos.maps[v], pixel, point)) continue;
            seen++;
            double off = fabs(point[2] + 0.9);
            for (uint32_t b = 0; b < world->ball_count; b++) {
                double away[3];
                for (int i = 0; i < 3; i++) away[i] = point[i] - world->balls[b].centre[i];
                off = fmin(off, fabs(sqrt(dot(away, away)) - world->balls[b].radius));
            }
            assert_near(off, 0, 1e-5);
            assert_true(vw_depth_map_sees(&known->photos.maps[v], from, point));
        }
        assert_int_equal(known->photos.maps[v].seen_count, seen);
    }
    static const double from[] = {3, 0.8, 1}, centre[] = {0, 0, 0}, before[] = {0.79, 0, 0};
    static const double behind[] = {-0.79, 0, 0}, away[] = {6, 0, 0.3};
    const struct vw_depth_map *map = &known->photos.maps[1];
    assert_true(vw_depth_map_sees(map, from, before));
    assert_false(vw_depth_map_sees(map, from, behind) || vw_depth_map_sees(map, from, away));
    assert_false(vw_depth_map_sees(map, centre, before)); // its other side
    free_known(known);
}

TEST(a_world_without_matter_has_no_places) {
    const struct world empty = {.name = "empty", .place = on_ring};
    struct known *known = make_known(&empty);
    struct vw_camera_path candidates;
    assert_int_equal(vw_next_candidates_make(&known->photos, &candidates), VW_ERROR_INPUT);
    assert_non_null(strstr(vw_error_message(), "empty: no place"));
    vw_camera_path_free(&candidates);
    free_known(known);
}

// Forgets what is said of proposals.
static void forget(struct vw_next *next) {
    for (uint32_t k = 0; k < next->proposal_count; k++) {
        free(next->proposals[k].nearest);
        free(next->proposals[k].move);
        next->proposals[k] = (struct vw_proposal){.pose = next->proposals[k].pose};
    }
}

TEST(reasons_follow_from_photos_and_errors) {
    const double up[3] = {0, 0, 1};
    const struct place {
        double position[3], target[3];
        const char *reason;
    } places[] = {
        {{2.9, -0.6, 0.5}, {0, 0, 0}, "between photos"},
        {{-2.9, 0.6, 0.5}, {0, 0, 0}, "high error"},
        {{7, -1, 4}, {0, 0, 0}, "extrapolates"}, // through a long lens
        // Away from all: camera 12, across, looks in a like direction, but is too far.
        {{2.9, -0.6, 0.5}, {9, -2, -0.5}, "seen by few, extrapolates"},
        {{2.9, -0.6, 0.5}, {9, -2, 9}, "extrapolates, sees nothing"},
        {{4.4, -0.9, 0.5}, {0, 0, 0}, ""}, // farther than usual, and seen
    };
    struct known *known = make_known(&worlds[0]);
    struct vw_view frames[VW_ARRAY_COUNT(places)] = {0};
    struct vw_proposal proposals[VW_ARRAY_COUNT(places)] = {0};
    for (uint32_t p = 0; p < VW_ARRAY_COUNT(places); p++) {
        struct vw_camera *camera = &frames[p].camera;
        *camera = vw_camera_pinhole(&known->views[0].camera);
        if (p == 2 || p == 5) camera->focal_x_px = camera->focal_y_px = 250;
        assert_true(vw_camera_look_at(places[p].position, places[p].target, up, frames[p].camera_to_world));
        proposals[p].pose = &frames[p];
    }
    struct vw_next next = {.proposals = proposals, .proposal_count = VW_ARRAY_COUNT(places)};
    ASSERT_OK(vw_next_describe(&known->photos, &next));
    for (uint32_t p = 0; p < VW_ARRAY_COUNT(places); p++) assert_string_equal(proposals[p].reason, places[p].reason);
    assert_int_equal(proposals[0].nearest_view, 23);
    assert_int_equal(proposals[1].nearest_view, 11);
    assert_true(proposals[0].seen_by > 2 * proposals[3].seen_by);
    forget(&next);
    known->photos.val_count = 2; // too few for a median
    ASSERT_OK(vw_next_describe(&known->photos, &next));
    assert_string_equal(proposals[1].reason, "between photos");
    forget(&next);
    free_known(known);
}

// Returns what a candidate gains beside the known photos and the first proposals, by its definition.
static double gain_of(const struct known *known, const struct vw_next *next, const struct vw_view *pose,
                      uint32_t proposal_count) {
    const struct vw_view_scales *scales = &known->photos.scales;
    double least = INFINITY, sum = 0, weights = 0;
    for (uint32_t v = 0; v < CAMERAS; v++) least = fmin(least, vw_view_apart(scales, pose, &known->views[v]));
    for (uint32_t k = 0; k < proposal_count; k++)
        least = fmin(least, vw_view_apart(scales, pose, next->proposals[k].pose));
    for (uint32_t v = 0; v < 3; v++) {
        double weight = 1 / (pow(vw_view_apart(scales, pose, &known->views[CAMERAS + v]), 2) + 0.25);
        sum += weight * (double[]){0.01, 0.02, 0.015}[v];
        weights += weight;
    }
    return least * sqrt(sum / weights);
}

// Forgets the proposals, but not the candidates.
static void choose_again(const struct known *known, uint32_t wanted, struct vw_next *next) {
    free(next->proposals);
    next->proposal_count = 0;
    ASSERT_OK(vw_next_choose(&known->photos, wanted, next));
}

TEST(the_farthest_by_error_are_proposed_one_after_another) {
    enum { WANTED = 12 };
    struct known *known = make_known(&worlds[0]);
    struct vw_next next = {0};
    ASSERT_OK(vw_next_candidates_make(&known->photos, &next.candidates));
    const struct vw_view *frames = next.candidates.frames;
    choose_again(known, WANTED, &next);
    assert_int_equal(next.proposal_count, WANTED);
    for (uint32_t k = 0; k < WANTED; k++) {
        double gain = next.proposals[k].gain;
        assert_near(gain, gain_of(known, &next, next.proposals[k].pose, k), 1e-12);
        for (uint32_t i = 0; i < next.candidates.count; i++)
            assert_true(gain_of(known, &next, &frames[i], k) <= gain + 1e-12);
    }
    vw_next_free(&next);
    free_known(known);
}

TEST(without_errors_distances_decide) {
    struct known *known = make_known(&worlds[0]);
    struct vw_next next = {0};
    ASSERT_OK(vw_next_candidates_make(&known->photos, &next.candidates));
    for (int validates = 1; validates >= 0; validates--) { // no error, and no validation photo
        double most = 0;
        memset(known->photos.val_mse, 0, 3 * sizeof(double));
        if (!validates) known->photos.val_count = 0;
        choose_again(known, 1, &next);
        for (uint32_t i = 0; i < next.candidates.count; i++) {
            double apart;
            vw_view_nearest(&known->scene, &known->photos.scales, known->photos.views, CAMERAS,
                            &next.candidates.frames[i], &apart);
            most = fmax(most, apart);
        }
        assert_near(next.proposals[0].gain, validates ? 1e-6 * most : most, 1e-18);
    }
    vw_next_free(&next);
    free_known(known);
}

TEST(a_move_is_along_the_axes_of_the_nearest_photo) {
    const double steps[3] = {0.4, -0.2, -0.1}, left = 40 * M_PI / 180, down = 20 * M_PI / 180;
    const double back[3] = {sin(left) * cos(down), sin(down), cos(left) * cos(down)};
    struct known *known = make_known(&worlds[0]);
    double usual_world = known->photos.scales.between_world * known->photos.scales.typical;
    known->views[7].name = (char *)"set/view_007";
    struct vw_view pose = known->views[7];
    struct vw_proposal proposal = {.pose = &pose};
    struct vw_next next = {.proposals = &proposal, .proposal_count = 1};
    ASSERT_OK(vw_next_describe(&known->photos, &next));
    assert_string_equal(proposal.move, "view_007: the same place");
    forget(&next);
    for (int i = 0; i < 3; i++) {
        const double *row = known->views[7].camera_to_world[i];
        pose.camera_to_world[i][3] += usual_world * dot(row, steps);
        pose.camera_to_world[i][2] = dot(row, back);
    }
    ASSERT_OK(vw_next_describe(&known->photos, &next));
    assert_string_equal(proposal.move, "view_007: 0.4 right, 0.2 down, 0.1 forward; turn 40 deg left, 20 deg down");
    forget(&next);
    free_known(known);
}

TEST(portraits_have_the_lens_of_landscapes) {
    struct known *known = make_known(&worlds[0]);
    struct vw_known_photos *photos = &known->photos;
    for (uint32_t v = 0; v < CAMERAS; v++) {
        struct vw_camera *camera = &known->views[v].camera;
        if (v % 2) *camera = vw_camera_resized(camera, 48, 64);
        camera->focal_x_px = 50 + v;
    }
    vw_known_photos_destroy(photos);
    ASSERT_OK(vw_known_photos_create(&known->scene, SEED, render, (void *)&worlds[0], photos));
    assert_int_equal(photos->usual, CAMERAS / 2 - 1);
    free_known(known);
}
