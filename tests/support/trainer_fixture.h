// Whole trainings on a small scene, kept row by row. Every function stops the test, with the reason, when it cannot do
// its work; what it returns is the test's (cmocka_test.h). For programs that use test_gpu().
#ifndef VIEWWORTH_TESTS_SUPPORT_TRAINER_FIXTURE_H
#define VIEWWORTH_TESTS_SUPPORT_TRAINER_FIXTURE_H

#include "support/gpu_fixture.h"
#include "support/synthetic_scene.h"
#include "train/trainer.h"
#include "train/trainer_private.h"

enum { TEST_VALS = 3, TEST_STEPS_MAX = 4096 };

// Returns 3 epochs of small steps of a small field, on 5 photos; TEST_VALS more validate.
struct vw_config test_config(void);
struct vw_config test_config_of(enum vw_field field);   // the same of a small field of another kind
struct vw_config test_config_with(const char *effects); // the same with exactly these
struct vw_scene *test_scene(void);
void test_exclude(struct vw_scene *scene, uint32_t view); // from the photos to train on
// Hides a part of its photos, one whole.
void test_hide_some(struct vw_scene *scene);

// Decides the effects by config->effects and the scene alone, without a pilot run, unless `params` has some. The device
// is test_gpu() unless it has one. The first returns the status.
enum vw_status test_trainer_try(struct vw_trainer_params params, struct vw_trainer **trainer);
struct vw_trainer *test_trainer_open(struct vw_trainer_params params);
struct vw_trainer *test_trainer_create(const struct vw_scene *scene, const struct vw_config *config, bool validate,
                                       uint32_t steps_per_submission);
// Returns submissions that trainers share, which the test owns.
struct vw_submissions *test_submissions(void);

struct test_run {
    struct vw_step_record records[TEST_STEPS_MAX];         // without views
    struct vw_view_error views[TEST_STEPS_MAX][TEST_VALS]; // the first ones of a scene of more
    uint32_t count;
    uint32_t param_words;
    uint32_t *params; // as the run left them
    struct vw_trainer_stats stats;
};

// Trains a whole run.
struct test_run *test_run(const struct vw_scene *scene, const struct vw_config *config, bool validate,
                          uint32_t steps_per_submission);
// Trains a run that is stopped after 2 steps per epoch and taken up by another trainer from a checkpoint.
struct test_run *test_run_in_parts(const struct vw_scene *scene, const struct vw_config *config);
// Adds records as the trainer lends them.
void test_run_keep(struct test_run *run, const struct vw_step_record *records, uint32_t count);
// Takes steps until none is handed out: to the end, or where the trainer is held.
void test_run_advance(struct vw_trainer *trainer, struct test_run *run);
// Takes the steps that are left and reads the params.
void test_run_finish(struct vw_trainer *trainer, struct test_run *run);
// Trains a whole run with a trainer that has taken no step.
struct test_run *test_run_of(struct vw_trainer *trainer);

bool test_same_bits(double a, double b);
// Asserts that rows and params are the same, bit for bit.
void test_run_assert_same(const struct test_run *a, const struct test_run *b);

#endif
