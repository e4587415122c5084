// The effect pose in whole trainings: that off it takes no room, that bits do not depend on batches and survive a
// checkpoint, that validation sees all cameras as the scene has them, what is refused, and that it mends wrong cameras.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "reference/pose.h"
#include "reference/step_bench.h"
#include "support/trainer_fixture.h"
#include "train/adjoint/lasting.h"
#include "train/fields/registry.h"

static struct vw_config config_with(const char *effects) {
    struct vw_config config = test_config();
    strcpy(config.effects, effects);
    config.epochs = 20; // so that cameras move before a checkpoint, too
    return config;
}

TEST(what_is_off_takes_no_room) {
    struct vw_scene *scene = test_scene();
    struct vw_config off = config_with("none"), on = config_with("pose");
    struct vw_trainer *without = test_trainer_create(scene, &off, true, 1),
                      *with = test_trainer_create(scene, &on, true, 1);
    test_trainer_has_no_effects(without);
    assert_int_equal(without->model.param_bytes, without->model.grid.size_bytes + without->model.weights.size_bytes);
    assert_int_equal(with->model.param_count - without->model.param_count, 5 * 6);
    vw_trainer_destroy(&without);
    vw_trainer_destroy(&with);
    vw_scene_close(&scene);
}

TEST(bits_do_not_depend_on_batches_or_parts) {
    static const char *const effects[] = {"pose", "pose,sky,appearance,appearance_code,visibility",
                                          "pose,occupancy,distortion"};
    struct vw_scene *scene = test_scene();
    for (size_t i = 0; i < VW_ARRAY_COUNT(effects); i++) {
        struct vw_config config = config_with(effects[i]);
        config.beta1 = i == 1 ? 0.9 : 0.0;
        config.rays = i == 2 ? 1200 : 60; // several chunks
        config.epochs = i == 2 ? 8 : config.epochs;
        struct test_run *one = test_run(scene, &config, true, 1), *many = test_run(scene, &config, true, 7),
                        *parts = test_run_in_parts(scene, &config);
        test_run_assert_same(one, many);
        test_run_assert_same(one, parts);
        assert_int_equal(one->stats.nonfinite_steps, 0);
        test_run_free(one);
        test_run_free(many);
        test_run_free(parts);
    }
    vw_scene_close(&scene);
}

// Decision 1: the same field renders the same, in train photos too, whatever the corrections. Photos that are not
// trained on keep none.
TEST(validation_does_not_know_it) {
    struct vw_scene *scene = test_scene();
    struct vw_config on = config_with("pose"), off = config_with("none");
    struct test_run *run = vw_allocate(1, sizeof *run);
    struct vw_trainer *trained = test_trainer_create(scene, &on, true, 0),
                      *plain = test_trainer_create(scene, &off, true, 0);
    float *expected = NULL, *found = NULL;
    test_run_finish(trained, run);
    ASSERT_OK(vw_buffer_write(plain->field.params, 0, run->params, plain->model.param_bytes));
    for (uint32_t view = 0; view < 6; view += 5) { // trained on, and not
        double pose[REFERENCE_POSE];
        reference_pose_of(&trained->model, (const float *)run->params, view, pose);
        assert_true(view == 5 ? largest(pose, REFERENCE_POSE) == 0.0 : largest(pose, REFERENCE_POSE) > 0.0);
        ASSERT_OK(vw_trainer_render(trained, view, &found));
        ASSERT_OK(vw_trainer_render(plain, view, &expected));
        const struct vw_image *image = &scene->views[view].image;
        assert_memory_equal(found, expected, 3 * sizeof(float) * image->width_px * image->height_px);
        free(expected);
        free(found);
        expected = found = NULL;
    }
    vw_trainer_destroy(&trained);
    vw_trainer_destroy(&plain);
    test_run_free(run);
    vw_scene_close(&scene);
}

TEST(what_it_cannot_be_beside_is_refused_by_name) {
    struct vw_effect_verdict verdicts[VW_EFFECT_COUNT_MAX];
    uint32_t count;
    struct vw_config config = test_config_of(VW_FIELD_MLP);
    vw_effects_list(verdicts, &count);
    for (uint32_t i = 0; i < count; i++) verdicts[i].on = !strcmp(verdicts[i].name, "pose");
    strcpy(config.effects, "+pose");
    ASSERT_FAILS(vw_effects_follow_field(&config, verdicts, count), VW_ERROR_USAGE,
                 "pose is not there with --field mlp");
    config = config_with("+pose");
    assert_int_equal(vw_effects_follow_field(&config, verdicts, count), VW_OK);
    for (uint32_t i = 0; i < count; i++) verdicts[i].on |= !strcmp(verdicts[i].name, "unbounded");
    ASSERT_FAILS(vw_effects_follow_field(&config, verdicts, count), VW_ERROR_USAGE, "pose cannot be beside unbounded");
}

TEST(the_sweep_refuses_it_by_name) {
    struct vw_config config = config_with("pose");
    struct vw_scene *scene = test_scene();
    struct vw_trainer_params training = {.gpu = test_gpu(), .scene = scene, .config = &config, .validate = true};
    struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 0);
    training.effects = vw_trainer_effects(trainer, &training.effect_count);
    struct vw_lasting *lasting = NULL;
    ASSERT_FAILS(vw_lasting_create(&(struct vw_lasting_params){.training = &training}, &lasting), VW_ERROR_USAGE,
                 "--effects -pose");
    vw_trainer_destroy(&trainer);
    vw_scene_close(&scene);
}

// ---- Wrong cameras --------------------------------------------------------------------------------------------------

// What is wrong with the camera of a train photo: about a degree, and a hundredth of the box.
static void draw_error(uint32_t view, double error[REFERENCE_POSE]) {
    for (int i = 0; i < REFERENCE_POSE; i++) error[i] = (i < 3 ? 0.01 : 0.02) * sin(1.0 + 2.3 * view + 1.7 * i);
}

static void move_cameras(struct vw_scene *scene, struct vw_view *true_views) {
    for (uint32_t view = 0; view < scene->view_count; view++) {
        double error[REFERENCE_POSE];
        true_views[view] = scene->views[view];
        if (scene->views[view].split != VW_SPLIT_TRAIN) continue;
        draw_error(view, error);
        scene->views[view] = reference_pose_apply(&scene->views[view], &scene->box, error);
    }
}

// Of the train cameras, in box edges: how far off is what they see at the distance of a box edge.
static double error_of_cameras(const struct vw_scene *scene, const struct vw_view *true_views,
                               const struct vw_trainer *trainer, const uint32_t *params) {
    double sum = 0.0;
    for (uint32_t view = 0; view < scene->view_count; view++) {
        double pose[REFERENCE_POSE] = {0}, off2 = 0.0, edge_world = 2.0 * scene->box.half_extent_world;
        if (scene->views[view].split != VW_SPLIT_TRAIN) continue;
        if (params) reference_pose_of(&trainer->model, (const float *)params, view, pose);
        struct vw_view found = reference_pose_apply(&scene->views[view], &scene->box, pose);
        for (int i = 0; i < 3; i++)
            off2 += pow((found.camera_to_world[i][3] - true_views[view].camera_to_world[i][3]) / edge_world -
                            (found.camera_to_world[i][2] - true_views[view].camera_to_world[i][2]),
                        2.0);
        sum += sqrt(off2) / scene->split_count[VW_SPLIT_TRAIN];
    }
    return sum;
}

// What a run tells of them: turns are 2 atan(half their length).
static void check_corrections(const struct vw_scene *scene, const struct vw_trainer *trainer, const uint32_t *params) {
    struct vw_camera_corrections told, expected = {0};
    uint32_t photos = scene->split_count[VW_SPLIT_TRAIN];
    for (uint32_t view = 0; view < scene->view_count; view++) {
        double pose[REFERENCE_POSE];
        if (scene->views[view].split != VW_SPLIT_TRAIN) continue;
        reference_pose_of(&trainer->model, (const float *)params, view, pose);
        double edges = sqrt(pose[0] * pose[0] + pose[1] * pose[1] + pose[2] * pose[2]),
               half = 0.5 * sqrt(pose[3] * pose[3] + pose[4] * pose[4] + pose[5] * pose[5]),
               deg = 2.0 * atan(half) * 180.0 / M_PI;
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
}

// Seen: 1.1 dB, and cameras off by half of what they were.
TEST(wrong_cameras_are_mended) {
    struct vw_scene *scene = NULL;
    double psnr[2], error[2];
    ASSERT_OK(vw_scene_open(&(struct vw_scene_params){.path = VW_SOURCE_FOLDER "/scenes/clean.json", .gpu = test_gpu()},
                            &scene));
    struct vw_view *true_views = vw_allocate(scene->view_count, sizeof *true_views);
    move_cameras(scene, true_views);
    for (int with = 0; with < 2; with++) {
        struct vw_config config = config_with(with ? "pose" : "none");
        config.epochs = 30;
        config.rays = 100;
        config.levels = 6;
        struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 0);
        struct test_run *run = vw_allocate(1, sizeof *run);
        test_run_finish(trainer, run);
        psnr[with] = 0.0;
        for (uint32_t i = run->count - 20; i < run->count; i++) psnr[with] += run->records[i].val_psnr / 20.0;
        error[with] = error_of_cameras(scene, true_views, trainer, with ? run->params : NULL);
        if (with) check_corrections(scene, trainer, run->params);
        vw_trainer_destroy(&trainer);
        test_run_free(run);
    }
    print_message("%.2f dB with pose, %.2f without; cameras are off by %.4f box edges, were by %.4f\n", psnr[1],
                  psnr[0], error[1], error[0]);
    assert_true(psnr[1] > psnr[0] + 0.5);
    assert_true(error[1] < 0.7 * error[0]);
    free(true_views);
    vw_scene_close(&scene);
}

TEST_GROUP(NULL, test_gpu_close)
