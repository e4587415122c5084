// The effect pose in whole trainings: it mends wrong cameras. (What all effects promise: test_effect_promises.)
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "reference/effects/pose.h"
#include "reference/step_bench.h"
#include "support/trainer_fixture.h"

static struct vw_config config_with(const char *effects) {
    struct vw_config config = test_config();
    strcpy(config.effects, effects);
    config.epochs = 20; // so that cameras move before a checkpoint, too
    return config;
}

// Draws the error of a train photo's camera: about a degree, and a hundredth of the box.
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

// Returns the mean error of the train cameras, in box edges: how far off is what they see at the distance of a box
// edge.
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

// Checks what a run tells of the corrections: turns are 2 atan(half their length).
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
    double psnr[2], error[2];
    struct vw_scene *scene = test_scene_open((struct vw_scene_params){.path = VW_SOURCE_FOLDER "/scenes/clean.json"});
    struct vw_view *true_views = test_allocate(scene->view_count, sizeof *true_views);
    move_cameras(scene, true_views);
    for (int with = 0; with < 2; with++) {
        struct vw_config config = config_with(with ? "pose" : "none");
        config.epochs = 30;
        config.rays = 100;
        config.levels = 6;
        struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 0);
        struct test_run *run = test_run_of(trainer);
        psnr[with] = 0.0;
        for (uint32_t i = run->count - 20; i < run->count; i++) psnr[with] += run->records[i].val_psnr / 20.0;
        error[with] = error_of_cameras(scene, true_views, trainer, with ? run->params : NULL);
        if (with) check_corrections(scene, trainer, run->params);
        test_release(trainer);
        test_release(run);
    }
    print_message("%.2f dB with pose, %.2f without; cameras are off by %.4f box edges, were by %.4f\n", psnr[1],
                  psnr[0], error[1], error[0]);
    assert_true(psnr[1] > psnr[0] + 0.5);
    assert_true(error[1] < 0.7 * error[0]);
}

TEST_GROUP(NULL, test_gpu_close)
