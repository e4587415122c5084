// Samples placed by importance, and a learning rate that decays, through the whole trainer: every field learns with
// them, the same run has the same bits however its steps are grouped and where it was cut, and validation stays pure.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "reference/step_bench.h"
#include "support/temporary_folder.h"
#include "support/trainer_fixture.h"

static struct vw_config config_of(enum vw_field field) {
    struct vw_config config = test_config_of(field);
    config.samples = 8;
    config.importance_samples = 12;
    config.learning_rate_decay = 0.05;
    return config;
}

TEST(every_field_learns_with_them) {
    struct vw_scene *scene = test_scene();
    for (enum vw_field field = 0; field < VW_FIELD_COUNT; field++) {
        struct vw_config config = config_of(field);
        config.epochs = 12;
        config.learning_rate_decay = 0.3;
        test_run_assert_learns(scene, &config, 0.7);
    }
}

// Stopped within the planned steps, which decide how the rate decays, and taken up by another trainer.
TEST(a_run_in_parts_is_the_run) {
    struct vw_scene *scene = test_scene();
    const struct vw_config config = config_of(VW_FIELD_HASH);
    struct test_run *whole = test_run(scene, &config, true, 0), *parts = test_run_in_parts(scene, &config);
    test_run_assert_same(whole, parts);
}

// Measures the colours of all validation rays anew.
static vw_float4 *measure_again(struct vw_trainer *trainer, uint32_t *count) {
    struct vw_evaluator *evaluator = &trainer->validation.evaluator;
    vw_float4 *colours = test_allocate(evaluator->ray_count, sizeof *colours);
    ASSERT_OK(vw_evaluator_run(evaluator));
    ASSERT_OK(vw_buffer_read(evaluator->colours, 0, colours, evaluator->ray_count * sizeof *colours));
    *count = evaluator->ray_count;
    return colours;
}

// Decision 1: the same params give the same bits, whatever was rendered between.
TEST(validation_is_pure) {
    struct vw_scene *scene = test_scene();
    for (enum vw_field field = 0; field < VW_FIELD_COUNT; field++) {
        const struct vw_config config = config_of(field);
        struct test_run *with = test_run(scene, &config, true, 4), *without = test_run(scene, &config, false, 4);
        assert_memory_equal(with->params, without->params, 4 * with->param_words);
        struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 4);
        struct test_run *run = test_allocate(1, sizeof *run);
        float *rgb = NULL;
        uint32_t count = 0;
        test_run_finish(trainer, run);
        vw_float4 *first = measure_again(trainer, &count);
        ASSERT_OK(vw_trainer_render(trainer, 0, &rgb));
        vw_float4 *second = measure_again(trainer, &count);
        assert_memory_equal(first, second, count * sizeof *first);
        free(rgb);
        test_release(trainer);
        test_release(run);
        test_release(with);
        test_release(without);
    }
}

static double moved_by(struct step_bench *bench, uint64_t number, float extra) {
    step_bench_write_params(bench);
    vw_submission_begin(bench->submission);
    vw_step_record_gradients(&bench->step, bench->submission, 1, 0); // the same for all numbers
    vw_step_record_update(&bench->step, bench->submission, number, extra);
    step_bench_submit(bench);
    float *params = step_bench_read(bench, bench->field.params);
    double sum = 0.0;
    for (size_t i = 0; i < bench->model.param_bytes / sizeof *params; i++) sum += fabs(params[i] - bench->params[i]);
    return sum;
}

// Plain descent makes a step as long as its rate.
TEST(the_rate_falls_to_its_share_at_the_last_planned_step) {
    const struct step_case setup = {.name = "decay",
                                    .seed = 41,
                                    .levels = 2,
                                    .width = 16,
                                    .samples = 16,
                                    .learning_rate = 1.0,
                                    .optimizer = VW_OPTIMIZER_SGD};
    struct step_bench *bench = step_bench_open(&setup);
    double constant = moved_by(bench, 7, 0.0f);
    assert_true(constant > 0.0);
    bench->model.learning_rate_decay = 0.01;
    bench->model.planned_steps = 11;
    const struct {
        uint64_t number;
        double share;
    } cases[] = {{1, 1.0}, {6, 0.1}, {11, 0.01}, {12, 0.01}, {UINT64_MAX, 0.01}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        double moved = moved_by(bench, cases[i].number, 0.0f) / constant;
        if (!(fabs(moved - cases[i].share) < 1e-3 * cases[i].share))
            fail_msg("step %llu moves by %g, not %g", (unsigned long long)cases[i].number, moved, cases[i].share);
    }
    assert_true(fabs(moved_by(bench, 6, 0.5f) / constant - 0.15) < 1e-3); // as the gate of lasting credit asks
    bench->model.planned_steps = 1;
    assert_true(vw_model_rate_of_step(&bench->model, 1) == 1.0);
}

TEST(the_planned_epochs_count) {
    struct vw_scene *scene = test_scene();
    struct vw_config config = config_of(VW_FIELD_HASH), longer;
    struct vw_trainer *trainer = test_trainer_create(scene, &config, false, 0);
    assert_int_equal(trainer->model.planned_steps, vw_trainer_total_steps(trainer));
    longer = config;
    longer.epochs++;
    for (int decays = 1; decays >= 0; decays--) { // else a run may be extended
        if (!decays) config.learning_rate_decay = longer.learning_rate_decay = 1.0;
        char *one = vw_config_to_json(&config, true), *two = vw_config_to_json(&longer, true);
        assert_int_equal(strcmp(one, two) != 0, decays);
        free(one);
        free(two);
    }
}

TEST(what_cannot_be_is_refused_by_name) {
    struct vw_effect_verdict verdicts[VW_EFFECT_COUNT_MAX];
    struct vw_config config = config_of(VW_FIELD_HASH);
    uint32_t count;
    for (int named = 0; named < 2; named++) {
        vw_effects_list(verdicts, &count);
        for (uint32_t i = 0; i < count; i++)
            verdicts[i].on = strcmp(verdicts[i].name, "unbounded") != 0; // not with pose
        strcpy(config.effects, named ? "+occupancy" : "auto");
        assert_int_equal(vw_effects_follow_field(&config, verdicts, count), named ? VW_ERROR_USAGE : VW_OK);
        if (named) assert_non_null(strstr(vw_error_message(), "occupancy is not there with --importance-samples"));
        else assert_false(vw_effects_is_on(verdicts, count, "occupancy"));
    }
    config.importance_samples = 4096;
    config.rays = 4097;
    ASSERT_FAILS(vw_config_check(&config), VW_ERROR_USAGE, "--rays times --importance-samples is 16781312");
    config = config_of(VW_FIELD_HASH);
    config.learning_rate_decay = 1.5;
    ASSERT_FAILS(vw_config_check(&config), VW_ERROR_USAGE, "--learning-rate-decay takes");
}

TEST_GROUP(NULL, test_gpu_close)
