// The exposures of photos, estimated from points: on scenes whose photos show points of known colours with known gains
// and biases; against a plain least-squares fit to these colours; and what takes no part.
#include "support/cmocka_test.h"

#include <pthread.h>

#include "base/memory.h"
#include "scene/builder.h"
#include "support/draws.h"
#include "support/exposed_scene.h"
#include "support/synthetic_scene.h"
#include "support/temporary_folder.h"
#include "support/tiny_scene.h"

static const struct vw_exposure *estimate(const struct vw_scene *scene) {
    const struct vw_exposure *exposures = NULL;
    ASSERT_OK(vw_scene_estimate_exposures(scene, &exposures));
    return exposures;
}

static void assert_same_bits(const struct vw_exposure *a, const struct vw_exposure *b, uint32_t views) {
    for (uint32_t v = 0; v < views; v++) {
        assert_memory_equal(a[v].gain, b[v].gain, sizeof a->gain);
        assert_memory_equal(a[v].bias, b[v].bias, sizeof a->bias);
        assert_int_equal(a[v].observation_count, b[v].observation_count);
        assert_memory_equal(&a[v].error_without, &b[v].error_without, sizeof(double));
        assert_memory_equal(&a[v].error_with, &b[v].error_with, sizeof(double));
        assert_memory_equal(&a[v].reduction_stderr, &b[v].reduction_stderr, sizeof(double));
    }
}

static void assert_unknown(const struct vw_exposure *exposure) {
    for (int c = 0; c < 3; c++) assert_true(exposure->gain[c] == 0 && exposure->bias[c] == 0);
    assert_int_equal(exposure->observation_count, 0);
    assert_true(isnan(exposure->error_without) && isnan(exposure->error_with) && isnan(exposure->reduction_stderr));
}

struct line {
    double gain, bias; // gain: beyond 1
};
typedef struct line wanted_line(const struct vw_scene *scene, uint32_t view, int channel);

// Returns the largest differences of gains and of biases of train views from those that a function gives.
struct apart {
    double gain, bias;
};
static struct apart compare(const struct vw_scene *scene, const struct vw_exposure *exposures, wanted_line *wanted) {
    struct apart most = {0};
    for (uint32_t v = 0; v < EXPOSED_TRAINS; v++)
        for (int c = 0; c < 3; c++) {
            struct line line = wanted(scene, v, c);
            most.gain = fmax(most.gain, fabs(exposures[v].gain[c] - line.gain));
            most.bias = fmax(most.bias, fabs(exposures[v].bias[c] - line.bias));
        }
    return most;
}

// ---- What is found --------------------------------------------------------------------------------------------------

// Fits a photo to the known colours by plain least squares with the ridges of the estimate.
static struct line fit_to_colours(const struct vw_scene *scene, uint32_t view, int channel) {
    const long double ridge = 0.1L, bias_pull = 0.1L;
    long double n = 0, l = 0, ll = 0, d = 0, ld = 0;
    for (uint32_t p = 0; p < scene->point_count; p++)
        for (uint32_t t = 0; t < scene->points[p].track_count; t++) {
            uint32_t track = scene->points[p].first_track + t;
            if (scene->tracks[track].view != view) continue;
            long double colour = exposed_colour(p, channel),
                        missing = exposed_track_pixel(scene, track)[channel] - colour;
            n++;
            l += colour;
            ll += colour * colour;
            d += missing;
            ld += colour * missing;
        }
    long double gains = ll + ridge, biases = n + ridge + bias_pull * n, determinant = gains * biases - l * l;
    return (struct line){(double)((ld * biases - l * d) / determinant), (double)((gains * d - l * ld) / determinant)};
}

static struct line gain_shown(const struct vw_scene *scene, uint32_t view, int channel) {
    (void)scene;
    return (struct line){exposed_gain(view, channel), 0};
}

static struct line both_shown(const struct vw_scene *scene, uint32_t view, int channel) {
    (void)scene;
    return (struct line){exposed_gain(view, channel), exposed_bias(view, channel)};
}

static struct line none_shown(const struct vw_scene *scene, uint32_t view, int channel) {
    (void)scene;
    (void)view;
    (void)channel;
    return (struct line){0, 0};
}

// Photos that show the colours by their gains, by gains and biases, and with noise; where each point is seen by all
// photos, or by some.
static const struct found_case {
    const char *name;
    struct exposed_scene_params params;
    wanted_line *shown;
    struct apart from_shown, from_fit; // most that may be
} found_cases[] = {
    // Ridges alone are between what is shown and what is found; a fit to known colours has the same.
    {"gains", {.gains = 1}, gain_shown, {0.002, 0.001}, {2e-5, 1e-5}},
    {"gains, seen by 3", {.gains = 1, .seen_by = 3}, gain_shown, {0.004, 0.002}, {0.002, 0.001}},
    // Colours are taken with the errors of photos.
    {"gains, seen by 2", {.gains = 1, .seen_by = 2}, gain_shown, {0.01, 0.003}, {0.006, 0.001}},
    // About half of a bias is taken for gain, by its pull, and colours with it.
    {"gains and biases", {.gains = 1, .biases = 1}, both_shown, {0.035, 0.013}, {0.02, 0.002}},
    {"gains and biases, seen by 3", {.gains = 1, .biases = 1, .seen_by = 3}, both_shown, {0.035, 0.013}, {0.02, 0.004}},
    // Noise of 0.01 in 600 pixels moves a gain by 0.0016.
    {"gains and noise", {.gains = 1, .noise = 0.01}, gain_shown, {0.006, 0.003}, {0.004, 0.002}},
    {"noise", {.noise = 0.01}, none_shown, {0.005, 0.002}, {0.003, 0.001}},
};

TEST_CASES(known_exposures_are_found, i, VW_ARRAY_COUNT(found_cases)) {
    const struct found_case *it = &found_cases[i];
    const struct vw_scene *scene = exposed_scene(it->params);
    const struct vw_exposure *exposures = estimate(scene);
    struct apart shown = compare(scene, exposures, it->shown), fit = compare(scene, exposures, fit_to_colours);
    if (!(shown.gain <= it->from_shown.gain && shown.bias <= it->from_shown.bias))
        fail_msg("%s: gains are off by up to %g, biases by %g", it->name, shown.gain, shown.bias);
    if (!(fit.gain <= it->from_fit.gain && fit.bias <= it->from_fit.bias))
        fail_msg("%s: gains are up to %g from those of a fit to known colours, biases %g", it->name, fit.gain,
                 fit.bias);
    for (uint32_t v = 0; v < EXPOSED_TRAINS; v++)
        assert_int_equal(exposures[v].observation_count,
                         it->params.seen_by ? EXPOSED_POINTS * it->params.seen_by / EXPOSED_TRAINS : EXPOSED_POINTS);
}

// The median photo is the measure: all of them in dimmer light have the same exposures. The ridge weighs more there.
TEST(dimming_all_photos_changes_nothing) {
    struct vw_scene *scene = exposed_scene((struct exposed_scene_params){.gains = 1}),
                    *dim = exposed_scene((struct exposed_scene_params){.gains = 1});
    for (uint32_t v = 0; v < EXPOSED_TRAINS; v++)
        for (uint32_t i = 0; i < 4 * EXPOSED_PIXELS; i++)
            if (i % 4 != 3) exposed_pixel(dim, v, 0, 0)[i] *= 0.7f;
    const struct vw_exposure *bright = estimate(scene), *exposures = estimate(dim);
    for (uint32_t v = 0; v < EXPOSED_TRAINS; v++)
        for (int c = 0; c < 3; c++) {
            assert_near(exposures[v].gain[c], bright[v].gain[c], 0.002);
            assert_near(exposures[v].bias[c], bright[v].bias[c], 0.001);
        }
}

// ---- Where photos are read ------------------------------------------------------------------------------------------

// Photo 1 shows the middle of what the others show, twice as large, in ramps along both axes: where a pixel's centre
// would be half a pixel away, that would be half a pixel of these and a quarter of those.
TEST(tracks_are_between_the_centres_of_pixels) {
    struct vw_scene *scene = exposed_scene((struct exposed_scene_params){0});
    for (uint32_t v = 0; v < EXPOSED_TRAINS; v++)
        for (uint32_t i = 0; i < EXPOSED_PIXELS; i++) {
            uint32_t x_px = i % EXPOSED_WIDTH_PX, y_px = i / EXPOSED_WIDTH_PX;
            double x = x_px + 0.5, y = y_px + 0.5;
            if (v == 1) x = 10 + x / 2, y = 8 + y / 2;
            float *pixel = exposed_pixel(scene, v, x_px, y_px);
            pixel[0] = (float)(0.1 + 0.02 * x);
            pixel[1] = (float)(0.1 + 0.02 * y);
            pixel[2] = (float)(0.3 + 0.01 * x - 0.005 * y);
        }
    for (uint32_t p = 0; p < scene->point_count; p++) {
        double x = 20 + 9 * test_draw(5, p, 0), y = 15 + 6 * test_draw(5, p, 1);
        for (uint32_t t = 0; t < EXPOSED_VIEWS; t++) {
            struct vw_track *track = &scene->tracks[scene->points[p].first_track + t];
            track->x_px = (float)(track->view == 1 ? 2 * (x - 10) : x);
            track->y_px = (float)(track->view == 1 ? 2 * (y - 8) : y);
        }
    }
    const struct vw_exposure *exposures = estimate(scene);
    for (uint32_t v = 0; v < EXPOSED_TRAINS; v++) {
        assert_int_equal(exposures[v].observation_count, EXPOSED_POINTS);
        assert_true(exposures[v].error_without < 1e-12); // floats; half a pixel's ramp would be 2.5e-5
        for (int c = 0; c < 3; c++) {
            assert_near(exposures[v].gain[c], 0, 1e-6);
            assert_near(exposures[v].bias[c], 0, 1e-6);
        }
    }
}

// ---- Evidence -------------------------------------------------------------------------------------------------------

// Averages what the others' mean is off by, over points and channels that a photo shows, times (n - 1) / n.
static double error_of_means(const struct vw_scene *scene, uint32_t view) {
    double sum = 0;
    for (uint32_t p = 0; p < scene->point_count; p++)
        for (int c = 0; c < 3; c++) {
            double others = 0, own = 0, n = EXPOSED_TRAINS;
            for (uint32_t t = 0; t < scene->points[p].track_count; t++) {
                uint32_t track = scene->points[p].first_track + t, seen_by = scene->tracks[track].view;
                float value = exposed_track_pixel(scene, track)[c];
                if (seen_by == view) own = value;
                else if (seen_by < EXPOSED_TRAINS) others += value / (n - 1);
            }
            sum += (n - 1) / n * (own - others) * (own - others) / (3 * scene->point_count);
        }
    return sum;
}

TEST(errors_are_those_of_what_other_photos_predict) {
    const double noise = 0.01;
    const struct vw_scene *scene =
        exposed_scene((struct exposed_scene_params){.gains = 1, .biases = 1, .noise = noise});
    const struct vw_exposure *exposures = estimate(scene);
    for (uint32_t v = 0; v < EXPOSED_TRAINS; v++) {
        double without = error_of_means(scene, v);
        // The estimate's means weigh photos that are far off by less.
        assert_near(exposures[v].error_without, without, 0.2 * without);
        // Observations beyond 3 spreads are left out, which takes a tenth of the noise's square.
        assert_near(exposures[v].error_with, noise * noise, 0.2 * noise * noise);
        assert_true(exposures[v].error_without - exposures[v].error_with > 10 * exposures[v].reduction_stderr);
    }
}

// Exposures take nothing off the error of photos that agree.
TEST(photos_that_agree_are_no_evidence) {
    for (uint32_t seen_by = 2; seen_by <= EXPOSED_TRAINS; seen_by++) {
        const struct vw_scene *scene =
            exposed_scene((struct exposed_scene_params){.noise = 0.01, .seen_by = seen_by % EXPOSED_TRAINS});
        const struct vw_exposure *exposures = estimate(scene);
        for (uint32_t v = 0; v < EXPOSED_TRAINS; v++) {
            double reduction = exposures[v].error_without - exposures[v].error_with;
            assert_true(fabs(reduction) < 0.1 * exposures[v].error_without);
            assert_true(exposures[v].reduction_stderr > 0 && reduction < 2 * exposures[v].reduction_stderr);
        }
    }
}

// ---- What takes no part ---------------------------------------------------------------------------------------------

enum { SOUND, MASKED, HIDDEN, TRANSPARENT, SATURATED, BLACK, WAYS };

static uint32_t way_of(uint32_t view, uint32_t pixel) {
    uint32_t kind = (7 * pixel + 13 * view) % 41;
    return kind < WAYS ? kind : SOUND;
}

static void spoil_pixels(struct vw_scene *scene) {
    for (uint32_t v = 0; v < EXPOSED_TRAINS; v++) {
        struct vw_view *view = &scene->views[v];
        view->mask = vw_allocate(EXPOSED_PIXELS, 1);
        view->image.unusable = vw_allocate(EXPOSED_PIXELS, 1);
        view->has_mask = view->image.has_alpha = true;
        for (uint32_t i = 0; i < EXPOSED_PIXELS; i++) {
            uint32_t way = way_of(v, i);
            float *pixel = exposed_pixel(scene, v, 0, 0) + 4 * i;
            view->mask[i] = way == MASKED ? VW_MASK_HIDE : VW_MASK_KEEP;
            view->image.unusable[i] = way == HIDDEN;
            for (int c = 0; c < 3 && way; c++) pixel[c] = way == SATURATED ? 1.0f : way == BLACK ? 0.0f : 0.9f;
            if (way == TRANSPARENT) pixel[3] = 0.75f;
        }
    }
}

static bool is_sound(const struct vw_track *track) {
    uint32_t first = (uint32_t)track->y_px * EXPOSED_WIDTH_PX + (uint32_t)track->x_px, view = track->view;
    return view >= EXPOSED_TRAINS ||
           !(way_of(view, first) || way_of(view, first + 1) || way_of(view, first + EXPOSED_WIDTH_PX) ||
             way_of(view, first + EXPOSED_WIDTH_PX + 1));
}

static void remove_tracks_beside_spoilt_pixels(struct vw_scene *scene) {
    uint32_t kept = 0;
    for (uint32_t p = 0; p < scene->point_count; p++) {
        struct vw_point *point = &scene->points[p];
        uint32_t first = point->first_track, end = first + point->track_count;
        point->first_track = kept;
        for (uint32_t t = first; t < end; t++)
            if (is_sound(&scene->tracks[t])) scene->tracks[kept++] = scene->tracks[t];
        point->track_count = kept - point->first_track;
    }
    assert_in_range(kept, scene->track_count / 3, scene->track_count - 500);
    scene->track_count = kept;
}

TEST(pixels_that_tell_nothing_take_no_part) {
    const struct exposed_scene_params params = {.gains = 1, .biases = 1, .noise = 0.01};
    struct vw_scene *spoilt = exposed_scene(params), *without = exposed_scene(params);
    spoil_pixels(spoilt);
    remove_tracks_beside_spoilt_pixels(without);
    const struct vw_exposure *exposures = estimate(spoilt);
    assert_same_bits(exposures, estimate(without), EXPOSED_VIEWS);
    assert_in_range(exposures[0].observation_count, EXPOSED_POINTS / 4, EXPOSED_POINTS - 50);
}

// The other channels of its pixel count.
TEST(a_saturated_channel_takes_no_part) {
    struct vw_scene *scene = exposed_scene((struct exposed_scene_params){.gains = 1}),
                    *whole = exposed_scene((struct exposed_scene_params){.gains = 1});
    for (uint32_t t = 0; t < scene->track_count; t += 5)
        if (scene->tracks[t].view < EXPOSED_TRAINS) exposed_track_pixel(scene, t)[0] = 1.0f;
    const struct vw_exposure *exposures = estimate(scene), *expected = estimate(whole);
    for (uint32_t v = 0; v < EXPOSED_TRAINS; v++) {
        assert_true(exposures[v].observation_count < 0.7 * expected[v].observation_count);
        assert_near(exposures[v].gain[0], exposed_gain(v, 0), 0.004); // the ridge weighs more
        for (int c = 1; c < 3; c++) assert_near(exposures[v].gain[c], expected[v].gain[c], 0.004);
    }
}

// A walk around something: each photo shares points with its neighbours alone, and gains drift slowly. Errors of
// neighbours are small whatever the drift, so that steps of one photo at a time would take thousands.
TEST(a_slow_drift_is_found) {
    enum { VIEWS = 60, SEEN_BY = 6, POINTS = 40 * VIEWS };
    struct vw_scene *scene = synthetic_scene(&(struct synthetic_scene_params){
        .train_views = VIEWS, .width_px = EXPOSED_WIDTH_PX, .height_px = EXPOSED_HEIGHT_PX});
    scene->points = vw_allocate(POINTS, sizeof *scene->points);
    scene->tracks = vw_allocate(POINTS * SEEN_BY, sizeof *scene->tracks);
    scene->point_count = POINTS;
    for (uint32_t p = 0; p < POINTS; p++) {
        scene->points[p] = (struct vw_point){.first_track = scene->track_count, .track_count = SEEN_BY};
        for (uint32_t k = 0; k < SEEN_BY; k++) {
            uint32_t view = (p + k) % VIEWS, place = p / VIEWS * SEEN_BY + k, x_px = 2 * (place % 18),
                     y_px = 2 * (place / 18);
            double gain = 1 + 0.25 * sin(2 * M_PI * view / VIEWS);
            scene->tracks[scene->track_count++] = (struct vw_track){view, (float)x_px + 0.5f, (float)y_px + 0.5f};
            uint8_t *pixel = (uint8_t *)scene->views[view].image.pixels + 4 * (y_px * EXPOSED_WIDTH_PX + x_px);
            for (int c = 0; c < 3; c++)
                pixel[c] = (uint8_t)lrint(255 * (gain * (0.45 + 0.2 * test_draw(9, p, (uint32_t)c)) +
                                                 0.005 * test_normal(9, SEEN_BY * p + k, 3 + (uint32_t)c)));
        }
    }
    const struct vw_exposure *exposures = estimate(scene);
    double products = 0, squares = 0;
    for (uint32_t v = 0; v < VIEWS; v++) {
        double truth = 0.25 * sin(2 * M_PI * v / VIEWS);
        products += truth * exposures[v].gain[0];
        squares += truth * truth;
    }
    print_message("%.3f of the drift\n", products / squares);
    assert_true(products / squares > 0.9 && products / squares < 1.02);
}

// A tenth of the observations show something else.
TEST(outliers_barely_move_exposures) {
    const struct exposed_scene_params params = {.gains = 1, .noise = 0.005};
    struct vw_scene *scene = exposed_scene(params), *clean = exposed_scene(params);
    for (uint32_t t = 0; t < scene->track_count; t++)
        for (uint32_t c = 0; c < 3 && test_draw(6, t, 3) < -0.8; c++)
            exposed_track_pixel(scene, t)[c] = (float)(0.5 + 0.45 * test_draw(6, t, c));
    const struct vw_exposure *exposures = estimate(scene), *expected = estimate(clean);
    struct apart apart = {0};
    for (uint32_t v = 0; v < EXPOSED_TRAINS; v++)
        for (int c = 0; c < 3; c++) {
            apart.gain = fmax(apart.gain, fabs(exposures[v].gain[c] - expected[v].gain[c]));
            apart.bias = fmax(apart.bias, fabs(exposures[v].bias[c] - expected[v].bias[c]));
        }
    struct apart squares = compare(scene, expected, fit_to_colours); // which outliers move as they weigh
    assert_true(apart.gain < 0.005 && apart.bias < 0.0015);
    assert_true(squares.gain > 10 * apart.gain && squares.bias > 10 * apart.bias);
}

// A photo that sees a point twice has one observation of it, the first.
TEST(a_point_counts_once_per_photo) {
    const struct exposed_scene_params params = {.gains = 1, .biases = 1, .noise = 0.01};
    struct vw_scene *twice = exposed_scene(params);
    struct vw_track *tracks = vw_allocate(2 * twice->track_count, sizeof *tracks);
    for (uint32_t p = 0; p < twice->point_count; p++) {
        struct vw_point *point = &twice->points[p];
        for (uint32_t t = 0; t < point->track_count; t++) {
            const struct vw_track *track = &twice->tracks[point->first_track + t];
            tracks[2 * (point->first_track + t)] = *track;
            tracks[2 * (point->first_track + t) + 1] = (struct vw_track){track->view, 3.0f, 4.0f};
        }
        point->first_track *= 2;
        point->track_count *= 2;
    }
    free(twice->tracks);
    twice->tracks = tracks;
    twice->track_count *= 2;
    assert_same_bits(estimate(twice), estimate(exposed_scene(params)), EXPOSED_VIEWS);
}

// Points tell exposures if at least half of the train photos, here three of five, share eight of them.
TEST(points_tell_where_half_of_the_photos_share_eight) {
    static const struct {
        uint32_t points, views[4], view_count;
        bool tells;
        uint32_t later; // by so much is a view of a point later, for every eight points
    } cases[] = {
        {8, {0, 1, 2}, 3, true},
        {7, {0, 1, 2}, 3, false},                 // a point too few
        {8, {0, 1}, 2, false},                    // a photo too few
        {8, {0, 1, EXPOSED_TRAINS}, 3, false},    // one that validates
        {8, {0, 0, 1, 1}, 4, false},              // seen twice by each
        {4, {0, 1, 2, 2}, 4, false},              // seen twice by one
        {8, {0, EXPOSED_TRAINS, 0, 1}, 1, false}, // seen by one
        {32, {0, 1}, 2, true, 1},                 // each shares with the next
        {32, {0, 0}, 2, false, 1},                // each sees its own twice
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        struct vw_scene *scene = exposed_scene((struct exposed_scene_params){0});
        scene->point_count = cases[i].points;
        for (uint32_t p = 0; p < cases[i].points; p++) {
            scene->points[p].track_count = cases[i].view_count;
            for (uint32_t t = 0; t < cases[i].view_count; t++)
                scene->tracks[scene->points[p].first_track + t].view = cases[i].views[t] + p / 8 * cases[i].later;
        }
        ASSERT_OK(vw_scene_prepare_exposures(scene));
        if (scene->points_tell_exposures != cases[i].tells) fail_msg("case %zu", i);
    }
}

TEST(only_train_photos_take_part) {
    const struct exposed_scene_params params = {.gains = 1, .biases = 1, .noise = 0.01};
    struct vw_scene *scene = exposed_scene(params), *other = exposed_scene(params);
    for (uint32_t i = 0; i < 4 * EXPOSED_PIXELS; i++)
        for (uint32_t v = EXPOSED_TRAINS; v < EXPOSED_VIEWS; v++)
            if (i % 4 != 3) exposed_pixel(other, v, 0, 0)[i] *= 0.3f;
    other->views[EXPOSED_VIEWS - 1].split = VW_SPLIT_EXCLUDED;
    const struct vw_exposure *exposures = estimate(scene);
    assert_same_bits(exposures, estimate(other), EXPOSED_VIEWS);
    for (uint32_t v = EXPOSED_TRAINS; v < EXPOSED_VIEWS; v++) assert_unknown(&exposures[v]);
}

TEST(a_photo_with_few_observations_stays_as_it_is) {
    for (uint32_t count = 7; count <= 8; count++) {
        struct vw_scene *scene = exposed_scene((struct exposed_scene_params){.gains = 1});
        for (uint32_t t = 0, left = count; t < scene->track_count; t++) {
            if (scene->tracks[t].view != 1) continue;
            if (left) left--;
            else exposed_track_pixel(scene, t)[3] = 0.0f;
        }
        const struct vw_exposure *photo = &estimate(scene)[1];
        assert_int_equal(photo->observation_count, count);
        for (int c = 0; c < 3; c++) {
            double shown = 0.5 * photo->gain[c] + photo->bias[c], expected = 0.5 * exposed_gain(1, c);
            if (count == 7) assert_true(photo->gain[c] == 0 && photo->bias[c] == 0);
            else assert_near(shown, expected, 0.5 * fabs(expected)); // the ridge weighs much beside so few
        }
    }
}

TEST(without_shared_points_nothing_is_known) {
    struct vw_scene *bare = synthetic_scene(
        &(struct synthetic_scene_params){.train_views = 4, .val_views = 1, .width_px = 8, .height_px = 6});
    struct vw_scene *apart = exposed_scene((struct exposed_scene_params){.gains = 1, .seen_by = 1});
    const struct vw_exposure *exposures[2] = {estimate(bare), estimate(apart)};
    for (uint32_t v = 0; v < bare->view_count; v++) assert_unknown(&exposures[0][v]);
    for (uint32_t v = 0; v < apart->view_count; v++) assert_unknown(&exposures[1][v]);
}

// ---- One estimate ---------------------------------------------------------------------------------------------------

static void *estimate_in_thread(void *scene) {
    const struct vw_exposure *exposures = NULL;
    return vw_scene_estimate_exposures(scene, &exposures) ? NULL : (void *)(uintptr_t)exposures;
}

TEST(all_calls_give_one_estimate) {
    enum { THREADS = 4 };
    const struct exposed_scene_params params = {.gains = 1, .biases = 1, .noise = 0.01};
    struct vw_scene *scene = exposed_scene(params), *alike = exposed_scene(params);
    pthread_t threads[THREADS];
    void *found[THREADS];
    for (int i = 0; i < THREADS; i++) assert_int_equal(pthread_create(&threads[i], NULL, estimate_in_thread, scene), 0);
    for (int i = 0; i < THREADS; i++) assert_int_equal(pthread_join(threads[i], &found[i]), 0);
    for (int i = 0; i < THREADS; i++) assert_ptr_equal(found[i], estimate(scene));
    assert_same_bits(estimate(scene), estimate(alike), EXPOSED_VIEWS);
}

// Photos on disk, of one colour each, brighter from one to the next, are decoded by the first call, if they train.
FOLDER_TEST(photos_that_train_are_decoded) {
    enum { POINTS = 30 };
    const struct vw_exposure *exposures[2];
    tiny_scene_write(*state, &(struct tiny_scene){.count = 8});
    for (int i = 0; i < 2; i++) {
        struct vw_scene *scene = tiny_scene_open(SCENE_PARAMS(.path = *state));
        scene->points = vw_allocate(POINTS, sizeof *scene->points);
        scene->tracks = vw_allocate(POINTS * scene->view_count, sizeof *scene->tracks);
        for (; scene->point_count < POINTS; scene->point_count++) {
            scene->points[scene->point_count] =
                (struct vw_point){.first_track = scene->track_count, .track_count = scene->view_count};
            for (uint32_t v = 0; v < scene->view_count; v++)
                scene->tracks[scene->track_count++] =
                    (struct vw_track){v, 1.0f + 0.2f * (float)scene->point_count, 3.0f};
        }
        exposures[i] = estimate(scene);
        for (uint32_t v = 0; v < scene->view_count; v++) {
            bool trains = scene->views[v].split == VW_SPLIT_TRAIN;
            assert_int_equal(scene->views[v].image.pixels != NULL, trains);
            assert_int_equal(exposures[i][v].observation_count, trains ? POINTS : 0);
            if (trains) assert_true(exposures[i][v].error_with < 0.01 * exposures[i][v].error_without);
        }
    }
    assert_same_bits(exposures[0], exposures[1], 8);
    assert_true(exposures[0][1].gain[0] < exposures[0][3].gain[0] && exposures[0][5].gain[0] < exposures[0][7].gain[0]);
}
