// Recipes drawn by a device: geometry against analysis, defects, determinism, points.

#include "image/image.h"
#include "support/gpu_fixture.h"
#include "support/recipe_fixture.h"

static const double sphere_centre[3] = {0.2, -0.1, 0.3}, sphere_radius = 0.5; // centre and radius in RECIPE_SPHERE

static struct vw_scene_params on_gpu(void) { return (struct vw_scene_params){.gpu = test_gpu()}; }

static struct vw_scene *draw(const char *from, const char *to, const char *from2, const char *to2) {
    return open_changed(on_gpu(), from, to, from2, to2);
}

static void pixel_of(const struct vw_scene *scene, uint32_t view, double x_px, double y_px, float rgba[4]) {
    vw_image_pixel(&scene->views[view].image, (uint32_t)x_px, (uint32_t)y_px, rgba);
}

// Finds the direction, in world axes, from a view's position through a place in its photo.
static void world_ray(const struct vw_view *view, double x_px, double y_px, double direction[3]) {
    double camera[3], length;
    assert_true(vw_camera_unproject(&view->camera, x_px, y_px, camera));
    length = sqrt(camera[0] * camera[0] + camera[1] * camera[1] + camera[2] * camera[2]);
    for (int i = 0; i < 3; i++) {
        const double *row = view->camera_to_world[i];
        direction[i] = (row[0] * camera[0] + row[1] * camera[1] + row[2] * camera[2]) / length;
    }
}

// Returns how far from the sphere's centre a view's line through (x_px, y_px) passes.
static double miss_distance(const struct vw_view *view, double x_px, double y_px) {
    double direction[3], offset[3], along = 0, distance2 = 0;
    world_ray(view, x_px, y_px, direction);
    for (int i = 0; i < 3; i++) offset[i] = sphere_centre[i] - view->camera_to_world[i][3];
    for (int i = 0; i < 3; i++) along += offset[i] * direction[i];
    for (int i = 0; i < 3; i++) distance2 += pow(offset[i] - along * direction[i], 2);
    return sqrt(distance2);
}

// Checks that a pixel shows the sphere exactly where the line through its centre meets it.
static void check_silhouette(const struct vw_scene *scene) {
    uint32_t inside = 0, outside = 0;
    for (uint32_t v = 0; v < scene->view_count; v++)
        for (uint32_t y = 0; y < 24; y++)
            for (uint32_t x = 0; x < 32; x++) {
                float rgba[4];
                pixel_of(scene, v, x, y, rgba);
                double miss = miss_distance(&scene->views[v], x + 0.5, y + 0.5);
                if (fabs(miss - sphere_radius) < 1e-4) continue; // too close to call in single precision
                if ((miss < sphere_radius) != (rgba[0] > 0))
                    fail_msg("view %u, pixel %u %u: the ray misses the centre by %g but the pixel is %g", v, x, y, miss,
                             rgba[0]);
                *(miss < sphere_radius ? &inside : &outside) += 1;
            }
    assert_true(inside > 1000 && outside > 1000);
}

TEST(a_sphere_has_its_outline) {
    struct vw_scene *scene = draw(NULL, NULL, NULL, NULL);
    check_silhouette(scene);
}

TEST(a_distorted_lens_bends_the_sphere) {
    const char *lens =
        "\"field_of_view_deg\": 50, \"distortion\": {\"k1\": -0.3, \"k2\": 0.1, \"p1\": 0.02, \"p2\": -0.03}";
    struct vw_scene *scene = draw("\"field_of_view_deg\": 50", lens, NULL, NULL);
    check_silhouette(scene);
}

// Returns the signed distance of a point from the sphere; the functions below do so for the other shapes.
static double from_sphere(const double p[3]) {
    return sqrt(pow(p[0] - 0.2, 2) + pow(p[1] + 0.1, 2) + pow(p[2] - 0.3, 2)) - 0.5;
}
static double from_plane(const double p[3]) { return fmax(fabs(p[2] + 0.25), hypot(p[0], p[1]) - 0.9); }
static double from_box(const double p[3]) { // turned by 30 degrees
    double c = cos(M_PI / 6), s = sin(M_PI / 6);
    return fmax(fmax(fabs(c * p[0] + s * p[1]) - 0.3, fabs(c * p[1] - s * p[0]) - 0.5), fabs(p[2]) - 0.2);
}
static double from_cylinder(const double p[3]) { return fmax(hypot(p[0] - 0.1, p[1]) - 0.4, fabs(p[2] - 0.1) - 0.3); }

#define LIT_BACKGROUND                                                                                                 \
    "\"sun\": {\"direction\": [0.6, 0, 0.8], \"intensity\": 0.6, \"ambient\": 0.8}, \"background\": [0, 0, 0]"

// Checks that a point of a convex grey shape is as bright as its normal, the slope of the distance there, demands.
static void check_brightness(const struct vw_point *point, double (*distance)(const double p[3])) {
    double normal[3], length = 0;
    for (int i = 0; i < 3; i++) {
        double high[3], low[3];
        memcpy(high, point->position_world, sizeof high);
        memcpy(low, point->position_world, sizeof low);
        high[i] += 1e-4;
        low[i] -= 1e-4;
        normal[i] = (distance(high) - distance(low)) / 2e-4;
        length += normal[i] * normal[i];
    }
    if (fabs(length - 1) > 1e-2) return; // on an edge, or on the plane, which has two sides
    assert_near(point->rgb[0], 0.5 * (0.8 + 0.6 * fmax(0, 0.6 * normal[0] + 0.8 * normal[2])), 0.5 / 255 + 1e-3);
}

// Points are made from depths: they lie on the shape, on all its sides, and are lit as the side faces.
TEST(points_lie_on_the_shapes) {
    const struct {
        const char *shape;
        double (*distance)(const double p[3]);
    } cases[] = {
        {RECIPE_SPHERE, from_sphere},
        {"{\"kind\": \"plane\", \"centre\": [0, 0, -0.25], \"radius\": 0.9, \"texture\": " RECIPE_GREY "}", from_plane},
        {"{\"kind\": \"box\", \"centre\": [0, 0, 0], \"half_extent\": [0.3, 0.5, 0.2], \"turn_deg\": 30, "
         "\"texture\": " RECIPE_GREY "}",
         from_box},
        {"{\"kind\": \"cylinder\", \"centre\": [0.1, 0, 0.1], \"radius\": 0.4, \"height\": 0.6, "
         "\"texture\": " RECIPE_GREY "}",
         from_cylinder},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        struct vw_scene *scene = draw(RECIPE_SPHERE, cases[i].shape, "\"background\": [0, 0, 0]", LIT_BACKGROUND);
        assert_true(scene->point_count > 200);
        double highest = -1, lowest = 1;
        for (uint32_t p = 0; p < scene->point_count; p++) {
            const double *position = scene->points[p].position_world;
            assert_near(cases[i].distance(position), 0, 3e-6);
            check_brightness(&scene->points[p], cases[i].distance);
            highest = fmax(highest, position[2]);
            lowest = fmin(lowest, position[2]);
        }
        assert_true(cases[i].distance == from_plane || highest > lowest + 0.3);
    }
}

TEST(textures_differ) {
    const char *kinds[] = {"checker", "stripes", "noise"};
    for (size_t i = 0; i < VW_ARRAY_COUNT(kinds); i++) {
        AUTO_FREE char *texture = vw_format_text(
            "{\"kind\": \"%s\", \"colour\": [0.2, 0, 1], \"second_colour\": [0.8, 0, 1], \"cell\": 0.25}", kinds[i]);
        struct vw_scene *scene = draw(RECIPE_GREY, texture, NULL, NULL);
        uint32_t low = 0, high = 0, between = 0;
        for (uint32_t p = 0; p < scene->point_count; p++) {
            const float *rgb = scene->points[p].rgb;
            assert_true(rgb[1] == 0 && rgb[2] == 1 && rgb[0] > 0.199f && rgb[0] < 0.801f);
            *(rgb[0] < 0.3f ? &low : rgb[0] > 0.7f ? &high : &between) += 1;
        }
        assert_true(low > scene->point_count / 10 && high > scene->point_count / 10);
        assert_true(i == 2 ? between > scene->point_count / 10 : between == 0);
    }
}

TEST(a_recipe_renders_the_same_bits_twice) {
    struct vw_scene *first = own_recipe_open("courtyard", on_gpu()), *second = own_recipe_open("courtyard", on_gpu());
    assert_memory_equal(first->hash, second->hash, sizeof first->hash);
    for (uint32_t v = 0; v < first->view_count; v++)
        assert_memory_equal(first->views[v].sha256, second->views[v].sha256, sizeof first->views[v].sha256);
    assert_int_equal(first->point_count, second->point_count);
    assert_int_equal(first->track_count, second->track_count);
    assert_true(first->point_count > 2000);
}

// A scene a million units away looks the same.
TEST(a_scene_far_from_the_origin_looks_the_same) {
    const char *far_text = "\"centre\": [1000000.2, -2000000.1, 3000000.3], \"radius\": 0.5";
    AUTO_FREE char *moved = replaced(recipe_text, "\"centre\": [0.2, -0.1, 0.3], \"radius\": 0.5", far_text);
    AUTO_FREE char *boxed =
        replaced(moved, "\"centre\": [0, 0, 0], \"half_extent\"", "\"centre\": [1e6, -2e6, 3e6], \"half_extent\"");
    AUTO_FREE char *text =
        replaced(boxed, "\"centre\": [0, 0, 0], \"radius\": 3", "\"centre\": [1e6, -2e6, 3e6], \"radius\": 3");
    struct vw_scene *here = draw(NULL, NULL, NULL, NULL), *there = NULL;
    ASSERT_OK(open_text(text, on_gpu(), &there));
    test_own_scene(there);
    uint32_t different = 0;
    for (uint32_t v = 0; v < 24; v++) {
        const uint8_t *a = here->views[v].image.pixels, *b = there->views[v].image.pixels;
        for (uint32_t i = 0; i < 32 * 24 * 4; i++) different += a[i] != b[i];
    }
    if (different > 3 * 4) fail_msg("%u channel values differ", different); // only pixels on the rim may differ
}

// Checks that the pixels that differ from `clean` are a square of ten colours, each column of a single one.
static void check_striped_box(const struct vw_image *image, const uint8_t *clean, uint32_t side_px) {
    uint32_t columns = 0, changes = 0, last = 0;
    for (uint32_t x = 0; x < image->width_px; x++) {
        uint32_t first = 0, covered = 0;
        for (uint32_t y = 0; y < image->height_px; y++) {
            const uint8_t *pixel = (const uint8_t *)image->pixels + 4 * (y * image->width_px + x);
            if (!memcmp(pixel, clean, 4)) continue;
            uint32_t colour = pixel[0] | (uint32_t)pixel[1] << 8 | (uint32_t)pixel[2] << 16;
            if (covered++ == 0) first = colour;
            assert_int_equal(colour, first);
        }
        if (!covered) continue;
        changes += columns++ == 0 || first != last;
        last = first;
        assert_int_equal(covered, side_px);
    }
    assert_int_equal(columns, side_px);
    assert_int_equal(changes, 10);
}

// On a flat grey photo each defect can be measured.
TEST(defects_have_their_strength) {
    const char *defects = "\"defects\": [{\"kind\": \"noise\", \"strength\": 0.1, \"views\": [1]}, "
                          "{\"kind\": \"exposure\", \"strength\": 0.5, \"bias\": 0.1, \"views\": [2]}, "
                          "{\"kind\": \"occluder\", \"strength\": 0.4, \"views\": [3]}, "
                          "{\"kind\": \"striped_box\", \"strength\": 0.5, \"views\": [6]}, "
                          "{\"kind\": \"wrong_pose\", \"strength\": 10, \"views\": [5]}]";
    struct vw_scene *scene =
        draw("\"background\": [0, 0, 0]", "\"background\": [0.5, 0.5, 0.5]", "\"defects\": []", defects);
    struct vw_scene *clean = draw("\"background\": [0, 0, 0]", "\"background\": [0.5, 0.5, 0.5]", NULL, NULL);
    const uint32_t values = 32 * 24 * 4;
    double sum = 0, sum2 = 0;
    uint32_t covered = 0;
    for (uint32_t i = 0; i < values; i++) {
        uint8_t grey = ((const uint8_t *)clean->views[0].image.pixels)[0];
        if (i % 4 == 3) continue;
        double noise = (((const uint8_t *)scene->views[1].image.pixels)[i] - grey) / 255.0;
        sum += noise;
        sum2 += noise * noise;
        assert_near(((const uint8_t *)scene->views[2].image.pixels)[i], 255 * 0.35, 0.6);
        covered += i % 4 == 0 && ((const uint8_t *)scene->views[3].image.pixels)[i] != grey;
    }
    const double count = 32 * 24 * 3;
    assert_near(sum / count, 0, 0.1 * 4 / sqrt(count));
    assert_near(sqrt(sum2 / count), 0.1, 0.1 * 4 / sqrt(2 * count));
    assert_near(covered / (32.0 * 24), 0.4, 0.03);
    check_striped_box(&scene->views[6].image, clean->views[0].image.pixels, 16);
    for (uint32_t v = 0; v < 24; v++)
        if (v == 0 || (v > 3 && v != 6)) assert_memory_equal(scene->views[v].sha256, clean->views[v].sha256, 32);
}

// Exposure is not a defect: photos of a flat grey differ as its spreads say, in every split, and stay the same for a
// seed.
TEST(exposure_varies_by_view) {
    const char *grey = "\"background\": [0.5, 0.5, 0.5], \"exposure\": {\"gain\": 0.2, \"tint\": 0.05}";
    struct vw_scene *scene = draw("\"background\": [0, 0, 0]", grey, NULL, NULL),
                    *again = draw("\"background\": [0, 0, 0]", grey, NULL, NULL);
    double gains = 0, tints = 0;
    for (uint32_t v = 0; v < 24; v++) {
        const uint8_t *pixel = scene->views[v].image.pixels;
        double red = log(pixel[0] / 127.5), green = log(pixel[1] / 127.5), blue = log(pixel[2] / 127.5),
               gain = (red + green + blue) / 3;
        gains += gain * gain;
        tints += ((red - gain) * (red - gain) + (green - gain) * (green - gain) + (blue - gain) * (blue - gain)) / 2;
        assert_memory_equal(scene->views[v].sha256, again->views[v].sha256, 32);
        assert_string_equal(scene->views[v].ground_truth, "clean");
    }
    assert_near(sqrt(gains / 24), 0.2, 0.2 * 3 / sqrt(2 * 24.0));
    assert_near(sqrt(tints / 24), 0.05, 0.05 * 3 / sqrt(2 * 48.0));
}

// A blur keeps the light and, across the sphere's rim, lowers the steepest slope to that of a Gaussian's: 1 / (sd *
// sqrt(2 pi)).
TEST(blur_widens_edges) {
    const char *defects = "\"defects\": [{\"kind\": \"blur\", \"strength\": 2, \"views\": [6]}]";
    struct vw_scene *scene = draw("\"defects\": []", defects, NULL, NULL), *clean = draw(NULL, NULL, NULL, NULL);
    const uint8_t *blurred = scene->views[6].image.pixels, *sharp = clean->views[6].image.pixels;
    double blurred_sum = 0, sharp_sum = 0;
    int steepest = 0;
    for (uint32_t i = 0; i < 32 * 24; i++) {
        blurred_sum += blurred[4 * i];
        sharp_sum += sharp[4 * i];
        if (i % 32) steepest = (int)fmax(steepest, abs(blurred[4 * i] - blurred[4 * i - 4]));
    }
    assert_near(blurred_sum, sharp_sum, 0.03 * sharp_sum);
    assert_near(steepest, 128 / (2 * sqrt(2 * M_PI)), 4);
}

TEST(a_transparent_background_becomes_alpha) {
    struct vw_scene *scene = draw("\"background\": [0, 0, 0]", "\"background\": \"transparent\"",
                                  "\"samples_per_pixel\": 1", "\"samples_per_pixel\": 9");
    assert_true(scene->has_alpha && scene->views[0].image.has_alpha);
    assert_true(scene->background[0] == 1 && scene->background[1] == 1 && scene->background[2] == 1);
    uint32_t opaque = 0, partly = 0;
    for (uint32_t i = 0; i < 32 * 24; i++) {
        const uint8_t *p = (const uint8_t *)scene->views[0].image.pixels + 4 * i;
        assert_int_equal(p[0], p[3] ? 128 : 0); // straight: the colour of a rim pixel is not darkened
        opaque += p[3] == 255;
        partly += p[3] > 0 && p[3] < 255;
    }
    assert_true(opaque > 50 && partly > 10);
    scene = draw(NULL, NULL, NULL, NULL);
    assert_false(scene->has_alpha || scene->views[0].image.has_alpha);
}

// Tracks are where the true cameras see the points, in at least two views, and clean photos show the point's colour
// there.
TEST(tracks_end_at_the_points) {
    struct vw_scene *scene = own_recipe_open("courtyard", on_gpu());
    uint32_t compared = 0, alike = 0, tracks = 0;
    for (uint32_t p = 0; p < scene->point_count; p++) {
        const struct vw_point *point = &scene->points[p];
        assert_true(point->track_count >= 2);
        assert_int_equal(point->first_track, tracks); // in order, without gaps
        tracks += point->track_count;
        for (uint32_t t = 0; t < point->track_count; t++) {
            const struct vw_track *track = &scene->tracks[point->first_track + t];
            const struct vw_view *view = &scene->views[track->view];
            assert_string_not_equal(view->ground_truth, "wrong_pose");
            double camera[3] = {0}, x_px, y_px;
            for (int i = 0; i < 3; i++) {
                const double *row = view->camera_to_world[i];
                for (int j = 0; j < 3; j++) camera[j] += row[j] * (point->position_world[i] - row[3]);
            }
            assert_true(vw_camera_project(&view->camera, camera, &x_px, &y_px));
            assert_near(track->x_px, x_px, 0.01);
            assert_near(track->y_px, y_px, 0.01);
            if (strcmp(view->ground_truth, "clean")) continue;
            float rgba[4], difference = 0;
            pixel_of(scene, track->view, x_px, y_px, rgba);
            for (int c = 0; c < 3; c++) difference = fmaxf(difference, fabsf(rgba[c] - point->rgb[c]));
            compared++;
            alike += difference < 0.15f;
        }
    }
    assert_int_equal(tracks, scene->track_count);
    assert_true(compared > 10000);
    if (alike < 0.85 * compared) fail_msg("only %u of %u tracks show their point's colour", alike, compared);
}

// Points that an occluder or a shape hides are not seen.
TEST(hidden_points_have_no_track) {
    const char *defects = "\"defects\": [{\"kind\": \"occluder\", \"strength\": 0.95, \"views\": [3]}]";
    struct vw_scene *scene = draw("\"defects\": []", defects, NULL, NULL);
    uint32_t by_view[24] = {0};
    for (uint32_t p = 0; p < scene->point_count; p++)
        for (uint32_t t = 0; t < scene->points[p].track_count; t++) {
            const struct vw_track *track = &scene->tracks[scene->points[p].first_track + t];
            double facing = 0; // a sphere's point is seen from where its normal points
            for (int i = 0; i < 3; i++)
                facing += (scene->views[track->view].camera_to_world[i][3] - scene->points[p].position_world[i]) *
                          (scene->points[p].position_world[i] - sphere_centre[i]);
            by_view[track->view]++;
            assert_true(facing > -0.15);
        }
    assert_true(by_view[2] > 50);
    assert_true(by_view[3] * 5 < by_view[2]);
}

TEST_GROUP(NULL, test_gpu_close)
