// Measuring whole views agrees with validation on the pixels that it looks at, and with rendering on all of them.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "image/image.h"
#include "support/trainer_fixture.h"
#include "train/trainer.h"

// Trains to the end, and lends what validation found last.
static struct vw_trainer *train(const struct vw_scene *scene, const char *effects,
                                struct vw_view_error last[TEST_VALS]) {
    struct vw_config config = test_config();
    const struct vw_step_record *records;
    uint32_t count;
    strcpy(config.effects, effects);
    struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 0);
    do {
        ASSERT_OK(vw_trainer_advance(trainer, &records, &count));
        if (count) memcpy(last, records[count - 1].views, TEST_VALS * sizeof *last);
    } while (count);
    return trainer;
}

// Validation adds up in two floats and fits in floats: 24 bits of what a few dozen pixels sum to.
TEST(the_pixels_of_validation_give_its_errors) {
    static const char *const effects[] = {"none", "appearance"};
    for (int i = 0; i < 2; i++) {
        struct vw_scene *scene = test_scene();
        struct vw_view_error last[TEST_VALS], measured[TEST_VALS];
        struct vw_trainer *trainer = train(scene, effects[i], last);
        ASSERT_OK(vw_trainer_measure_views(trainer, trainer->validation.views, TEST_VALS,
                                           test_config().val_rays / TEST_VALS, measured));
        for (uint32_t v = 0; v < TEST_VALS; v++) {
            assert_near(measured[v].mse, last[v].mse, 2e-5 * last[v].mse);
            assert_near(measured[v].l1, last[v].l1, 2e-5 * last[v].l1);
        }
        test_release(trainer);
    }
}

TEST(hidden_pixels_do_not_count) {
    struct vw_scene *scene = test_scene();
    struct vw_view_error last[TEST_VALS], whole, half;
    struct vw_trainer *trainer = train(scene, "none", last);
    struct vw_view *view = &scene->views[trainer->validation.views[0]];
    uint32_t width_px = view->image.width_px, pixels = width_px * view->image.height_px;
    ASSERT_OK(vw_trainer_measure_views(trainer, trainer->validation.views, 1, pixels, &whole));
    view->mask = malloc(pixels);
    for (uint32_t i = 0; i < pixels; i++) view->mask[i] = i % width_px < width_px / 2 ? VW_MASK_HIDE : VW_MASK_KEEP;
    ASSERT_OK(vw_trainer_measure_views(trainer, trainer->validation.views, 1, pixels, &half));
    assert_true(half.mse != whole.mse && half.mse > 0);
    memset(view->mask, VW_MASK_HIDE, pixels);
    ASSERT_FAILS(vw_trainer_measure_views(trainer, trainer->validation.views, 1, pixels, &half), VW_ERROR_INPUT,
                 view->name);
}

// Returns the errors of the arrays that a whole view hands out, over the pixels that count.
static struct vw_view_error errors_of(const struct vw_whole_view *whole, uint32_t *count) {
    struct vw_view_error sums = {0};
    *count = 0;
    for (uint32_t i = 0; i < whole->width_px * whole->height_px; i++) {
        if (!whole->counts[i]) continue;
        ++*count;
        for (uint32_t c = 0; c < 3; c++) {
            double missing = (double)whole->rendered[3 * i + c] - whole->photo[3 * i + c];
            sums.mse += missing * missing;
            sums.l1 += fabs(missing);
        }
    }
    return (struct vw_view_error){.mse = sums.mse / (3.0 * *count), .l1 = sums.l1 / (3.0 * *count)};
}

// Whatever validation looks at: all pixels, the right half where it fits, and what masks leave.
TEST(whole_views_have_the_errors_of_all_pixels) {
    static const char *const effects[] = {"none", "appearance", "masks,appearance"};
    for (int i = 0; i < 3; i++) {
        struct vw_scene *scene = test_scene();
        struct vw_view_error last[TEST_VALS], measured;
        struct vw_whole_view whole;
        uint32_t count;
        struct vw_trainer *trainer = train(scene, effects[i], last);
        uint32_t place = trainer->validation.views[2];
        struct vw_view *view = &scene->views[place];
        uint32_t width_px = view->image.width_px, pixels = width_px * view->image.height_px;
        if (i == 2) view->mask = malloc(pixels);
        for (uint32_t p = 0; i == 2 && p < pixels; p++) view->mask[p] = p % 3 ? VW_MASK_KEEP : VW_MASK_HIDE;
        ASSERT_OK(vw_trainer_measure_views(trainer, &place, 1, pixels, &measured));
        ASSERT_OK(vw_trainer_measure_whole(trainer, NULL, place, &whole));
        assert_int_equal(whole.width_px, width_px);
        assert_true(whole.error.mse == measured.mse && whole.error.l1 == measured.l1);
        struct vw_view_error kept = errors_of(&whole, &count);
        assert_near(kept.mse, measured.mse, 1e-6 * measured.mse); // the arrays are rounded to floats
        assert_near(kept.l1, measured.l1, 1e-6 * measured.l1);
        for (uint32_t p = 0; p < pixels; p++) {
            bool scored = i == 0 || p % width_px >= width_px - width_px / 2;
            assert_int_equal(whole.counts[p], scored && (i < 2 || p % 3));
        }
        vw_whole_view_free(&whole);
        test_release(trainer);
    }
}

// With nothing fitted it is the render, bit for bit, and beside it the photo.
TEST(a_whole_view_is_the_render_beside_the_photo) {
    struct vw_scene *scene = test_scene();
    struct vw_view_error last[TEST_VALS];
    struct vw_whole_view whole;
    float *rgb = NULL;
    struct vw_trainer *trainer = train(scene, "none", last);
    uint32_t view = trainer->validation.views[0];
    const struct vw_image *image = &scene->views[view].image;
    ASSERT_OK(vw_trainer_measure_whole(trainer, NULL, view, &whole));
    ASSERT_OK(vw_trainer_render(trainer, view, &rgb));
    for (uint32_t i = 0; i < image->width_px * image->height_px; i++) {
        float rgba[4];
        vw_image_pixel(image, i % image->width_px, i / image->width_px, rgba);
        assert_memory_equal(whole.photo + 3 * i, rgba, 3 * sizeof *rgba);
        assert_memory_equal(whole.rendered + 3 * i, rgb + 3 * i, 3 * sizeof *rgb);
    }
    free(rgb);
    vw_whole_view_free(&whole);
}

// Measures by the scene at another size what the larger camera sees, bit for bit, beside its photo.
TEST(a_whole_view_of_another_size_has_its_camera) {
    struct vw_scene *scene = test_scene(), *sized = test_scene();
    struct vw_view_error last[TEST_VALS];
    struct vw_whole_view whole;
    float *rgb = NULL;
    struct vw_trainer *trainer = train(scene, "none", last);
    uint32_t view = trainer->validation.views[0];
    sized->views[view].camera.focal_x_px *= 1.5;
    ASSERT_OK(vw_trainer_measure_whole(trainer, sized, view, &whole));
    ASSERT_OK(vw_trainer_render_posed(trainer, view, &sized->views[view], false, &rgb));
    assert_memory_equal(whole.rendered, rgb, 3 * sizeof *rgb * whole.width_px * whole.height_px);
    free(rgb);
    vw_whole_view_free(&whole);
    ASSERT_OK(vw_trainer_measure_whole(trainer, NULL, view, &whole));
    ASSERT_OK(vw_trainer_render(trainer, view, &rgb)); // the view has its own camera again
    assert_memory_equal(whole.rendered, rgb, 3 * sizeof *rgb * whole.width_px * whole.height_px);
    free(rgb);
    vw_whole_view_free(&whole);
}

// Renders by a posed camera are those of a view that has it, bit for bit, alone and among others, and the view has its
// own camera afterwards.
static void check_posed(const char *effects, enum vw_field field, double k1) {
    struct synthetic_scene_params params = {.train_views = 5, .val_views = TEST_VALS, .width_px = 24, .height_px = 20};
    params.k1 = k1;
    struct vw_scene *scene = synthetic_scene(&params);
    for (uint32_t v = 1; v < scene->view_count; v += 2) scene->views[v].camera.focal_x_px *= 0.4; // wider
    struct vw_config config = test_config_of(field);
    strcpy(config.effects, effects);
    config.epochs = 1;
    struct test_run *run = calloc(1, sizeof *run);
    struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 0);
    float *before, *expected, *posed, *after, *several;
    test_run_advance(trainer, run);
    size_t bytes = 3 * sizeof *posed * params.width_px * params.height_px;
    uint32_t place = trainer->validation.views[0], other = trainer->validation.views[1];
    ASSERT_OK(vw_trainer_render(trainer, place, &before));
    ASSERT_OK(vw_trainer_render(trainer, other, &expected));
    ASSERT_OK(vw_trainer_render_posed(trainer, place, &scene->views[other], false, &posed));
    ASSERT_OK(vw_trainer_render(trainer, place, &after));
    const struct vw_view poses[3] = {scene->views[other], scene->views[place], scene->views[other]};
    ASSERT_OK(vw_trainer_render_poses(trainer, (uint32_t[]){place, place, place}, poses, 3, 0, &several));
    assert_memory_equal(several, posed, bytes);
    assert_memory_equal(several + bytes / sizeof *several, before, bytes);
    assert_memory_equal(several + 2 * bytes / sizeof *several, posed, bytes);
    assert_memory_equal(posed, expected, bytes);
    assert_memory_equal(after, before, bytes);
    assert_memory_not_equal(after, posed, bytes);
    free(before), free(expected), free(posed), free(after), free(several), free(run);
    test_release(trainer);
}

TEST(a_posed_camera_sees_what_a_view_there_sees) {
    check_posed("none", VW_FIELD_HASH, 0);
    check_posed("distortion,sky,unbounded", VW_FIELD_HASH, 0.05);
    check_posed("appearance_code", VW_FIELD_HASH, 0);
    check_posed("distortion,sky", VW_FIELD_SPLATS, 0.05);
}

// A larger picture by the same focal lengths and centre shows the same in its corner. Splats beside the photo are drawn
// with another Jacobian (splats.c), so their edges may differ a little.
TEST(a_posed_camera_has_its_own_size) {
    static const enum vw_field fields[] = {VW_FIELD_HASH, VW_FIELD_SPLATS};
    for (int i = 0; i < 2; i++) {
        struct vw_scene *scene = test_scene();
        struct vw_config config = test_config_of(fields[i]);
        strcpy(config.effects, "none");
        struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 0);
        struct vw_view larger = {.camera = scene->views[2].camera};
        memcpy(larger.camera_to_world, scene->views[2].camera_to_world, sizeof larger.camera_to_world);
        uint32_t width_px = larger.camera.width_px, height_px = larger.camera.height_px;
        larger.camera.width_px *= 3;
        larger.camera.height_px *= 2;
        float *own, *posed;
        ASSERT_OK(vw_trainer_render(trainer, 2, &own));
        ASSERT_OK(vw_trainer_render_posed(trainer, 2, &larger, false, &posed));
        for (uint32_t y = 0; y < height_px; y++)
            for (uint32_t x = 0; x < 3 * width_px; x++)
                assert_float_equal(posed[3 * (3 * y * width_px + x / 3) + x % 3],
                                   own[3 * (y * width_px + x / 3) + x % 3], 1e-3);
        for (uint32_t value = 0; value < 18 * width_px * height_px; value++) assert_true(isfinite(posed[value]));
        free(own), free(posed);
        test_release(trainer);
    }
}

// ---- Depths ---------------------------------------------------------------------------------------------------------

// Renders the depth at the box's centre from `away` half extents before it, turned by so many degrees, of which the
// pixel's place makes up.
static float central_depth(struct vw_trainer *trainer, double scale, double away, double turned_deg) {
    double c = cos(turned_deg * M_PI / 180), s = sin(turned_deg * M_PI / 180), focal_px = 50 * away;
    struct vw_view posed = {.camera = {.width_px = 1,
                                       .height_px = 1,
                                       .focal_x_px = focal_px,
                                       .focal_y_px = focal_px,
                                       .centre_x_px = 0.5 - focal_px * s / c,
                                       .centre_y_px = 0.5}};
    const double pose[3][4] = {{-s, 0, c, away * scale}, {c, 0, s, 0}, {0, 1, 0, 0}};
    memcpy(posed.camera_to_world, pose, sizeof pose);
    float *depth, value;
    ASSERT_OK(vw_trainer_render_posed(trainer, 0, &posed, true, &depth));
    value = depth[0];
    free(depth);
    return value;
}

// A camera that steps back sees the same as much farther, within the box; one that turns sees the share of the way that
// is along its axis.
TEST(depths_are_along_the_axis_in_world_units) {
    static const struct {
        const char *effects;
        enum vw_field field;
        double tolerance;
    } cases[] = {{"none", VW_FIELD_HASH, 1e-3},
                 {"unbounded", VW_FIELD_HASH, 0.4}, // its samples move with the camera
                 {"none", VW_FIELD_SPLATS, 0.15}};  // drawn by another Jacobian
    const double scale = 7;
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        struct vw_scene *scene = synthetic_scene(&(struct synthetic_scene_params){
            .train_views = 5, .val_views = TEST_VALS, .width_px = 24, .height_px = 18, .world_scale = scale});
        struct vw_config config = test_config_of(cases[i].field);
        strcpy(config.effects, cases[i].effects);
        struct test_run *run = calloc(1, sizeof *run);
        struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 0);
        test_run_advance(trainer, run);
        double depth = central_depth(trainer, scale, 3, 0), tolerance = cases[i].tolerance * scale;
        assert_true(depth > 2 * scale - tolerance && (i == 1 || depth < 4 * scale));
        assert_near(central_depth(trainer, scale, 3.5, 0), depth + 0.5 * scale, tolerance);
        if (i != 1) // where rays begin near the box
            assert_near(central_depth(trainer, scale, 9, 0), depth + 6 * scale, 2 * tolerance);
        assert_near(central_depth(trainer, scale, 3, 40), depth * cos(40 * M_PI / 180), tolerance);
        free(run);
        test_release(trainer);
    }
}

TEST_GROUP(NULL, test_gpu_close)
