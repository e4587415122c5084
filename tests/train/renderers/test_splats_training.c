// The renderer splats through the whole trainer, beyond what test_fields shows of every field: the same run has the
// same bits on any number of threads, validation sees each pixel alone, splats begin at points that train views see,
// and what splats cannot have is refused by name.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "run/lasting/lasting_summary.h"
#include "support/draws.h"
#include "support/trainer_fixture.h"
#include "train/renderers/splats/splats.h"

enum { SQUARE = VW_SPLAT_SQUARE * VW_SPLAT_SQUARE, POINTS = 90 };

// Returns squares of the whole photo.
static struct vw_config whole_config(void) {
    struct vw_config config = test_config_of(VW_FIELD_SPLATS);
    config.rays = 4 * SQUARE;
    strcpy(config.effects, "sky,appearance");
    return config;
}

static struct test_run *run_on_threads(const char *threads) {
    assert_int_equal(setenv("LP_NUM_THREADS", threads, 1), 0);
    struct vw_config config = whole_config();
    struct vw_trainer *trainer =
        test_trainer_open((struct vw_trainer_params){.gpu = test_gpu_open((struct vw_gpu_params){.validation = true}),
                                                     .scene = test_scene(),
                                                     .config = &config,
                                                     .validate = true});
    struct test_run *run = test_run_of(trainer);
    test_release(trainer);
    return run;
}

TEST(threads_change_no_bit) { test_run_assert_same(run_on_threads("1"), run_on_threads("2")); }

// Validation sees every pixel as an evaluator does that looks at it alone.
TEST(validation_sees_each_pixel_alone) {
    const struct vw_config config = whole_config();
    struct vw_trainer *trainer = test_trainer_create(test_scene(), &config, true, 4);
    test_run_of(trainer);
    struct vw_evaluator *evaluator = &trainer->validation.evaluator, one = {0};
    uint32_t count = trainer->validation.ray_count;
    vw_float4 *before = test_allocate(count, sizeof *before), colour = {0};
    ASSERT_OK(vw_buffer_read(evaluator->colours, 0, before, count * sizeof *before));
    const struct vw_pixel *pixels = vw_buffer_map(evaluator->pixels);
    ASSERT_OK(vw_evaluator_create(&trainer->field, 1, false, &one));
    for (uint32_t i = 0; i < count; i += 37) {
        ASSERT_OK(vw_evaluator_render(&one, &pixels[i], 1, &colour));
        assert_memory_equal(&colour, &before[i], sizeof colour);
    }
    vw_evaluator_destroy(&one);
}

// Rays that a photo has no pixels for add nothing to the loss, whatever was drawn before them.
TEST(rays_beyond_the_photo_count_nothing) {
    struct vw_scene *scene = test_scene();
    struct vw_config config = test_config_of(VW_FIELD_SPLATS);
    config.epochs = 1;
    config.rays = 4 * SQUARE;
    struct test_run *fits = test_run(scene, &config, false, 0);
    config.rays = 16 * SQUARE;
    struct test_run *beyond = test_run(scene, &config, false, 0);
    double whole = fits->records[1].train_loss, part = beyond->records[1].train_loss;
    assert_true(whole > 0.0 && fabs(4.0 * part / whole - 1.0) < 1e-5);
    assert_int_equal(beyond->stats.nonfinite_steps, 0);
}

// Draws whether a pixel is kept.
static bool keeps(uint32_t view, uint32_t place) { return (view * 7 + place) * 2654435761u >> 29 > 2; }

// Masks the views of a scene, and gives the pixels that they hide other colours.
static void mask(struct vw_scene *scene, uint8_t hidden) {
    for (uint32_t v = 0; v < scene->view_count; v++) {
        struct vw_view *view = &scene->views[v];
        uint32_t pixels = view->image.width_px * view->image.height_px;
        view->mask = vw_allocate(pixels, 1);
        view->has_mask = true;
        assert_non_null(view->mask);
        for (uint32_t i = 0; i < pixels; i++) {
            view->mask[i] = keeps(v, i) ? VW_MASK_KEEP : VW_MASK_HIDE;
            if (!keeps(v, i)) memset((uint8_t *)view->image.pixels + 4 * (size_t)i, hidden, 3);
        }
    }
    scene->masked_view_count = scene->view_count;
}

TEST(masked_pixels_change_nothing) {
    struct vw_scene *black = test_scene(), *white = test_scene(), *whole = test_scene();
    struct vw_config config = whole_config();
    strcpy(config.effects, "masks,sky,appearance");
    mask(black, 0);
    mask(white, 255);
    struct test_run *run = test_run(black, &config, true, 0);
    test_run_assert_same(run, test_run(white, &config, true, 0));
    strcpy(config.effects, "sky,appearance");
    assert_true(test_run(whole, &config, true, 0)->records[1].train_loss > run->records[1].train_loss);
}

// The last step of a run of whole photos with masks.
struct masked_step {
    struct vw_trainer *trainer;
    const struct vw_scene *scene;
    const struct vw_step_record *record;
    const struct vw_pixel *pixels;
    vw_float4 *drawn;
};

static struct masked_step take_masked_step(const char *effects, struct vw_config *config) {
    struct vw_scene *scene = test_scene();
    *config = test_config_of(VW_FIELD_SPLATS);
    config->rays = 4 * SQUARE; // the whole photo
    config->epochs = 1;
    strcpy(config->effects, effects);
    mask(scene, 128);
    struct masked_step step = {test_trainer_create(scene, config, false, 1), scene, NULL, NULL, NULL};
    struct test_run *run = test_run_of(step.trainer);
    step.drawn = test_read(vw_splat_step_of(&step.trainer->step)->drawing.colours);
    step.pixels = test_read(step.trainer->step.pixels);
    step.record = &run->records[run->count - 1];
    while (step.pixels->view != step.record->view)
        step.pixels += config->rays; // the steps of a submission, one after another
    return step;
}

// Returns where the pixel of a ray is in the photo; UINT32_MAX where it is beyond or masked.
static uint32_t place_of(const struct masked_step *step, uint32_t ray) {
    const struct vw_image *image = &step->scene->views[step->record->view].image;
    uint32_t x = (uint32_t)step->pixels[ray].x_px, y = (uint32_t)step->pixels[ray].y_px,
             place = y * image->width_px + x;
    bool inside = x < image->width_px && y < image->height_px;
    return inside && keeps(step->record->view, place) ? place : UINT32_MAX;
}

// The loss of a masked photo is that of its pixels which the mask keeps, by what was drawn of them.
TEST(the_loss_is_of_the_pixels_that_masks_keep) {
    struct vw_config config;
    const struct masked_step step = take_masked_step("masks", &config);
    const vw_float4 *drawn = step.drawn;
    double loss = 0.0;
    uint32_t kept = 0;
    for (uint32_t i = 0; i < config.rays; i++) {
        const struct vw_image *image = &step.scene->views[step.record->view].image;
        uint32_t place = place_of(&step, i);
        if (place == UINT32_MAX) continue;
        const uint8_t *target = (const uint8_t *)image->pixels + 4 * (size_t)place;
        const float rgb[3] = {drawn[i].x, drawn[i].y, drawn[i].z};
        for (int c = 0; c < 3; c++) loss += pow((double)rgb[c] - target[c] / 255.0, 2) / 3.0;
        kept++;
    }
    assert_true(kept > 100 && kept < 24 * 18 - 100);
    assert_near(step.record->train_loss, loss / config.rays, 1e-5 * loss / config.rays);
}

// Photos are fitted to what was drawn, here before black, of the pixels that masks keep.
TEST(what_was_drawn_is_kept_for_the_fit) {
    struct vw_config config;
    const struct masked_step step = take_masked_step("masks,appearance", &config);
    const vw_float4 *rendered = test_read(step.trainer->step.effect_buffers[VW_SLOT_RENDERED]);
    double light = 0.0;
    for (uint32_t i = 0; i < config.rays; i++) {
        assert_true(rendered[i].w == (place_of(&step, i) != UINT32_MAX));
        if (rendered[i].w > 0.0f) assert_memory_equal(&rendered[i], &step.drawn[i], 3 * sizeof(float));
        light += rendered[i].w * rendered[i].y;
    }
    assert_true(light > 1.0);
}

// ---- The start ------------------------------------------------------------------------------------------------------

// Points, each seen by one view: every third by a validation view alone.
static struct vw_scene *scene_with_points(void) {
    struct vw_scene *scene = test_scene();
    scene->points = vw_allocate(POINTS, sizeof *scene->points);
    scene->tracks = vw_allocate(POINTS, sizeof *scene->tracks);
    assert_true(scene->points && scene->tracks);
    scene->point_count = scene->track_count = POINTS;
    for (uint32_t i = 0; i < POINTS; i++) {
        uint32_t view = 0;
        while ((scene->views[view].split == VW_SPLIT_VAL) != (i % 3 == 0)) view++;
        for (uint32_t axis = 0; axis < 3; axis++)
            scene->points[i].position_world[axis] = 0.5 * test_draw(3, i % 60, axis); // some coincide
        scene->points[i].rgb[1] = (float)i / POINTS;
        scene->points[i].first_track = i;
        scene->points[i].track_count = 1;
        scene->tracks[i].view = view;
    }
    return scene;
}

static const float *start_of(struct vw_scene *scene, const struct vw_config *config, uint32_t *count) {
    struct vw_trainer *trainer = test_trainer_create(scene, config, false, 0);
    const float *params = test_read(trainer->field.params);
    *count = vw_splat_model_of(&trainer->model)->count;
    test_release(trainer);
    return params;
}

// Returns which point a splat begins at, by its colour; POINTS: none.
static uint32_t point_of(const struct vw_scene *scene, const float *params, uint32_t count, uint32_t splat) {
    float green = params[4 * (SPLAT_HARMONICS * count + splat) + 1] * 0.28209479f + 0.5f;
    for (uint32_t i = 0; i < POINTS; i++)
        if (fabsf(green - scene->points[i].rgb[1]) < 1e-5f) return i;
    return POINTS;
}

TEST(splats_begin_at_points_that_train_views_see) {
    struct vw_scene *scene = scene_with_points();
    struct vw_config config = test_config_of(VW_FIELD_SPLATS);
    const uint32_t seen = POINTS - POINTS / 3;
    for (uint32_t most = 40; most <= seen; most += seen - 40) {
        uint32_t count = 0, last = 0;
        config.splats = most;
        const float *params = start_of(scene, &config, &count);
        assert_int_equal(count, most);
        for (uint32_t splat = 0; splat < count; splat++) {
            uint32_t point = point_of(scene, params, count, splat);
            assert_true(point < POINTS && point % 3 != 0 && (splat == 0 || point > last));
            last = point;
            float scale = params[4 * (SPLAT_SCALE * count + splat)];
            assert_true(scale >= logf(2.9e-4f) && scale < 0.0f);
            for (uint32_t axis = 0; axis < 3; axis++) {
                double at = (scene->points[point].position_world[axis] - scene->box.centre_world[axis]) /
                                (2.0 * scene->box.half_extent_world) +
                            0.5;
                assert_true(fabs((double)params[4 * splat + axis] - at) < 1e-6);
            }
        }
    }
}

// Each splat beyond the first of its point begins along no axis farther from it than the gap between points there.
TEST(more_splats_than_points_begin_beside_them) {
    struct vw_scene *scene = scene_with_points();
    struct vw_config config = test_config_of(VW_FIELD_SPLATS);
    uint32_t points = POINTS - POINTS / 3, count = 0, fewer = 0, moved = 0;
    config.splats = points;
    const float *one = start_of(scene, &config, &fewer);
    config.splats = 2 * points + 5;
    const float *several = start_of(scene, &config, &count);
    assert_int_equal(count, 2 * points + 5);
    for (uint32_t splat = 0; splat < count; splat++) {
        uint32_t from = splat % points;
        double gap = expf(one[4 * (SPLAT_SCALE * fewer + from)]), distance = 0.0;
        for (uint32_t axis = 0; axis < 3; axis++)
            distance = fmax(distance, fabs((double)several[4 * splat + axis] - one[4 * from + axis]));
        assert_true(splat < points ? distance == 0.0 : distance <= 1.001 * gap);
        moved += distance > 0.0;
        assert_int_equal(point_of(scene, several, count, splat), point_of(scene, one, fewer, from));
    }
    assert_int_equal(moved, points + 5);
    config.splats = 0;
    start_of(scene, &config, &count);
    assert_int_equal(count, 8192); // there are few points
}

// Returns the squared width of a pixel of a view at a place, in units of the world; infinite more than 15 % beside it.
static double pixel2_of(const struct vw_view *view, const double at[3]) {
    double seen[3] = {0}; // right, down, ahead
    for (int axis = 0; axis < 3; axis++)
        for (int i = 0; i < 3; i++)
            seen[axis] += (axis ? -1.0 : 1.0) * view->camera_to_world[i][axis] * (at[i] - view->camera_to_world[i][3]);
    const struct vw_camera *camera = &view->camera;
    double x = camera->focal_x_px * seen[0] / seen[2] + camera->centre_x_px,
           y = camera->focal_y_px * seen[1] / seen[2] + camera->centre_y_px;
    bool shown = seen[2] > 0.0 && fabs(x / camera->width_px - 0.5) < 0.65 && fabs(y / camera->height_px - 0.5) < 0.65;
    return shown ? pow(seen[2] / fmax(camera->focal_x_px, camera->focal_y_px), 2) : INFINITY;
}

TEST(filters_are_by_the_nearest_train_photo_that_shows_the_splat) {
    struct vw_scene *scene = scene_with_points();
    struct vw_config config = test_config_of(VW_FIELD_SPLATS);
    uint32_t count = 0, hidden = 0;
    config.splats = POINTS - POINTS / 3;
    for (uint32_t v = 0; v < scene->view_count; v++) { // so long that no photo shows some points
        scene->views[v].camera.focal_x_px *= 4.0;
        scene->views[v].camera.focal_y_px *= 4.0;
    }
    const float *params = start_of(scene, &config, &count);
    double edge = 2.0 * scene->box.half_extent_world, widest = 0.0, of_hidden[POINTS];
    for (uint32_t splat = 0; splat < count; splat++) {
        double at[3], pixel2 = INFINITY, filter = params[4 * (SPLAT_SCALE * count + splat) + 3];
        for (int i = 0; i < 3; i++) at[i] = ((double)params[4 * splat + i] - 0.5) * edge + scene->box.centre_world[i];
        for (uint32_t v = 0; v < scene->view_count; v++)
            if (scene->views[v].split == VW_SPLIT_TRAIN) pixel2 = fmin(pixel2, pixel2_of(&scene->views[v], at));
        if (isfinite(pixel2)) assert_near(filter, 0.2 * pixel2 / (edge * edge), 1e-4 * filter);
        if (isfinite(pixel2)) widest = fmax(widest, filter);
        else of_hidden[hidden++] = filter;
    }
    assert_true(hidden > 0 && hidden < count);
    for (uint32_t i = 0; i < hidden; i++) assert_true(of_hidden[i] == widest);
}

TEST(seeds_draw_other_points) {
    struct vw_scene *scene = scene_with_points();
    struct vw_config config = test_config_of(VW_FIELD_SPLATS);
    uint32_t count = 0;
    config.splats = 40;
    const float *first = start_of(scene, &config, &count), *again = start_of(scene, &config, &count);
    config.seed = 1;
    const float *other = start_of(scene, &config, &count);
    assert_memory_equal(first, again, 16 * count);
    assert_memory_not_equal(first, other, 16 * count);
}

// A box that reaches to the horizon does not make splats move faster: a first step has the length of its rate, and five
// have at most twice as much each.
TEST(positions_move_by_what_cameras_stand_around) {
    static const double extents[] = {1.0, 20.0};
    for (size_t i = 0; i < VW_ARRAY_COUNT(extents); i++) {
        struct vw_scene *scene = test_scene();
        scene->box.half_extent_world = extents[i];
        struct vw_config config = test_config_of(VW_FIELD_SPLATS);
        config.epochs = 1;
        config.learning_rate_decay = 1.0;
        struct vw_trainer *trainer = test_trainer_create(scene, &config, false, 0);
        const struct vw_splat_model *splats = vw_splat_model_of(&trainer->model);
        double extent = fmin(1.0, 3.0 / (0.32 * 2.0 * extents[i])), farthest = 0.0;
        assert_near(splats->extent, extent,
                    0.4 * extent); // five of eight cameras on a ring of 3: their middle is beside it
        uint32_t numbers = 4 * splats->count;
        const float *before = test_read(trainer->field.params);
        test_run_of(trainer);
        const float *after = test_read(trainer->field.params);
        for (uint32_t k = 0; k < numbers; k++)
            if (k % 4 < 3) farthest = fmax(farthest, fabs((double)after[k] - before[k]));
        double rate = 1.7e-4 * config.learning_rate * extent;
        if (farthest < 0.9 * rate || farthest > 10.0 * rate) fail_msg("%g at a rate of %g", farthest, rate);
        test_release(trainer);
    }
}

TEST(gaps_are_those_of_all_pairs) {
    enum { COUNT = 200 };
    float points[COUNT][3], gaps[COUNT];
    for (uint32_t i = 0; i < COUNT; i++)
        for (uint32_t axis = 0; axis < 3; axis++) points[i][axis] = (float)test_draw(5, i % 190, axis);
    ASSERT_OK(vw_splats_measure_gaps((const float(*)[3])points, COUNT, 1e-4f, gaps));
    for (uint32_t i = 0; i < COUNT; i++) {
        double nearest2[3] = {INFINITY, INFINITY, INFINITY};
        for (uint32_t k = 0; k < COUNT; k++) {
            double d2 = 0.0;
            for (uint32_t axis = 0; axis < 3; axis++) d2 += pow((double)points[i][axis] - (double)points[k][axis], 2);
            for (uint32_t n = 0; n < 3 && k != i; n++) {
                double kept = nearest2[n];
                nearest2[n] = fmin(kept, d2);
                d2 = fmax(kept, d2);
            }
        }
        assert_true(fabs((double)gaps[i] / sqrt((nearest2[0] + nearest2[1] + nearest2[2]) / 3.0) - 1.0) < 1e-5);
    }
    ASSERT_OK(vw_splats_measure_gaps((const float(*)[3])points, 1, 1e-4f, gaps));
    assert_true(gaps[0] > 0.0f && isfinite(gaps[0]));
}

// ---- What is refused ------------------------------------------------------------------------------------------------

TEST(effects_that_splats_cannot_have_are_refused_by_name) {
    static const char *const possible = "distortion,background,masks,sky,appearance,uncertainty";
    struct vw_effect_decision listed[VW_EFFECT_COUNT_MAX];
    uint32_t count, kept = 0;
    vw_effects_list(listed, &count);
    for (uint32_t e = 0; e < count; e++) {
        struct vw_effect_decision decisions[VW_EFFECT_COUNT_MAX];
        struct vw_config config = test_config_of(VW_FIELD_SPLATS);
        vw_effects_list(decisions, &count);
        decisions[e].on = true;
        strcpy(config.effects, "auto");
        ASSERT_OK(vw_effects_follow_field(&config, decisions, count));
        kept += decisions[e].on;
        bool can = decisions[e].on;
        assert_int_equal(can, strstr(possible, listed[e].name) != NULL && strcmp(listed[e].name, "appearance_code"));
        decisions[e].on = true;
        snprintf(config.effects, sizeof config.effects, "+%s", listed[e].name);
        enum vw_status status = vw_effects_follow_field(&config, decisions, count);
        if (can) assert_int_equal(status, VW_OK);
        else ASSERT_FAILS(status, VW_ERROR_USAGE, listed[e].name);
    }
    assert_true(kept > 0);
}

TEST(settings_that_splats_cannot_have_are_refused_by_name) {
    struct vw_config config = test_config_of(VW_FIELD_SPLATS);
    ASSERT_FAILS(vw_lasting_check_config(&config), VW_ERROR_USAGE, "--field hash");
    config.rays = 500;
    ASSERT_FAILS(vw_config_check(&config), VW_ERROR_USAGE, "--rays");
    config = test_config_of(VW_FIELD_SPLATS);
    config.importance_samples = 16;
    ASSERT_FAILS(vw_config_check(&config), VW_ERROR_USAGE, "--importance-samples: needs --field hash or mlp");
    config.importance_samples = 0;
    config.consistency_weight = 0.001;
    ASSERT_FAILS(vw_config_check(&config), VW_ERROR_USAGE, "--consistency-weight: needs --field hash or mlp");
    config = vw_config_of_field(VW_FIELD_HASH);
    config.splats = 10;
    ASSERT_FAILS(vw_config_check(&config), VW_ERROR_USAGE, "--field splats");
}

TEST_GROUP(NULL, test_gpu_close)
