// The gains of effects in whole trainings on photos that call for them, beside the same trainings without: the
// validation PSNR that it gains, and whether its params say of the photos what is true. Each effect with params has a
// row.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "base/random.h"
#include "gpu/compute.h"
#include "image/image.h"
#include "reference/effects/pose.h"
#include "reference/step_bench.h"
#include "scene/features.h"
#include "support/feature_file.h"
#include "support/temporary_folder.h"
#include "support/tiny_scene.h"
#include "support/trainer_fixture.h"
#include "train/effects/registry.h"

struct learning {
    const char *effect;
    enum vw_field field;
    struct vw_scene *(*open)(void);
    uint32_t epochs, rays, levels; // rays, levels: 0 as test_config_of()
    uint32_t last;                 // steps at the end whose PSNR is averaged
    double gain_db;                // least gain over the training without the effect; NAN: no such training
    // A measure of the params, and the most or least that it may be; NULL: none.
    double (*measure)(const struct vw_scene *scene, const struct vw_trainer *trainer, const float *params);
    double least, most;
};

static struct vw_scene *open_recipe(const char *name, uint32_t downscale) {
    return own_recipe_open(name, (struct vw_scene_params){.gpu = test_gpu(), .downscale = downscale});
}

static struct vw_scene *open_sky(void) { return open_recipe("sky", 2); }
static struct vw_scene *open_exposure(void) { return open_recipe("exposure", 2); }

// ---- Boxes before the scene -----------------------------------------------------------------------------------------

// Returns whether a box hides the pixel: every train photo has one of its own colour, a third of it wide and high.
static bool is_hidden(const struct vw_image *image, uint32_t view, uint32_t x_px, uint32_t y_px) {
    uint32_t left = (view * 7 % 3) * image->width_px / 3, top = (view * 5 % 3) * image->height_px / 3;
    return x_px >= left && x_px < left + image->width_px / 3 && y_px >= top && y_px < top + image->height_px / 3;
}

static struct vw_scene *hide(struct vw_scene *scene) {
    for (uint32_t view = 0; view < scene->view_count; view++) {
        const struct vw_image *image = &scene->views[view].image;
        uint32_t words[4];
        uint8_t colour[3];
        vw_random_words(7, VW_RANDOM_RECIPE, 0, view, 0, words);
        for (int c = 0; c < 3; c++) colour[c] = words[c] % 2 ? 250 : 5; // brighter or darker than the scene
        for (uint32_t i = 0; i < image->width_px * image->height_px && scene->views[view].split == VW_SPLIT_TRAIN; i++)
            if (is_hidden(image, view, i % image->width_px, i / image->width_px))
                memcpy((uint8_t *)image->pixels + 4 * i, colour, sizeof colour);
    }
    return scene;
}

static struct vw_scene *open_hidden(void) { return hide(open_recipe("clean", 2)); }

static void remove_folder(void *folder) { temporary_folder_remove(folder); }

// Makes a grey scene whose boxes have colours that are as dark, and maps of half the resolution that tell them.
static struct vw_scene *open_maps(void) {
    enum { PHOTOS = 8, WIDTH = 24, HEIGHT = 18 };
    char *folder = test_own(temporary_folder_create(), remove_folder);
    tiny_scene_write(folder, &(struct tiny_scene){0});
    temporary_file(folder, "features/none", "");
    for (uint32_t view = 0; view < PHOTOS; view++) {
        float pixels[HEIGHT * WIDTH * 3], map[HEIGHT / 2 * WIDTH / 2];
        const struct vw_image size = {.width_px = WIDTH, .height_px = HEIGHT};
        char photo[32], features[32];
        for (uint32_t i = 0; i < HEIGHT * WIDTH; i++)
            for (uint32_t c = 0; c < 3; c++)
                pixels[3 * i + c] = is_hidden(&size, view, i % WIDTH, i / WIDTH) ? (c == view % 3 ? 0.9f : 0.1f) : 0.4f;
        for (uint32_t i = 0; i < HEIGHT / 2 * WIDTH / 2; i++)
            map[i] = is_hidden(&size, view, 2 * (i % (WIDTH / 2)), 2 * (i / (WIDTH / 2))) ? 100.0f : 97.0f;
        snprintf(photo, sizeof photo, "images/%02u.png", view);
        snprintf(features, sizeof features, "features/%02u.npy", view);
        ASSERT_OK(vw_image_save(temporary_path(folder, photo), WIDTH, HEIGHT, 3, pixels));
        test_write_features(temporary_path(folder, features), WIDTH / 2, HEIGHT / 2, 1, map);
    }
    return tiny_scene_open(SCENE_PARAMS(.path = folder));
}

// Returns how much a pixel of a photo counts, by the params.
static double weight_at(const struct vw_scene *scene, const struct reference_params *params, uint32_t view,
                        uint32_t x_px, uint32_t y_px) {
    const struct vw_image *image = &scene->views[view].image;
    const double place[2] = {(2.0 * x_px + 1.0) / image->width_px - 1.0, (2.0 * y_px + 1.0) / image->height_px - 1.0};
    float numbers[VW_FEATURES];
    double inputs[REFERENCE_FEATURES];
    if (!params->uncertainty) return reference_visibility(params->visibility, params->visibility_codes[view], place);
    vw_features_at(scene, view, (float)x_px + 0.5f, (float)y_px + 0.5f, numbers);
    for (uint32_t k = 0; k < VW_FEATURES; k++) inputs[k] = numbers[k];
    inputs[VW_FEATURES] = 1.0;
    return reference_certainty(params->uncertainty, inputs);
}

// Returns the probability that a pixel of a box counts less than one beside it, over all train photos.
static double find_auc(const struct vw_scene *scene, const struct vw_trainer *trainer, const float *params) {
    struct reference_params *reference = reference_params_create(&trainer->model, params);
    enum { BINS = 4096 };
    double counts[2][BINS] = {{0}}, totals[2] = {0}, above = 0.0, below = 0.0;
    for (uint32_t view = 0; view < scene->view_count; view++) {
        const struct vw_image *image = &scene->views[view].image;
        for (uint32_t i = 0; i < image->width_px * image->height_px && scene->views[view].split == VW_SPLIT_TRAIN;
             i++) {
            uint32_t x_px = i % image->width_px, y_px = i / image->width_px,
                     bin = (uint32_t)(weight_at(scene, reference, view, x_px, y_px) * (BINS - 1));
            bool hidden = is_hidden(image, view, x_px, y_px);
            counts[hidden][bin]++;
            totals[hidden]++;
        }
    }
    for (uint32_t bin = 0; bin < BINS; bin++) {
        above += counts[0][bin] * (below + counts[1][bin] / 2.0);
        below += counts[1][bin];
    }
    return above / totals[0] / totals[1];
}

// ---- Wrong cameras --------------------------------------------------------------------------------------------------

static struct vw_view *true_views;

// Moves the cameras of train photos by about a degree, and a hundredth of the box.
static struct vw_scene *open_moved(void) {
    struct vw_scene *scene = open_recipe("clean", 1);
    true_views = test_allocate(scene->view_count, sizeof *true_views);
    for (uint32_t view = 0; view < scene->view_count; view++) {
        double error[REFERENCE_POSE];
        true_views[view] = scene->views[view];
        for (int i = 0; i < REFERENCE_POSE; i++) error[i] = (i < 3 ? 0.01 : 0.02) * sin(1.0 + 2.3 * view + 1.7 * i);
        if (scene->views[view].split == VW_SPLIT_TRAIN)
            scene->views[view] = reference_pose_apply(&scene->views[view], &scene->box, error);
    }
    return scene;
}

// Returns how far off is what a camera sees at the distance of a box edge, in box edges.
static double error_of_camera(const struct vw_scene *scene, uint32_t view, const double pose[REFERENCE_POSE]) {
    struct vw_view found = reference_pose_apply(&scene->views[view], &scene->box, pose);
    double off2 = 0.0, edge_world = 2.0 * scene->box.half_extent_world;
    for (int i = 0; i < 3; i++)
        off2 += pow((found.camera_to_world[i][3] - true_views[view].camera_to_world[i][3]) / edge_world -
                        (found.camera_to_world[i][2] - true_views[view].camera_to_world[i][2]),
                    2.0);
    return sqrt(off2);
}

// Returns the errors of the cameras as a share of what they were, and checks what a run tells of the corrections: turns
// are 2 atan(half their length).
static double find_camera_errors(const struct vw_scene *scene, const struct vw_trainer *trainer, const float *params) {
    static const double none[REFERENCE_POSE];
    struct vw_camera_corrections told, expected = {0};
    uint32_t photos = scene->split_count[VW_SPLIT_TRAIN];
    double before = 0.0, after = 0.0;
    for (uint32_t view = 0; view < scene->view_count; view++) {
        double pose[REFERENCE_POSE];
        if (scene->views[view].split != VW_SPLIT_TRAIN) continue;
        reference_pose_of(&trainer->model, params, view, pose);
        double edges = sqrt(pose[0] * pose[0] + pose[1] * pose[1] + pose[2] * pose[2]),
               half = 0.5 * sqrt(pose[3] * pose[3] + pose[4] * pose[4] + pose[5] * pose[5]),
               deg = 2.0 * atan(half) * 180.0 / M_PI;
        before += error_of_camera(scene, view, none);
        after += error_of_camera(scene, view, pose);
        expected.mean_edges += edges / photos;
        expected.mean_deg += deg / photos;
        expected.largest_edges = fmax(expected.largest_edges, edges);
        expected.largest_deg = fmax(expected.largest_deg, deg);
    }
    ASSERT_OK(vw_trainer_camera_corrections(trainer, &told));
    assert_true(expected.mean_deg > 0.1 && expected.mean_edges > 1e-3);
    check_value("what a run tells", "mean_deg", 0, told.mean_deg, expected.mean_deg, 1e-9);
    check_value("what a run tells", "largest_deg", 0, told.largest_deg, expected.largest_deg, 1e-9);
    check_value("what a run tells", "mean_edges", 0, told.mean_edges, expected.mean_edges, 1e-9);
    check_value("what a run tells", "largest_edges", 0, told.largest_edges, expected.largest_edges, 1e-9);
    return after / before;
}

// ---- The table ------------------------------------------------------------------------------------------------------

static const struct learning rows[] = {
    {"uncertainty", VW_FIELD_SPLATS, open_hidden, 20, 0, 0, 1, NAN, find_auc, 0.7, 1},
    {"uncertainty", VW_FIELD_HASH, open_maps, 40, 100, 0, 1, NAN, find_auc, 0.99, 1},
    {"transient", VW_FIELD_HASH, open_hidden, 20, 100, 6, 10, 0.1, NULL, 0, 0},
    {"sky", VW_FIELD_HASH, open_sky, 6, 200, 0, 1, 1.0, NULL, 0, 0}, // seen: 3.9 dB after 15 epochs
    {"appearance_encoder", VW_FIELD_HASH, open_exposure, 12, 100, 6, 20, 1.0, NULL, 0, 0},
    {"pose", VW_FIELD_HASH, open_moved, 30, 100, 6, 20, 0.5, find_camera_errors, 0, 0.7},
    {"visibility", VW_FIELD_HASH, open_hidden, 20, 100, 6, 1, 0.3, find_auc, 0.7, 1},
    {"uncertainty", VW_FIELD_HASH, open_hidden, 20, 100, 6, 1, NAN, find_auc, 0.7, 1},
};

// Trains, and returns the PSNR at the end; `measured` receives the measure, where there is one.
static double train(const struct learning *row, const struct vw_scene *scene, const char *effects, double *measured) {
    struct vw_config config = test_config_of(row->field);
    strcpy(config.effects, effects);
    config.epochs = row->epochs;
    if (row->rays) config.rays = row->rays;
    if (row->levels) config.levels = row->levels;
    struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 0);
    struct test_run *run = test_run_of(trainer);
    double psnr = 0.0;
    for (uint32_t i = run->count - row->last; i < run->count; i++) psnr += run->records[i].val_psnr / row->last;
    assert_int_equal(run->stats.nonfinite_steps, 0);
    if (measured && row->measure) *measured = row->measure(scene, trainer, (const float *)run->params);
    test_release(trainer);
    return psnr;
}

TEST_CASES(effects_learn_what_photos_call_for, i, VW_ARRAY_COUNT(rows)) {
    const struct learning *row = &rows[i];
    const struct vw_scene *scene = row->open();
    double measured = row->least, with = train(row, scene, row->effect, &measured),
           without = isnan(row->gain_db) ? NAN : train(row, scene, "none", NULL);
    print_message("%s, field %s: %.2f dB with it, %.2f without; measure %.3f\n", row->effect, vw_field_name(row->field),
                  with, without, measured);
    if (with <= without + row->gain_db) fail_msg("%s gains less than %g dB", row->effect, row->gain_db);
    if (measured < row->least || measured > row->most)
        fail_msg("%s: measure %g, not %g to %g", row->effect, measured, row->least, row->most);
}

// Gains, biases and codes of photos: test_appearance.
TEST(every_effect_has_a_row) {
    for (size_t i = 0; vw_effect_kinds[i]; i++) {
        const char *name = vw_effect_kinds[i]->name;
        bool found = !strcmp(name, "appearance") || !strcmp(name, "appearance_code");
        for (size_t k = 0; k < VW_ARRAY_COUNT(rows); k++) found |= !strcmp(rows[k].effect, name);
        if (!found) fail_msg("effect %s has no row in test_effects_learn.c", name);
    }
}

TEST_GROUP(NULL, test_gpu_close)
