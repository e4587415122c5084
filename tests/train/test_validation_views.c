// Corrupted and far validation views, found by whole trainings on a recipe: one of five is corrupted in memory, in ways
// that real ones are.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "base/random.h"
#include "scene/view_distance.h"
#include "support/temporary_folder.h"
#include "support/trainer_fixture.h"
#include "train/trainer.h"
#include "value/matrix.h"
#include "viewworth/value.h"

enum { VAL_VIEWS = 5, CORRUPTED = 2 }; // the place among the validation views
static const char recipe[] =
    "{\"viewworth_recipe\": 1, \"seed\": 5, \"image\": {\"width_px\": 32, \"height_px\": 24},"
    " \"box\": {\"centre\": [0, 0, 0], \"half_extent\": 1}, \"background\": [0, 0, 0],"
    " \"sun\": {\"direction\": [0.4, -0.6, 0.9], \"intensity\": 0.7, \"ambient\": 0.4},"
    " \"shapes\": [{\"kind\": \"box\", \"centre\": [0, 0, -0.55], \"half_extent\": [0.95, 0.95, 0.05],"
    "  \"texture\": {\"kind\": \"checker\", \"colour\": [0.85, 0.8, 0.7], \"second_colour\": [0.35, 0.45, 0.4],"
    "  \"cell\": 0.38}},"
    " {\"kind\": \"sphere\", \"centre\": [0.35, 0.2, -0.1], \"radius\": 0.4,"
    "  \"texture\": {\"kind\": \"stripes\", \"colour\": [0.9, 0.35, 0.25], \"second_colour\": [0.95, 0.85, 0.4],"
    "  \"cell\": 0.2}}],"
    " \"cameras\": [{\"path\": \"orbit\", \"centre\": [0, 0, -0.2], \"radius\": 2.6, \"elevation_deg\": [25, 45],"
    "  \"turns\": 2, \"count\": 40, \"field_of_view_deg\": 50}],"
    " \"defects\": [{\"kind\": \"exposure\", \"strength\": 0.4, \"share\": 0.1},"
    "  {\"kind\": \"wrong_pose\", \"strength\": 10, \"share\": 0.1},"
    "  {\"kind\": \"occluder\", \"strength\": 0.4, \"share\": 0.1}]}";

static struct vw_scene *open_scene(void) {
    char *folder = temporary_folder_create();
    struct vw_scene *scene =
        test_scene_open((struct vw_scene_params){.path = temporary_file(folder, "recipe.json", recipe)});
    temporary_folder_remove(folder);
    assert_int_equal(scene->split_count[VW_SPLIT_VAL], VAL_VIEWS);
    return scene;
}

static struct vw_view *validation_view(struct vw_scene *scene, uint32_t place) {
    for (uint32_t v = 0; v < scene->view_count; v++)
        if (scene->views[v].split == VW_SPLIT_VAL && place-- == 0) return &scene->views[v];
    fail_msg("no such validation view");
    return NULL;
}

// ---- Ways to corrupt a view -----------------------------------------------------------------------------------------

static void leave(struct vw_view *view) { (void)view; }

static void change_pixels(struct vw_view *view, double gain, double bias, double noise) {
    uint8_t *values = view->image.pixels;
    assert_int_equal(view->image.format, VW_PIXEL_UINT8);
    for (uint32_t i = 0; i < 4 * view->image.width_px * view->image.height_px; i++) {
        uint32_t words[4];
        vw_random_words(9, VW_RANDOM_RECIPE, i, 0, 0, words);
        double value = gain * values[i] + 255 * (bias + noise * (2 * vw_random_unit(words[0]) - 1));
        if (i % 4 != 3) values[i] = (uint8_t)lrint(fmin(fmax(value, 0), 255));
    }
}

static void make_negative(struct vw_view *view) { change_pixels(view, -1, 1, 0); }
static void overexpose(struct vw_view *view) { change_pixels(view, 2, 0.3, 0); }
static void add_noise(struct vw_view *view) { change_pixels(view, 1, 0, 0.15); }

// Turns the photo upside down, as if it were of another place.
static void turn_over(struct vw_view *view) {
    uint32_t *pixels = (uint32_t *)view->image.pixels, count = view->image.width_px * view->image.height_px;
    for (uint32_t i = 0; i < count / 2; i++) {
        uint32_t kept = pixels[i];
        pixels[i] = pixels[count - 1 - i];
        pixels[count - 1 - i] = kept;
    }
}

// ---- Trainings ------------------------------------------------------------------------------------------------------

// Records a training on the scene, and evaluates its validation views.
static void evaluate(struct vw_scene *scene, struct vw_view_evidence evidence[VAL_VIEWS]) {
    struct vw_config config = test_config();
    config.epochs = 12;
    config.rays = 200;
    config.val_rays = 320;
    strcpy(config.effects, "none"); // appearance would fit the exposure of a validation photo
    struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 0);
    struct vw_ledger_image *images = test_allocate(scene->view_count, sizeof *images);
    char *folder = temporary_folder_create();
    struct vw_ledger *ledger = NULL;
    char hex[VW_HASH_HEX_BYTES];
    memset(hex, 'a', 64);
    hex[64] = 0;
    for (uint32_t v = 0; v < scene->view_count; v++)
        images[v] = (struct vw_ledger_image){
            .image_id = v, .name = scene->views[v].name, .split = vw_split_name(scene->views[v].split), .weight = 1};
    const struct vw_ledger_run run = {hex,  hex,  "recipe", 0,    "{}", hex, "d", "d", hex, "v", "2026-11-21T03:04:05Z",
                                      "{}", "[]", NULL,     NULL, NULL, NULL};
    ASSERT_OK(vw_ledger_create(temporary_path(folder, "ledger.db"), &run, images, scene->view_count, &ledger));
    const struct vw_step_record *records = NULL;
    struct vw_step_record *steps = NULL;
    uint32_t count = 0, view_count = 0;
    uint64_t step_count = 0;
    const uint32_t *views = vw_trainer_validation_views(trainer, &view_count);
    assert_int_equal(view_count, VAL_VIEWS);
    do {
        ASSERT_OK(vw_trainer_advance(trainer, &records, &count));
        if (count > 0) ASSERT_OK(vw_ledger_append(ledger, records, count, views));
    } while (count > 0);
    ASSERT_OK(vw_ledger_get_steps(ledger, &steps, &step_count));
    const struct vw_value_input input = {.records = steps,
                                         .record_count = step_count,
                                         .burn_in_epochs = 1,
                                         .images = images,
                                         .image_count = scene->view_count};
    struct vw_matrix matrix;
    ASSERT_OK(vw_value_matrix(ledger, &input, &matrix));
    double *standard_errors = test_allocate(matrix.photo_count, sizeof *standard_errors);
    ASSERT_OK(vw_matrix_jackknife(&matrix, evidence, standard_errors));
    vw_matrix_clear(&matrix);
    free(steps);
    vw_ledger_close(&ledger);
    temporary_folder_remove(folder);
}

TEST(corrupted_views_are_found) {
    static const struct {
        const char *what;
        void (*corrupt)(struct vw_view *view);
        bool corrupted; // so that its scores mislead
    } cases[] = {
        {"none", leave, false},
        {"noise of 0.15", add_noise, false},
        {"overexposed", overexpose, true},
        {"a negative", make_negative, true},
        {"another picture", turn_over, true},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        struct vw_scene *scene = open_scene();
        struct vw_view_evidence evidence[VAL_VIEWS];
        cases[i].corrupt(validation_view(scene, CORRUPTED));
        evaluate(scene, evidence);
        print_message("%-16s", cases[i].what);
        for (uint32_t v = 0; v < VAL_VIEWS; v++)
            print_message("  %5.1f dB %+.2f %+.2f%s%s", evidence[v].end_psnr, evidence[v].agreement,
                          evidence[v].without, evidence[v].disagrees ? " disagrees" : "",
                          evidence[v].stays_low ? " low" : "");
        print_message("\n");
        for (uint32_t v = 0; v < VAL_VIEWS; v++)
            assert_int_equal(evidence[v].disagrees || evidence[v].stays_low, v == CORRUPTED && cases[i].corrupted);
    }
}

TEST_GROUP(NULL, test_gpu_close)
