// Coverage: that it follows its formula, that copies share it, that it looks at cameras and not at colours, and that it
// leaves the training alone.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "support/trainer_fixture.h"
#include "train/coverage.h"

enum { TRAINS = 5, PASSES = 2 }; // photos of test_scene()

enum { ENTRIES = 4 };
// Of photos with information a, b, ...: the coverage of the first.
static double coverage_of_first(const double (*informations)[ENTRIES], uint32_t photos, double prior) {
    double total[ENTRIES] = {0};
    for (uint32_t i = 0; i < photos; i++)
        for (uint32_t k = 0; k < ENTRIES; k++) total[k] += informations[i][k];
    return vw_coverage_of(total, informations[0], ENTRIES, prior);
}

TEST(coverage_follows_its_formula) {
    const double photos[][ENTRIES] = {{2.0, 0.0, 1e-3, 5.0}, {0.0, 7.0, 4.0, 5.0}};
    double expected = log((0.1 + 2.0) / 0.1) + log((0.1 + 4.001) / (0.1 + 4.0)) + log((0.1 + 10.0) / (0.1 + 5.0));
    assert_true(fabs(coverage_of_first(photos, 2, 0.1) - expected) < 1e-12);
    const double total[] = {0.0, 3.0, 0.0, 1.0};
    assert_true(fabs(vw_coverage_prior(total, 4) - coverage_prior_share * 2.0) < 1e-15);
    assert_true(vw_coverage_prior(total, 1) > 0.0); // nothing informs of anything
}

TEST(copies_share_their_coverage) {
    const double photos[][ENTRIES] = {{2.0, 0.0, 1.0, 5.0}, {2.0, 0.0, 1.0, 5.0}, {2.0, 0.0, 1.0, 5.0}};
    double alone = coverage_of_first(photos, 1, 0.1), two = coverage_of_first(photos, 2, 0.1),
           three = coverage_of_first(photos, 3, 0.1);
    assert_true(three < two && two < alone);
    assert_true(2.0 * two < alone); // what one photo covers by itself, its copies cover for each other
}

static void measure(const struct vw_scene *scene, double coverage[TRAINS]) {
    struct vw_config config = test_config();
    struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 0);
    struct test_run *run = vw_allocate(1, sizeof *run);
    test_run_finish(trainer, run);
    ASSERT_OK(vw_trainer_measure_coverage(trainer, PASSES, coverage));
    test_run_free(run);
    vw_trainer_destroy(&trainer);
}

TEST(coverage_is_of_cameras) {
    struct vw_scene *scene = test_scene();
    double before[TRAINS], copied[TRAINS], away[TRAINS];
    measure(scene, before);
    for (uint32_t i = 0; i < TRAINS; i++) assert_true(before[i] > 0.0);
    struct vw_view *first = &scene->views[0], *second = &scene->views[1]; // of other colours
    memcpy(second->camera_to_world, first->camera_to_world, sizeof first->camera_to_world);
    measure(scene, copied);
    assert_true(test_same_bits(copied[0], copied[1]));
    assert_true(copied[0] < before[0]);
    for (int row = 0; row < 3; row++) second->camera_to_world[row][2] *= -1.0; // looks away
    measure(scene, away);
    assert_true(away[1] == 0.0 && away[0] > copied[0]);
    vw_scene_close(&scene);
}

// It does not depend on the loss of the training either.
TEST(coverage_is_of_the_field_alone) {
    struct vw_scene *scene = test_scene();
    struct vw_config config = test_config();
    double coverage[3][TRAINS];
    for (enum vw_loss loss = VW_LOSS_L1; loss <= VW_LOSS_HUBER; loss++) {
        config.loss = loss;
        struct vw_trainer *untrained = test_trainer_create(scene, &config, false, 0);
        ASSERT_OK(vw_trainer_measure_coverage(untrained, PASSES, coverage[loss]));
        assert_memory_equal(coverage[0], coverage[loss], sizeof coverage[0]);
        vw_trainer_destroy(&untrained);
    }
    vw_scene_close(&scene);
}

TEST(measuring_changes_no_bit) {
    struct vw_scene *scene = test_scene();
    struct vw_config config = test_config();
    struct test_run *whole = test_run(scene, &config, true, 1), *interrupted = vw_allocate(1, sizeof *interrupted);
    struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 1);
    const struct vw_step_record *records;
    uint32_t count;
    double once[TRAINS], again[TRAINS];
    vw_trainer_stop_after(trainer, TRAINS);
    do {
        ASSERT_OK(vw_trainer_advance(trainer, &records, &count));
        test_run_keep(interrupted, records, count);
    } while (count > 0);
    ASSERT_OK(vw_trainer_measure_coverage(trainer, PASSES, once));
    ASSERT_OK(vw_trainer_measure_coverage(trainer, PASSES, again));
    assert_memory_equal(once, again, sizeof once);
    vw_trainer_stop_after(trainer, vw_trainer_total_steps(trainer));
    test_run_finish(trainer, interrupted);
    test_run_assert_same(whole, interrupted);
    test_run_free(whole);
    test_run_free(interrupted);
    vw_trainer_destroy(&trainer);
    vw_scene_close(&scene);
}

TEST_GROUP(NULL, test_gpu_close)
