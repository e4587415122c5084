// The learning rate that decays: to which share, and over which steps.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "reference/step_bench.h"
#include "support/trainer_fixture.h"

static double moved_by(struct step_bench *bench, uint64_t number, float extra) {
    step_bench_write_params(bench);
    vw_submission_begin(bench->submission);
    vw_step_record_gradients(&bench->step, bench->submission, 1, 0); // the same for all numbers
    vw_step_record_update(&bench->step, bench->submission, number, 0, extra);
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
    assert_true(vw_model_rate_factor_of_step(&bench->model, 1) == 1.0);
}

TEST(the_planned_steps_are_those_of_the_run) {
    struct vw_config config = test_config();
    config.learning_rate_decay = 0.05;
    struct vw_trainer *trainer = test_trainer_create(test_scene(), &config, false, 0);
    assert_int_equal(trainer->model.planned_steps, vw_trainer_total_steps(trainer));
}

TEST_GROUP(NULL, test_gpu_close)
