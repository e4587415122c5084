// Photos with an exposure and a code of their own, in whole trainings: what is learned, what stays, and that validation
// remains a function of the params. Hard cases: halves of validation photos that are flat or hold few rays, and gains
// by which pixels cannot be divided. Photos that are black, masked or saturated: check_fit_photo() and
// test_hard_photos.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "gpu/compute.h"
#include "hard_cases/hard_step.h"
#include "support/exposed_scene.h"
#include "support/trainer_fixture.h"
#include "train/trainer.h"
#include "train/validation/measure_views.h"

// The pixels of both halves, and that --val-rays counts those that are scored.
TEST(halves_share_no_column) {
    struct vw_scene *scene = synthetic_scene(
        &(struct synthetic_scene_params){.train_views = 5, .val_views = TEST_VALS, .width_px = 25, .height_px = 18});
    struct vw_config config = test_config_with("appearance");
    struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 1);
    const struct vw_pixel *pixels = vw_buffer_map(trainer->validation.evaluator.pixels);
    struct vw_ray_range fitted[TEST_VALS];
    ASSERT_OK(vw_buffer_read(trainer->validation.view_fit.ranges, 0, fitted, sizeof fitted));
    assert_int_equal(trainer->validation.ray_count, config.val_rays);
    for (uint32_t i = 0; i < trainer->validation.ray_count; i++) assert_true(pixels[i].x_px > 13.0f);
    for (uint32_t view = 0; view < TEST_VALS; view++) {
        assert_int_equal(fitted[view].count, config.val_rays / TEST_VALS);
        assert_true(fitted[view].first >= trainer->validation.ray_count);
        for (uint32_t i = fitted[view].first; i < fitted[view].first + fitted[view].count; i++) {
            assert_true(pixels[i].x_px < 12.0f);
            assert_int_equal(pixels[i].view, trainer->validation.views[view]);
        }
    }
}

// A few squares of 8 x 8 pixels would show too little of a photo.
TEST(splats_are_fitted_to_as_many_squares_as_are_scored) {
    struct vw_scene *scene = synthetic_scene(
        &(struct synthetic_scene_params){.train_views = 5, .val_views = TEST_VALS, .width_px = 80, .height_px = 40});
    struct vw_config config = test_config_of(VW_FIELD_SPLATS);
    strcpy(config.effects, "appearance");
    config.val_rays = TEST_VALS * 4 * 64;
    struct vw_ray_range fitted[TEST_VALS];
    struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 1);
    ASSERT_OK(vw_buffer_read(trainer->validation.view_fit.ranges, 0, fitted, sizeof fitted));
    for (uint32_t view = 0; view < TEST_VALS; view++) assert_int_equal(fitted[view].count, 4 * 64);
}

static void darken(struct vw_view *view, double gain) {
    uint8_t *pixels = view->image.pixels;
    for (uint32_t i = 0; i < 4 * view->image.width_px * view->image.height_px; i++)
        if (i % 4 != 3) pixels[i] = (uint8_t)lrint(gain * pixels[i]);
}

// One train photo and one validation photo taken with half the light: of the train photos that one gets darker, photos
// that are not trained on keep gain and bias of 0, and fitted, the validation photo's errors are those of a photo that
// is half as bright.
TEST(gains_are_found) {
    enum { DARK = 2, DARK_VAL = 1 };
    struct vw_scene *scene = test_scene();
    struct vw_config config = test_config_with("appearance");
    config.epochs = 30;
    struct test_run *before = test_run(scene, &config, true, 0);
    darken(&scene->views[DARK], 0.5);
    darken(&scene->views[5 + DARK_VAL], 0.5);
    struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 0);
    struct test_run *run = test_run_of(trainer);
    double grey[2][5] = {{0}}; // value that a train photo makes of grey, before and with less light
    for (uint32_t view = 0; view < scene->view_count; view++) {
        struct reference_photo photo[2] = {reference_photo_of(&trainer->model, (const float *)before->params, view),
                                           reference_photo_of(&trainer->model, (const float *)run->params, view)};
        for (int c = 0; c < 6; c++) {
            const struct reference_photo *it = &photo[c / 3];
            if (view >= 5) assert_true(it->gain[c % 3] == 0.0 && it->bias[c % 3] == 0.0);
            else grey[c / 3][view] += 0.5 * (1.0 + it->gain[c % 3]) + it->bias[c % 3];
        }
    }
    for (uint32_t view = 0; view < 5; view++) {
        double ratio = grey[1][view] / grey[0][view], dark_ratio = grey[1][DARK] / grey[0][DARK];
        if (view != DARK && ratio < dark_ratio + 0.1)
            fail_msg("photo %u: %g times its grey, the dark one %g", view, ratio, dark_ratio);
    }
    double bright = before->views[before->count - 1][DARK_VAL].l1, dark = run->views[run->count - 1][DARK_VAL].l1;
    if (dark > 0.75 * bright) fail_msg("an L1 of %g where the bright photo has %g", dark, bright);
}

// Points give gains and biases before the first step, and nothing moves them: no pass, and nothing that a pass would
// need. In a scene without points the same effect has both.
TEST(what_points_give_stays) {
    const struct exposed_scene_params exposed = {.gains = 1, .biases = 1, .noise = 0.01};
    struct vw_scene *given = exposed_scene(exposed), *fitted = exposed_scene(exposed);
    struct vw_config config = test_config_with("appearance");
    const struct vw_exposure *exposures;
    scene_forget_points(fitted);
    ASSERT_OK(vw_scene_estimate_exposures(given, &exposures));
    for (int i = 0; i < 2; i++) {
        struct vw_trainer *trainer = test_trainer_create(i ? fitted : given, &config, true, 0);
        const struct vw_step_passes *step = &trainer->step;
        bool moves = false, has_pass = false;
        assert_int_equal(trainer->model.specialization.effect_appearance, i ? APPEARANCE_FITTED : APPEARANCE_GIVEN);
        assert_int_equal(step->effect_buffers[VW_SLOT_RENDERED] != NULL, i);
        assert_int_equal(step->effect_buffers[VW_SLOT_PHOTO_SUMS] != NULL, i);
        for (uint32_t e = 0; e < trainer->model.effect_count; e++)
            has_pass |= step->effects.sets[e].passes[VW_EFFECT_UPDATE] != NULL;
        assert_int_equal(has_pass, i);
        const struct test_run *run = test_run_of(trainer);
        assert_int_equal(run->stats.nonfinite_steps, 0);
        for (uint32_t view = 0; view < EXPOSED_VIEWS; view++) {
            const struct reference_photo photo = reference_photo_of(&trainer->model, (const float *)run->params, view);
            for (int c = 0; c < 3; c++)
                moves |=
                    photo.gain[c] != (float)exposures[view].gain[c] || photo.bias[c] != (float)exposures[view].bias[c];
        }
        assert_int_equal(moves, i);
    }
}

// Pixels are divided by no less than about a tenth (the median photo moves it a little), whatever points say.
TEST(points_give_no_gain_below_the_least) {
    struct vw_scene *scene = exposed_scene((struct exposed_scene_params){0});
    struct vw_config config = test_config_with("appearance");
    const struct vw_exposure *exposures;
    for (uint32_t i = 0; i < 4 * EXPOSED_PIXELS; i++)
        if (i % 4 != 3) exposed_pixel(scene, 1, 0, 0)[i] *= 0.06f;
    ASSERT_OK(vw_scene_estimate_exposures(scene, &exposures));
    const struct test_run *run = test_run(scene, &config, true, 0);
    struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 0);
    const struct reference_photo photo = reference_photo_of(&trainer->model, (const float *)run->params, 1);
    assert_int_equal(run->stats.nonfinite_steps, 0);
    for (int c = 0; c < 3; c++) {
        assert_true(fabs(exposures[1].gain[c] + 0.9) < 0.01);
        assert_true(photo.gain[c] == (float)exposures[1].gain[c]);
    }
}

// A photo that nothing was trained on is darker: its code brings the render nearer to it. Without the fit the params
// are as before, and a whole view leaves them so.
TEST_CASES(a_code_is_fitted_and_taken_away, form, 2) {
    // Gains and biases leave little to codes of how bright photos are.
    static const struct {
        const char *effects;
        double share;
    } cases[] = {{"appearance_code", 0.8}, {"appearance,appearance_code", 0.95}};
    struct vw_scene *scene = test_scene();
    struct vw_config config = test_config_with(cases[form].effects);
    config.epochs = 30;
    struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 0);
    const struct vw_step_record *records;
    uint32_t step_count = 1;
    while (step_count) ASSERT_OK(vw_trainer_advance(trainer, &records, &step_count));
    const uint32_t view = trainer->validation.views[0];
    darken(&scene->views[view], 0.5);
    struct vw_pixel pixels[CODE_FIT_RAYS_MAX];
    vw_float4 colours[2][CODE_FIT_RAYS_MAX];
    uint32_t count = vw_pixels_stratify_squares(scene, view, vw_view_fit_left_half(scene, view), 0, true, 1,
                                                CODE_FIT_RAYS_MAX, pixels);
    size_t bytes = trainer->model.param_bytes;
    double squares[2] = {0};
    struct vw_evaluator evaluator;
    struct vw_code_fit fit;
    ASSERT_OK(vw_evaluator_create(&trainer->field, count, false, &evaluator));
    const void *before = test_read(trainer->field.params);
    ASSERT_OK(vw_evaluator_render(&evaluator, pixels, count, colours[0]));
    ASSERT_OK(vw_code_fit_apply(&trainer->field, pixels, count, &fit));
    ASSERT_OK(vw_evaluator_render(&evaluator, pixels, count, colours[1]));
    const void *fitted = test_read(trainer->field.params);
    ASSERT_OK(vw_code_fit_undo(&trainer->field, &fit));
    assert_memory_not_equal(before, fitted, bytes);
    assert_memory_equal(before, test_read(trainer->field.params), bytes);
    for (int i = 0; i < 2; i++)
        for (uint32_t k = 0; k < count; k++)
            squares[i] += pow(colours[i][k].x - pixels[k].rgba.x, 2) + pow(colours[i][k].y - pixels[k].rgba.y, 2) +
                          pow(colours[i][k].z - pixels[k].rgba.z, 2);
    if (!(squares[1] < cases[form].share * squares[0]))
        fail_msg("%s: %g with the code, %g without", cases[form].effects, squares[1], squares[0]);
    struct vw_whole_view whole;
    ASSERT_OK(vw_trainer_measure_whole(trainer, NULL, view, &whole));
    assert_memory_equal(before, test_read(trainer->field.params), bytes);
    vw_whole_view_free(&whole);
    vw_evaluator_destroy(&evaluator);
}

// ---- Hard cases -----------------------------------------------------------------------------------------------------

// Share of gains, biases and colours of order 1: float sums of up to 3,000 products.
static const double FIT_TOLERANCE = 2e-5;

static const struct step_case setup = {
    .name = "photos of their own", .seed = 371, HARD_STEP, .effects = "appearance,appearance_code"};

// Checks that the device fits hand-made rays of one view (index REDUCED_VIEWS - 1) as the reference does.
static void check_fit(struct hard_finding *finding, struct view_reduction *r, struct step_bench *bench,
                      struct vw_appearance *fit) {
    static double rendered[REDUCED_RAYS], target[REDUCED_RAYS];
    const struct vw_ray_range *range = &reduced_ranges[REDUCED_VIEWS - 1];
    struct vw_push_reduce push = {.count = REDUCED_VIEWS};
    struct vw_appearance fits[REDUCED_VIEWS];
    test_write(r->rays, r->ray_data);
    test_write(r->colours, r->colour_data);
    step_bench_dispatch(bench, r->fit_pass, &push, sizeof push, 64 * REDUCED_VIEWS);
    assert_int_equal(vw_buffer_read(r->fits, 0, fits, sizeof fits), VW_OK);
    *fit = fits[REDUCED_VIEWS - 1];
    for (int c = 0; c < 3; c++) {
        double gain, bias;
        uint32_t count = 0;
        for (uint32_t i = range->first; i < range->first + range->count; i++) {
            if (r->ray_data[i].target_weight.w == 0.0f) continue;
            rendered[count] = (&r->colour_data[i].x)[c];
            target[count++] = (&r->ray_data[i].target_weight.x)[c];
        }
        reference_fit_channel(rendered, target, count, &gain, &bias);
        hard_compare(finding, "fitted gain", (uint64_t)c, (&fit->gain.x)[c], gain, 1.0 + fabs(gain), FIT_TOLERANCE);
        hard_compare(finding, "fitted bias", (uint64_t)c, (&fit->bias.x)[c], bias, 1.0 + fabs(bias), FIT_TOLERANCE);
    }
}

static void fill(struct view_reduction *r, vw_float4 colour, vw_float4 target) {
    for (uint32_t i = 0; i < REDUCED_RAYS; i++) {
        r->colour_data[i] = colour;
        r->ray_data[i].target_weight = target;
    }
}

static void flat_halves(struct hard_finding *finding) {
    struct step_bench *bench = step_bench_open(&setup);
    struct view_reduction *r = reduction_open(bench->gpu, true);
    struct vw_appearance fit;
    fill(r, (vw_float4){0.5f, 0.0f, 1.0f, 0.0f},
         (vw_float4){0.3f, 0.4f, 1.0f, 1.0f}); // red differs, green is rendered black, blue fits
    check_fit(finding, r, bench, &fit);
    hard_require(finding, fabsf(fit.gain.x) < 0.2f && fabsf((1.0f + fit.gain.x) * 0.5f + fit.bias.x - 0.3f) < 1e-3f,
                 "a flat half is met, with a gain near 1");
    hard_require(finding, fit.gain.y == 0.0f && fabsf(fit.bias.y - 0.4f) < 1e-3f,
                 "where black is rendered, only a bias can help");
    hard_require(finding, fit.gain.z == 0.0f && fit.bias.z == 0.0f, "what fits is left as it is");
    fill(r, (vw_float4){0.5f, 0.5f, 0.5f, 0.0f}, (vw_float4){0.3f, 0.4f, 0.6f, 0.0f}); // no ray counts
    check_fit(finding, r, bench, &fit);
    hard_require(finding, fit.gain.x == 0.0f && fit.bias.x == 0.0f, "without a ray nothing is fitted");
    r->ray_data[2000].target_weight.w = 1.0f;
    check_fit(finding, r, bench, &fit);
    fill(r, (vw_float4){1.0f, 1.0f, 1.0f, 0.0f},
         (vw_float4){1.0f, 0.0f, 1.0f, 1.0f}); // saturated, but for half of the rays
    for (uint32_t i = 0; i < REDUCED_RAYS; i += 2) r->colour_data[i] = (vw_float4){1e-7f, 0.999999f, 1e3f, 0.0f};
    check_fit(finding, r, bench, &fit);
}

// Checks narrow photos: one column has no halves and is refused by name; two and three are a left and a right column,
// the third is in neither.
static void few_columns(struct hard_finding *finding) {
    struct vw_config config = test_config_with("appearance");
    struct vw_trainer *trainer = NULL;
    for (uint32_t width_px = 9; width_px >= 1; width_px--) {
        struct vw_scene *scene = synthetic_scene(
            &(struct synthetic_scene_params){.train_views = 5, .val_views = 3, .width_px = width_px, .height_px = 8});
        struct vw_pixel_columns left = vw_view_fit_left_half(scene, 0), right = vw_view_fit_right_half(scene, 0);
        hard_equal(finding, "columns left and right", width_px, left.end - left.begin, right.end - right.begin);
        hard_equal(finding, "columns in both halves or none", width_px, right.begin - left.end, width_px % 2);
        hard_equal(finding, "columns in all", width_px, left.begin == 0 && right.end == width_px, 1.0);
        if (width_px == 1)
            ASSERT_FAILS(test_trainer_try(
                             (struct vw_trainer_params){.scene = scene, .config = &config, .validate = true}, &trainer),
                         VW_ERROR_INPUT, "view_005", "right half");
    }
}

static void write_photos(struct step_bench *bench, float gain, float bias) {
    float *photos = bench->params + bench->model.ranges[VW_SLOT_APPEARANCE].offset_bytes / sizeof(float);
    for (uint32_t i = 0; i < 8 * bench->scene->view_count; i++) photos[i] = i % 4 == 3 ? 0.0f : i % 8 < 4 ? gain : bias;
    step_bench_write_params(bench);
}

static void write_colour(struct step_bench *bench, float colour, float weight) {
    for (uint32_t i = 0; i < bench->config.rays; i++) {
        bench->pixels[i].view = bench->view;
        bench->pixels[i].rgba = (vw_float4){colour, colour, colour, 1.0f};
        bench->pixels[i].weight = weight;
    }
    hard_write_pixels(bench);
}

// Checks a step from photos whose gains and biases are these; a photo for which it is taken is as others after it.
static void one_step_from(struct hard_finding *finding, float gain, float bias) {
    struct step_bench *bench = step_bench_open(&setup);
    write_photos(bench, gain, bias);
    write_colour(bench, 0.5f, 1.0f);
    const struct hard_gradients gradients = hard_take_gradients(bench, 1);
    const struct hard_state before = hard_state_read(bench);
    step_bench_step(bench, 1);
    const struct hard_state after = hard_state_read(bench);
    const struct reference_photo photo = reference_photo_of(&bench->model, after.grid.grid, bench->view);
    hard_require(finding, !after.skipped, "a corrected colour stays between black and white, and the loss finite");
    hard_check_update(finding, bench, 1, &gradients, &before, &after);
    for (int c = 0; c < 3; c++)
        hard_require(finding, fabs(photo.gain[c]) < 1.0 && fabs(photo.bias[c]) < 1.0, "a huge gain comes back at once");
    test_release(bench);
}

// Checks gains by which pixels become next to 0, and biases far beyond white.
static void huge_gains(struct hard_finding *finding) {
    const float gains[] = {1e8f, -1e8f, 1e30f, 3e38f};
    const float biases[] = {1e8f, 1e30f, -3e38f};
    for (size_t i = 0; i < VW_ARRAY_COUNT(gains); i++) one_step_from(finding, gains[i], 0.0f);
    for (size_t i = 0; i < VW_ARRAY_COUNT(biases); i++) one_step_from(finding, 0.0f, biases[i]);
}

static const struct hard_case hard[] = {
    {"flat left half, or no ray in it", "0/0 in the fit; gains of anything", flat_halves},
    {"validation photos of 1 to 9 columns", "columns in both halves, or halves of none", few_columns},
    {"gains and biases of 10^8 to 10^38", "targets and losses that are not finite", huge_gains},
};
HARD_CASES("appearance", hard)
