// Baselines that need no retraining, against plain computations on small scenes: features, transport, and
// residuals of a field.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "image/image.h"
#include "lab/baselines.h"
#include "lab/methods/consistent_residual.h"
#include "lab/methods/optimal_transport.h"
#include "lab/methods/photo_features.h"
#include "lab/methods/photo_pixels.h"
#include "lab/methods/photo_sightings.h"
#include "support/draws.h"
#include "support/synthetic_scene.h"

enum { TRAIN = 8, VAL = 3, WIDTH_PX = 24, HEIGHT_PX = 18, POINTS = 60 };

static uint32_t photos[TRAIN];

static double draw(uint32_t a, uint32_t b) { return test_draw(7, a, b); }

static struct vw_scene *make_scene(void) {
    for (uint32_t i = 0; i < TRAIN; i++) photos[i] = i;
    return synthetic_scene(&(struct synthetic_scene_params){TRAIN, VAL, WIDTH_PX, HEIGHT_PX, 0, false, 0, 0});
}

// Adds random points near the origin, which all views look at: every view sees those in its photo, but train view 0
// only every third.
static void add_points(struct vw_scene *scene) {
    scene->points = vw_allocate(POINTS, sizeof *scene->points);
    scene->tracks = vw_allocate(POINTS * (TRAIN + VAL), sizeof *scene->tracks);
    for (uint32_t p = 0; p < POINTS; p++) {
        struct vw_point *point = &scene->points[scene->point_count++];
        point->first_track = scene->track_count;
        for (uint32_t i = 0; i < 3; i++) point->position_world[i] = 0.9 * draw(p, i);
        for (uint32_t v = 0; v < scene->view_count; v++) {
            double x_px, y_px;
            if (v == 0 && p % 3) continue;
            if (!vw_view_project(&scene->views[v], point->position_world, &x_px, &y_px, NULL)) continue;
            scene->tracks[scene->track_count++] = (struct vw_track){v, (float)x_px, (float)y_px};
            point->track_count++;
        }
    }
}

static double feature(const struct vw_photo_features *features, uint32_t photo, enum vw_feature which) {
    return vw_photo_feature(features, 0, photo, which);
}

static struct vw_photo_features measure(const struct vw_scene *scene) {
    struct vw_photo_features features = {0};
    ASSERT_OK(vw_photo_features_make(scene, photos, TRAIN, 1, &features));
    return features;
}

static double luminance(const struct vw_scene *scene, uint32_t view, uint32_t x_px, uint32_t y_px) {
    return vw_image_luminance(&scene->views[view].image, x_px, y_px, scene->background);
}

// ---- Pixels ---------------------------------------------------------------------------------------------------------

static void check_pixels(const struct vw_scene *scene, uint32_t view, const struct vw_photo_features *features) {
    static const double mask[3][3] = {{1, -2, 1}, {-2, 4, -2}, {1, -2, 1}};
    double sum = 0, squares = 0, laplacians = 0, laplacian_squares = 0, noise = 0, count = 0, pixels = 0;
    for (uint32_t y = 0; y < HEIGHT_PX; y++)
        for (uint32_t x = 0; x < WIDTH_PX; x++, pixels++) {
            double convolved = 0, laplacian = 0;
            sum += luminance(scene, view, x, y);
            squares += pow(luminance(scene, view, x, y), 2);
            if (!x || !y || x + 1 == WIDTH_PX || y + 1 == HEIGHT_PX) continue;
            for (uint32_t i = 0; i < 9; i++) {
                double near = luminance(scene, view, x + i % 3 - 1, y + i / 3 - 1);
                convolved += mask[i / 3][i % 3] * near;
                laplacian += i == 4 ? -4 * near : i % 2 ? near : 0;
            }
            noise += fabs(convolved);
            laplacians += laplacian;
            laplacian_squares += laplacian * laplacian;
            count++;
        }
    assert_near(feature(features, view, VW_FEATURE_BRIGHTNESS), sum / pixels, 1e-12);
    assert_near(feature(features, view, VW_FEATURE_CONTRAST), sqrt(squares / pixels - pow(sum / pixels, 2)), 1e-9);
    assert_near(feature(features, view, VW_FEATURE_SHARPNESS), laplacian_squares / count - pow(laplacians / count, 2),
                1e-12);
    assert_near(feature(features, view, VW_FEATURE_NOISE), sqrt(M_PI / 2) * noise / (6 * count), 1e-12);
}

static void change_pixels(struct vw_scene *scene, uint32_t view, double gain, double noise) {
    uint8_t *pixels = scene->views[view].image.pixels;
    for (uint32_t i = 0; i < WIDTH_PX * HEIGHT_PX * 4; i++)
        if (i % 4 != 3) pixels[i] = (uint8_t)fmin(fmax(gain * pixels[i] + 255 * noise * draw(i, view), 0), 255);
}

static void blur(struct vw_scene *scene, uint32_t view) {
    uint8_t *pixels = scene->views[view].image.pixels, *before = vw_allocate(WIDTH_PX * HEIGHT_PX, 4);
    memcpy(before, pixels, WIDTH_PX * HEIGHT_PX * 4);
    for (uint32_t y = 1; y + 1 < HEIGHT_PX; y++)
        for (uint32_t x = 1; x + 1 < WIDTH_PX; x++)
            for (uint32_t c = 0; c < 3; c++) {
                uint32_t sum = 0;
                for (uint32_t i = 0; i < 9; i++) sum += before[4 * ((y + i / 3 - 1) * WIDTH_PX + x + i % 3 - 1) + c];
                pixels[4 * (y * WIDTH_PX + x) + c] = (uint8_t)(sum / 9);
            }
    free(before);
}

TEST(pixels_are_measured) {
    struct vw_scene *scene = make_scene();
    for (uint32_t i = 0; i < TRAIN; i++) change_pixels(scene, i, 1, 0.02);
    AUTO(vw_photo_features_free) struct vw_photo_features sound = measure(scene);
    for (uint32_t i = 0; i < TRAIN; i++) check_pixels(scene, i, &sound);
    blur(scene, 1);
    change_pixels(scene, 2, 1, 0.2);
    change_pixels(scene, 3, 0.4, 0);
    AUTO(vw_photo_features_free) struct vw_photo_features bad = measure(scene);
    assert_true(feature(&bad, 1, VW_FEATURE_SHARPNESS) < 0.5 * feature(&sound, 1, VW_FEATURE_SHARPNESS));
    assert_true(feature(&bad, 1, VW_FEATURE_NOISE) < 0.5 * feature(&sound, 1, VW_FEATURE_NOISE));
    assert_true(feature(&bad, 2, VW_FEATURE_NOISE) > 3 * feature(&sound, 2, VW_FEATURE_NOISE));
    for (uint32_t i = 0; i < TRAIN; i++)
        assert_true(feature(&bad, 3, VW_FEATURE_EXPOSURE) >= feature(&bad, i, VW_FEATURE_EXPOSURE));
    assert_true(feature(&bad, 3, VW_FEATURE_EXPOSURE) > 0.1);
}

// Noise of a known size on grey, and thumbnails of one colour.
TEST(noise_has_its_size) {
    struct vw_scene *scene = synthetic_scene(&(struct synthetic_scene_params){TRAIN, VAL, 200, 150, 0, false, 0, 0});
    uint8_t *pixels = scene->views[0].image.pixels;
    struct vw_photo_pixels measured;
    for (uint32_t i = 0; i < 200 * 150; i++) { // four uniform numbers: nearly normal, standard deviation 20 / 255
        double value = 128;
        for (uint32_t j = 0; j < 4; j++) value += 20 * sqrt(3) / 2 * draw(i, j);
        for (uint32_t c = 0; c < 3; c++) pixels[4 * i + c] = (uint8_t)lrint(value);
    }
    ASSERT_OK(vw_photo_pixels_measure(scene, 0, &measured));
    assert_near(measured.luminance.noise, 20 / 255.0, 0.03 * 20 / 255);
    assert_near(measured.luminance.contrast, 20 / 255.0, 0.03 * 20 / 255);
    for (uint32_t i = 0; i < 200 * 150; i++) memcpy(pixels + 4 * i, (uint8_t[]){51, 102, i % 200 < 100 ? 0 : 255}, 3);
    ASSERT_OK(vw_photo_pixels_measure(scene, 0, &measured));
    for (uint32_t i = 0; i < VW_THUMBNAIL_VALUES / 3; i++) {
        assert_near(measured.thumbnail[3 * i], 0.2, 1e-6);
        assert_near(measured.thumbnail[3 * i + 1], 0.4, 1e-6);
        assert_near(measured.thumbnail[3 * i + 2], i % VW_THUMBNAIL_COLUMNS >= 4, 1e-6);
    }
}

// ---- Places ---------------------------------------------------------------------------------------------------------

// Checks the features of one photo that depend on the points, by counting.
static void check_sightings(const struct vw_scene *scene, uint32_t photo, const struct vw_photo_features *features) {
    double points = 0, overlap_train = 0, overlap_val = 0, coverage = 0, validated = 0;
    for (uint32_t p = 0; p < scene->point_count; p++) {
        double train = 0, val = 0, own = 0;
        for (uint32_t t = 0; t < scene->points[p].track_count; t++) {
            uint32_t view = scene->tracks[scene->points[p].first_track + t].view;
            train += view < TRAIN;
            val += view >= TRAIN;
            own += view == photo;
        }
        validated += val > 0;
        points += own;
        overlap_train += own * (train - 1) / (TRAIN - 1);
        overlap_val += own * val / VAL;
        if (own > 0 && val > 0) coverage += 1 / train;
    }
    assert_near(feature(features, photo, VW_FEATURE_SFM_POINTS), points, 0);
    assert_near(feature(features, photo, VW_FEATURE_OVERLAP_TRAIN), overlap_train / points, 1e-12);
    assert_near(feature(features, photo, VW_FEATURE_OVERLAP_VAL), overlap_val / points, 1e-12);
    assert_near(feature(features, photo, VW_FEATURE_SFM_COVERAGE), coverage / validated, 1e-12);
}

static void turn_about_z(struct vw_view *view, double angle) {
    for (int column = 0; column < 3; column++) {
        double x = view->camera_to_world[0][column], y = view->camera_to_world[1][column];
        view->camera_to_world[0][column] = cos(angle) * x - sin(angle) * y;
        view->camera_to_world[1][column] = sin(angle) * x + cos(angle) * y;
    }
}

TEST(points_are_shared) {
    struct vw_scene *scene = make_scene();
    add_points(scene);
    AUTO(vw_photo_features_free) struct vw_photo_features features = measure(scene);
    double covered = 0;
    for (uint32_t i = 0; i < TRAIN; i++) {
        check_sightings(scene, i, &features);
        covered += feature(&features, i, VW_FEATURE_SFM_COVERAGE);
        assert_near(feature(&features, i, VW_FEATURE_REPROJECTION_MEAN), 0, 1e-5); // tracks are floats
    }
    assert_near(covered, 1, 1e-12); // train views see all that validation views do
    vw_photo_features_free(&features);

    turn_about_z(&scene->views[4], 0.1); // a wrong pose: tracks stay where they were
    for (uint32_t t = 0; t < scene->track_count; t += 7) scene->tracks[t].x_px += 4;
    features = measure(scene);
    double focal_px = 1.2 * WIDTH_PX;
    assert_true(feature(&features, 4, VW_FEATURE_REPROJECTION_MEDIAN) > 0.7 * 0.1 * focal_px);
    assert_true(feature(&features, 4, VW_FEATURE_REPROJECTION_MEDIAN) < 2 * 0.1 * focal_px);
    for (uint32_t i = 1; i < TRAIN; i++) {
        if (i == 4) continue;
        assert_near(feature(&features, i, VW_FEATURE_REPROJECTION_MEDIAN), 0, 1e-5);
        assert_true(feature(&features, i, VW_FEATURE_REPROJECTION_MEAN) > 0.1);
    }
}

// A point that a file lists twice in a photo is one place; a photo without tracks sees nothing.
TEST(odd_tracks_are_taken) {
    struct vw_scene *scene = make_scene();
    add_points(scene);
    for (uint32_t p = 0, at = 0; p < scene->point_count; at += scene->points[p++].track_count)
        for (uint32_t t = at; t < at + scene->points[p].track_count; t++)
            if (scene->tracks[t].view == 5) scene->tracks[t].view = 6; // which lists it, too
    AUTO(vw_photo_features_free) struct vw_photo_features twice = measure(scene);
    assert_near(feature(&twice, 5, VW_FEATURE_SFM_POINTS), 0, 0);
    assert_near(feature(&twice, 5, VW_FEATURE_SFM_COVERAGE), 0, 0);
    assert_near(feature(&twice, 5, VW_FEATURE_OVERLAP_VAL), 0, 0);
    assert_true(isnan(feature(&twice, 5, VW_FEATURE_REPROJECTION_MEDIAN)));
    double sum = 0, places = 0;
    for (uint32_t p = 0; p < scene->point_count; p++) {
        bool sees[TRAIN + VAL] = {false};
        for (uint32_t t = 0; t < scene->points[p].track_count; t++)
            sees[scene->tracks[scene->points[p].first_track + t].view] = true;
        for (uint32_t i = 0; sees[6] && i < TRAIN; i++) sum += i != 6 && sees[i];
        places += sees[6];
    }
    assert_near(feature(&twice, 6, VW_FEATURE_OVERLAP_TRAIN), sum / places / (TRAIN - 1), 1e-12);
}

// Without points: a photo that looks away sees the least of what validation photos see, and is far from the others.
TEST(cameras_stand_in_for_points) {
    struct vw_scene *scene = make_scene();
    turn_about_z(&scene->views[2], M_PI);
    AUTO(vw_photo_features_free) struct vw_photo_features features = measure(scene);
    double covered = 0;
    for (uint32_t i = 0; i < TRAIN; i++) {
        covered += feature(&features, i, VW_FEATURE_SFM_COVERAGE);
        assert_near(feature(&features, i, VW_FEATURE_SFM_POINTS), 0, 0);
        if (i == 2) continue;
        assert_true(feature(&features, i, VW_FEATURE_NEAREST_ANGLE) < 60);
        assert_true(feature(&features, 2, VW_FEATURE_NEAREST_ANGLE) > 60);
        assert_true(feature(&features, 2, VW_FEATURE_NEAREST_RATIO) > feature(&features, i, VW_FEATURE_NEAREST_RATIO));
        assert_true(feature(&features, 2, VW_FEATURE_SFM_COVERAGE) < feature(&features, i, VW_FEATURE_SFM_COVERAGE));
        assert_true(feature(&features, 2, VW_FEATURE_OVERLAP_VAL) < feature(&features, i, VW_FEATURE_OVERLAP_VAL));
        assert_true(feature(&features, 2, VW_FEATURE_OVERLAP_TRAIN) < feature(&features, i, VW_FEATURE_OVERLAP_TRAIN));
    }
    assert_true(covered > 0.5 && covered <= 1 + 1e-12);
    vw_photo_features_free(&features);
    for (int i = 0; i < 3; i++) scene->views[5].camera_to_world[i][3] *= 5; // far from all validation photos
    features = measure(scene);
    for (uint32_t i = 0; i < TRAIN; i++)
        assert_true(i == 5 ||
                    feature(&features, 5, VW_FEATURE_TRANSPORT) > feature(&features, i, VW_FEATURE_TRANSPORT));
}

// ---- Steps ----------------------------------------------------------------------------------------------------------

TEST(steps_are_summed) {
    struct vw_scene *scene = make_scene();
    struct vw_photo_features features = {0};
    struct vw_step_record records[1 + 4 * TRAIN] = {
        {.view = VW_RECORD_UNTRAINED, .train_loss = NAN, .val_psnr = 10, .val_l1 = 0.5, .validated = true}};
    // Photo i has the losses (i + 1) e^(-epoch / 2), and each of its steps adds i dB; photo 7 has none that is finite.
    for (uint32_t s = 1; s <= 4 * TRAIN; s++) {
        uint32_t i = (s - 1) % TRAIN, epoch = (s - 1) / TRAIN;
        records[s] = (struct vw_step_record){.step = s,
                                             .epoch = epoch,
                                             .view = i,
                                             .train_loss = i == 7 ? NAN : (i + 1) * exp(-0.5 * epoch),
                                             .validated = true,
                                             .val_psnr = records[s - 1].val_psnr + i + (epoch ? 0 : 100),
                                             .val_l1 = records[s - 1].val_l1 - 0.001 * i};
    }
    ASSERT_OK(vw_photo_features_make(scene, photos, TRAIN, 2, &features));
    ASSERT_OK(vw_photo_features_add_run(&features, 1, photos, records, 1 + 4 * TRAIN));
    for (uint32_t i = 0; i < TRAIN; i++) {
        double first = (i + 1) * (1 + exp(-0.5)) / 2, late = (i + 1) * (exp(-1) + exp(-1.5)) / 2;
        double changes = (i + 1) * (1 - exp(-1.5)) / 3;
        assert_true(isnan(vw_photo_feature(&features, 0, i, VW_FEATURE_LOSS_LATE))); // a seed without its run
        assert_near(vw_photo_feature(&features, 1, i, VW_FEATURE_BRIGHTNESS),
                    vw_photo_feature(&features, 0, i, VW_FEATURE_BRIGHTNESS), 0);
        assert_near(vw_photo_feature(&features, 1, i, VW_FEATURE_CREDIT_PSNR), i, 1e-9);
        assert_near(vw_photo_feature(&features, 1, i, VW_FEATURE_CREDIT_L1), 0.001 * i, 1e-12);
        if (i == 7) continue;
        assert_near(vw_photo_feature(&features, 1, i, VW_FEATURE_LOSS_FIRST), first, 1e-12);
        assert_near(vw_photo_feature(&features, 1, i, VW_FEATURE_LOSS_LATE), late, 1e-12);
        assert_near(vw_photo_feature(&features, 1, i, VW_FEATURE_LOSS_LAST), (i + 1) * exp(-1.5), 1e-12);
        assert_near(vw_photo_feature(&features, 1, i, VW_FEATURE_LOSS_RELATIVE), (i + 1) / 4.0, 1e-12);
        assert_near(vw_photo_feature(&features, 1, i, VW_FEATURE_LOSS_SLOPE), -0.5, 1e-12);
        assert_near(vw_photo_feature(&features, 1, i, VW_FEATURE_LOSS_CHANGE), changes, 1e-12);
    }
    assert_true(isnan(vw_photo_feature(&features, 1, 7, VW_FEATURE_LOSS_LATE)));
    assert_true(isnan(vw_photo_feature(&features, 1, 7, VW_FEATURE_LOSS_RELATIVE)));
    vw_photo_features_free(&features);
}

// ---- Baselines ------------------------------------------------------------------------------------------------------

TEST(every_baseline_scores) {
    struct vw_scene *scene = make_scene();
    add_points(scene);
    AUTO(vw_photo_features_free) struct vw_photo_features features = measure(scene);
    const struct vw_baseline_input input = {scene, photos, &features, 0, 3};
    for (uint32_t b = 0; b < vw_baseline_count; b++) {
        const struct vw_baseline *baseline = &vw_baselines[b];
        double scores[TRAIN];
        assert_true(baseline->name[0] && baseline->meaning[0]);
        for (uint32_t other = 0; other < b; other++) assert_string_not_equal(baseline->name, vw_baselines[other].name);
        vw_baseline_score(baseline, &input, scores);
        for (uint32_t i = 0; i < TRAIN; i++) {
            if (!isfinite(scores[i])) fail_msg("%s has no score of photo %u", baseline->name, i);
            if (baseline->score) continue;
            assert_true(fabs(baseline->sign) == 1);
            if (vw_features[baseline->feature].of_run) assert_near(scores[i], 0, 0); // no step was taken
            else assert_near(scores[i], baseline->sign * feature(&features, i, baseline->feature), 0);
        }
    }
    for (uint32_t f = 0; f < VW_FEATURE_COUNT; f++)
        assert_true(vw_features[f].name && vw_features[f].unit && vw_features[f].meaning);
}

// ---- Transport ------------------------------------------------------------------------------------------------------

// The linear program by hand: masses 0.5, 0.3, 0.2 to 0.6, 0.25, 0.15. The best plan sends 0.5 from a to x; 0.1 from b
// to x, 0.05 to y and 0.15 to z; 0.2 from c to y: 5 pairs in a tree, so that the potentials are unique but for a
// constant. With g(x) = 0: f(a) = 1, f(b) = 4, g(y) = 2 - 4, g(z) = 1 - 4, f(c) = 1 + 2. The other pairs cost more than
// their potentials: ay 4 > -1, az 6 > -2, cx 5 > 3, cz 3 > 0.
TEST(transport_is_the_linear_program) {
    static const double costs[9] = {1, 4, 6, 4, 2, 1, 5, 1, 3};
    static const double from[3] = {0.5, 0.3, 0.2}, to[3] = {0.6, 0.25, 0.15};
    const double best = 0.5 * 1 + 0.1 * 4 + 0.05 * 2 + 0.15 * 1 + 0.2 * 1;
    const struct vw_transport transport = {costs, 3, 3, from, to, 0.005};
    double sources[3], targets[3], gradients[3], cost = 0;
    assert_true(vw_transport_solve(&transport, sources, targets));
    for (int i = 0; i < 3; i++) cost += from[i] * sources[i] + to[i] * targets[i];
    assert_near(cost, best, 0.02);
    assert_near(sources[1] - sources[0], 3, 0.05);
    assert_near(sources[2] - sources[0], 2, 0.05);
    assert_near(targets[1] - targets[0], -2, 0.05);
    assert_near(targets[2] - targets[0], -3, 0.05);
    for (int i = 0; i < 9; i++) assert_true(sources[i / 3] + targets[i % 3] <= costs[i] + 0.05);
    vw_transport_calibrate(sources, 3, gradients);
    assert_near(gradients[0], -2.5, 0.05);
    assert_near(gradients[1], 4 - 2, 0.05);
    assert_near(gradients[2], 3 - 2.5, 0.05);

    double plan[9], row[3] = {0}, column[3] = {0};
    const struct vw_transport warm = {costs, 3, 3, from, to, 1};
    assert_true(vw_transport_solve(&warm, sources, targets));
    for (int i = 0; i < 9; i++) {
        plan[i] = from[i / 3] * to[i % 3] * exp(sources[i / 3] + targets[i % 3] - costs[i]);
        row[i / 3] += plan[i];
        column[i % 3] += plan[i];
    }
    for (int i = 0; i < 3; i++) {
        assert_near(row[i], from[i], 1e-8);
        assert_near(column[i], to[i], 1e-8);
    }
    const struct vw_transport cold = {costs, 3, 3, from, to, 1e-7}; // the masses settle too slowly
    assert_false(vw_transport_solve(&cold, sources, targets));
}

// ---- Residuals ------------------------------------------------------------------------------------------------------

TEST(photos_that_disagree_are_found) {
    struct vw_scene *scene = make_scene();
    add_points(scene);
    struct vw_residuals residuals[TRAIN];
    double scores[TRAIN], values[TRAIN][WIDTH_PX * HEIGHT_PX];
    for (uint32_t i = 0; i < TRAIN; i++) {
        residuals[i] = (struct vw_residuals){WIDTH_PX, HEIGHT_PX, values[i]};
        for (uint32_t j = 0; j < WIDTH_PX * HEIGHT_PX; j++) values[i][j] = 0.05 + 0.01 * draw(j, i);
    }
    for (uint32_t j = 0; j < WIDTH_PX * HEIGHT_PX; j++) {
        if (j % WIDTH_PX < WIDTH_PX / 2) values[3][j] = 0.5; // a passer-by in the left half
        values[0][j] = 0.5;                                  // all of a photo that lists a third of the points
    }
    ASSERT_OK(vw_consistent_residual_score(scene, photos, TRAIN, residuals, scores));
    for (uint32_t i = 1; i < TRAIN; i++)
        if (i != 3) assert_near(scores[i], 0, 0);
    assert_true(scores[3] < -0.3 && scores[3] > -0.7);
    assert_true(scores[0] < -0.99);

    // The first fifth of the points, which no photo shows well, is not blamed on any photo; photo 1 alone misses the
    // last.
    for (uint32_t i = 0; i < TRAIN; i++)
        for (uint32_t j = 0; j < WIDTH_PX * HEIGHT_PX; j++) values[i][j] = 0.05 + 0.01 * draw(j, i);
    for (uint32_t t = 0; t < scene->track_count; t++) {
        const struct vw_track *track = &scene->tracks[t];
        bool first = t < scene->points[POINTS / 5].first_track, last = t >= scene->points[4 * POINTS / 5].first_track;
        if (first || (last && track->view == 1))
            if (track->view < TRAIN) values[track->view][(int)track->y_px * WIDTH_PX + (int)track->x_px] = 0.5;
    }
    ASSERT_OK(vw_consistent_residual_score(scene, photos, TRAIN, residuals, scores));
    assert_true(scores[1] < -0.15 && scores[1] > -0.3);
    for (uint32_t i = 2; i < TRAIN; i++) assert_near(scores[i], 0, 0.1);

    scene->point_count = scene->track_count = 0; // no other photo has a say
    for (uint32_t i = 0; i < TRAIN; i++)
        for (uint32_t j = 0; j < WIDTH_PX * HEIGHT_PX; j++)
            values[i][j] = i == 3 && j % WIDTH_PX < WIDTH_PX / 4 ? 0.5 : j % 5 ? 0.05 + 0.01 * draw(j, i) : NAN;
    ASSERT_OK(vw_consistent_residual_score(scene, photos, TRAIN, residuals, scores));
    for (uint32_t i = 0; i < TRAIN; i++) assert_near(scores[i], i == 3 ? -0.25 : 0, 0.05);
}
