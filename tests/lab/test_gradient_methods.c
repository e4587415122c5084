// Methods that need gradients and no retraining: In-Run Data Shapley against what steps really change, TracIn against
// small steps that are really taken, and influence functions against another way to solve for them.
// label: device
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "base/statistics.h"
#include "lab/gradients/gradient_methods.h"
#include "lab/gradients/influence_private.h"
#include "support/trainer_fixture.h"

enum { TRAINS = 5, EPOCHS = 12, STEPS = EPOCHS * TRAINS }; // photos of test_scene()

static struct vw_config gradient_config(void) {
    struct vw_config config = test_config();
    config.epochs = EPOCHS;
    config.rays = 120;
    config.loss = VW_LOSS_L2;
    strcpy(config.effects, "none");
    return config;
}

struct opened {
    struct vw_scene *scene;
    struct vw_config config;
    struct vw_trainer *trainer; // lends its effects
    struct vw_trainer_params training;
    struct vw_gradient_params params;
};

static void open_training(struct opened *opened, const struct vw_config *config) {
    *opened = (struct opened){.scene = test_scene(), .config = *config};
    opened->trainer = test_trainer_create(opened->scene, &opened->config, true, 0);
    opened->training = (struct vw_trainer_params){
        .gpu = test_gpu(), .scene = opened->scene, .config = &opened->config, .validate = true};
    opened->training.effects = vw_trainer_effects(opened->trainer, &opened->training.effect_count);
    opened->params = (struct vw_gradient_params){.training = &opened->training};
}

static enum vw_status compare_replayed(void *context, const struct vw_step_record *record) {
    const struct test_run *run = context;
    assert_true(test_same_bits(record->train_loss, run->records[record->step].train_loss));
    return VW_OK;
}

// ---- In-Run Data Shapley --------------------------------------------------------------------------------------------

static void find_changes(const struct test_run *run, double *changes) {
    for (uint32_t i = 0; i < STEPS; i++) changes[i] = run->records[i + 1].val_psnr - run->records[i].val_psnr;
}

static double slope_of(const double *predicted, const double *measured, uint32_t count) {
    double products = 0, squares = 0;
    for (uint32_t i = 0; i < count; i++) {
        products += predicted[i] * measured[i];
        squares += predicted[i] * predicted[i];
    }
    return products / squares;
}

static double distance_of(const double *predicted, const double *measured, uint32_t count) {
    double sum = 0;
    for (uint32_t i = 0; i < count; i++) sum += fabs(predicted[i] - measured[i]);
    return sum;
}

static double sum_of(const double *values, uint32_t count) {
    double sum = 0;
    for (uint32_t i = 0; i < count; i++) sum += values[i];
    return sum;
}

// Checks that the first order uses the gradient before the step, one step after the other.
static void check_first_order(const struct opened *opened, const struct vw_in_run_credit *credits) {
    struct vw_gradient_replay gradient_replay;
    ASSERT_OK(vw_gradient_replay_create(&opened->params, &gradient_replay));
    for (uint64_t step = 2; step <= 30; step += 14) {
        ASSERT_OK(vw_gradient_replay_go_to(&gradient_replay, step - 1));
        vw_submission_begin(gradient_replay.replay.submission);
        vw_gradient_replay_record_validation(&gradient_replay, 0);
        vw_gradient_replay_record_step(&gradient_replay, step, vw_step_replay_draw(&gradient_replay.replay, step, 0),
                                       0);
        vw_gradient_replay_record_multiply(&gradient_replay, false, 0);
        ASSERT_OK(vw_step_replay_run(&gradient_replay.replay));
        gradient_replay.step = step;
        assert_true(test_same_bits(vw_gradient_replay_read(&gradient_replay, 0), credits[step - 1].first_order));
    }
    vw_gradient_replay_destroy(&gradient_replay);
}

static void credit_training(double learning_rate, double beta1, const char *effects, double *first, double *second,
                            double *changes) {
    struct vw_config config = gradient_config();
    struct opened opened;
    struct vw_in_run_credit credits[STEPS] = {0}, again[STEPS] = {0};
    config.learning_rate = learning_rate;
    config.beta1 = beta1;
    strcpy(config.effects, effects);
    open_training(&opened, &config);
    struct test_run *run = test_run(opened.scene, &config, true, 0);
    opened.params.replayed = compare_replayed;
    opened.params.context = run;
    ASSERT_OK(vw_in_run_credits(&opened.params, credits));
    ASSERT_OK(vw_in_run_credits(&opened.params, again));
    assert_memory_equal(credits, again, sizeof credits);
    check_first_order(&opened, credits);
    for (uint32_t i = 0; i < STEPS; i++) first[i] = credits[i].first_order, second[i] = credits[i].second_order;
    find_changes(run, changes);
}

// Bfloats between passes are what remains: 1 % is seen.
TEST(short_steps_change_what_they_are_credited_with) {
    double first[STEPS], second[STEPS], changes[STEPS];
    credit_training(1e-4, 0, "none", first, second, changes);
    double slope = slope_of(first, changes, STEPS), pearson = vw_pearson(first, changes, STEPS);
    printf("in-run: slope %.4f, Pearson %.5f, off by %.3f and %.3f of the change\n", slope, pearson,
           distance_of(first, changes, STEPS) / fabs(sum_of(changes, STEPS)),
           distance_of(second, changes, STEPS) / fabs(sum_of(changes, STEPS)));
    assert_true(fabs(slope - 1) < 0.05);
    assert_true(pearson > 0.995);
}

TEST(the_second_order_is_nearer_to_what_long_steps_change) {
    static const struct {
        double beta1;
        const char *effects;
    } cases[] = {{0, "none"}, {0.9, "none"}, {0, "appearance,appearance_code"}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        double first[STEPS], second[STEPS], changes[STEPS];
        credit_training(vw_config_default.learning_rate, cases[i].beta1, cases[i].effects, first, second, changes);
        double off_first = distance_of(first, changes, STEPS), off_second = distance_of(second, changes, STEPS),
               total = sum_of(changes, STEPS), // may be little, where steps that help and harm cancel
            size = distance_of(changes, (double[STEPS]){0}, STEPS);
        printf("in-run: off by %.3f and %.3f dB of %.3f; sums %.3f and %.3f\n", off_first, off_second, total,
               sum_of(first, STEPS), sum_of(second, STEPS));
        assert_true(off_second < 0.3 * off_first);
        assert_true(fabs(sum_of(second, STEPS) - total) < 0.1 * size);
        assert_true(vw_pearson(second, changes, STEPS) > 0.98);
    }
}

// ---- TracIn ---------------------------------------------------------------------------------------------------------

// Returns U with the params moved by `factor` times `towards` from the saved state.
static double psnr_towards(struct vw_gradient_replay *gradient_replay, const float *from, const double *towards,
                           double factor) {
    const struct vw_trainer_parts *context = gradient_replay->replay.context;
    uint64_t count = context->field->model->param_bytes / sizeof(float);
    float *moved = test_allocate(count, sizeof *moved);
    for (uint64_t i = 0; i < count; i++) moved[i] = (float)(from[i] + factor * towards[i]);
    ASSERT_OK(vw_buffer_write(context->field->params, 0, moved, count * sizeof *moved));
    vw_submission_begin(gradient_replay->replay.submission);
    vw_validation_record(context->validation, gradient_replay->replay.submission, 0);
    ASSERT_OK(vw_step_replay_run(&gradient_replay->replay));
    return vw_validation_read(context->validation, vw_buffer_map(context->scalars), NULL).val_psnr;
}

static double derivative_of(struct vw_gradient_replay *gradient_replay, const float *from, const double *towards,
                            double factor) {
    return (psnr_towards(gradient_replay, from, towards, factor) -
            psnr_towards(gradient_replay, from, towards, -factor)) /
           (2 * factor);
}

// Measures what a small part of a photo's step, and of plain descent, really changes.
static void measure_photo(struct vw_gradient_replay *gradient_replay, uint32_t photo, uint64_t number, double rate,
                          struct vw_tracin_score *measured) {
    const struct vw_trainer_parts *context = gradient_replay->replay.context;
    uint64_t count = context->field->model->param_bytes / sizeof(float);
    struct vw_submission *submission = gradient_replay->replay.submission;
    vw_submission_begin(submission);
    uint32_t pixel = vw_step_replay_draw_photo(&gradient_replay->replay, context->photo_order->train_views[photo],
                                               number, 1 + photo, 0);
    vw_gradient_replay_record_step(gradient_replay, number, pixel, 0);
    vw_snapshot_record_restore(&gradient_replay->state, submission);
    ASSERT_OK(vw_step_replay_run(&gradient_replay->replay));
    float *before = test_read(gradient_replay->passes.blocks.before),
          *after = test_read(gradient_replay->passes.blocks.after),
          *gradient = test_read(gradient_replay->passes.blocks.gradient);
    double *towards = test_allocate(count, sizeof *towards), size = 0, along = 0;
    for (uint64_t i = 0; i < count; i++) towards[i] = (double)after[i] - before[i];
    measured->preconditioned += derivative_of(gradient_replay, before, towards, 0.05);
    for (uint64_t i = 0; i < count; i++) {
        towards[i] = -rate * gradient[i];
        size += (double)before[i] * before[i];
        along += towards[i] * towards[i];
    }
    measured->plain += derivative_of(gradient_replay, before, towards, 1e-3 * sqrt(size / along));
    ASSERT_OK(vw_buffer_write(context->field->params, 0, before, count * sizeof *before));
}

TEST(tracin_is_what_small_steps_change) {
    struct vw_config config = gradient_config();
    struct opened opened;
    struct vw_gradient_replay gradient_replay;
    struct vw_tracin_score scores[TRAINS], again[TRAINS], measured[TRAINS] = {0};
    struct vw_photo_products products[TRAINS];
    config.burn_in_epochs = 2;
    config.learning_rate_decay = 0.5;
    open_training(&opened, &config);
    ASSERT_OK(vw_tracin_scores(&opened.params, 2, scores));
    ASSERT_OK(vw_tracin_scores(&opened.params, 2, again));
    assert_memory_equal(scores, again, sizeof scores);
    ASSERT_OK(vw_gradient_replay_create(&opened.params, &gradient_replay));
    const uint64_t checkpoints[] = {7 * TRAINS, 12 * TRAINS};
    for (size_t c = 0; c < VW_ARRAY_COUNT(checkpoints); c++) {
        double rate = config.learning_rate *
                      vw_model_rate_factor_of_step(gradient_replay.replay.context->field->model, checkpoints[c] + 1);
        ASSERT_OK(vw_gradient_replay_go_to(&gradient_replay, checkpoints[c]));
        ASSERT_OK(vw_gradient_replay_try_photos(&gradient_replay, checkpoints[c] + 1, products)); // saves the state
        for (uint32_t i = 0; i < TRAINS; i++)
            measure_photo(&gradient_replay, i, checkpoints[c] + 1, rate, &measured[i]);
    }
    vw_gradient_replay_destroy(&gradient_replay);
    for (uint32_t i = 0; i < TRAINS; i++) {
        printf("tracin: %.5g for %.5g, preconditioned %.5g for %.5g\n", scores[i].plain, measured[i].plain,
               scores[i].preconditioned, measured[i].preconditioned);
        assert_true(fabs(scores[i].plain - measured[i].plain) < 0.01 * fabs(measured[i].plain));
        assert_true(fabs(scores[i].preconditioned - measured[i].preconditioned) <
                    0.01 * fabs(measured[i].preconditioned));
    }
}

// ---- Influence functions --------------------------------------------------------------------------------------------

static double product_of(const struct vw_influence *influence, const double *a, const double *b) {
    double sum = 0;
    for (uint64_t i = 0; i < influence->count; i++)
        if (influence->rates[i] > 0) sum += a[i] * b[i] / influence->rates[i];
    return sum;
}

// Applies P H + damping scale to `values`; H is the mean of the products that iterations have counted.
static void apply(struct vw_influence *influence, const double *values, double *result) {
    uint32_t first = influence->first_counted, end = influence->settings.iterations;
    for (uint64_t i = 0; i < influence->count; i++) {
        influence->x[i] = values[i];
        result[i] = influence->settings.damping * influence->scale * values[i];
    }
    for (uint32_t k = first; k < end; k++) {
        ASSERT_OK(vw_influence_multiply(influence, k));
        for (uint64_t i = 0; i < influence->count; i++)
            result[i] += influence->rates[i] * influence->block[i] / (end - first);
    }
}

// Solves by conjugate gradients in the metric of P, where P H + damping scale is symmetric. Leaves the solution in
// `solution`; returns the residual's share of P grad U.
static double solve_by_conjugate_gradients(struct vw_influence *influence, double *solution) {
    uint64_t count = influence->count;
    double *residual = test_allocate(count, sizeof *residual), *towards = vw_allocate(count, sizeof *towards),
           *applied = test_allocate(count, sizeof *applied);
    memcpy(residual, influence->pull, count * sizeof *residual);
    memcpy(towards, residual, count * sizeof *towards);
    memset(solution, 0, count * sizeof *solution);
    double square = product_of(influence, residual, residual), begun = square;
    for (int k = 0; k < 40 && square > 1e-4 * begun; k++) {
        apply(influence, towards, applied);
        double length = square / product_of(influence, towards, applied), before = square;
        for (uint64_t i = 0; i < count; i++) {
            solution[i] += length * towards[i];
            residual[i] -= length * applied[i];
        }
        square = product_of(influence, residual, residual);
        for (uint64_t i = 0; i < count; i++) towards[i] = residual[i] + square / before * towards[i];
    }
    return sqrt(square / begun);
}

// The last step moved the params by its gradient times the rates that influence functions find.
TEST(influence_knows_the_rates) {
    static const struct {
        enum vw_field field;
        enum vw_optimizer optimizer;
    } cases[] = {{VW_FIELD_HASH, VW_OPTIMIZER_LAZY_ADAM},
                 {VW_FIELD_HASH, VW_OPTIMIZER_DENSE_ADAM},
                 {VW_FIELD_HASH, VW_OPTIMIZER_SGD},
                 {VW_FIELD_MLP, VW_OPTIMIZER_LAZY_ADAM}};
    for (size_t c = 0; c < VW_ARRAY_COUNT(cases); c++) {
        struct vw_config config = test_config_of(cases[c].field);
        struct opened opened;
        struct vw_influence influence;
        struct vw_gradient_replay gradient_replay;
        uint64_t moved = 0, wrong = 0;
        config.optimizer = cases[c].optimizer;
        config.learning_rate_decay = 0.5;
        strcpy(config.effects, "none");
        open_training(&opened, &config);
        ASSERT_OK(vw_influence_create(&opened.params, &(struct vw_influence_settings){0}, &influence));
        ASSERT_OK(vw_gradient_replay_create(&opened.params, &gradient_replay));
        uint64_t last = gradient_replay.replay.total_steps;
        ASSERT_OK(vw_gradient_replay_go_to(&gradient_replay, last - 1));
        vw_submission_begin(gradient_replay.replay.submission);
        vw_gradient_replay_record_step(&gradient_replay, last, vw_step_replay_draw(&gradient_replay.replay, last, 0),
                                       0);
        ASSERT_OK(vw_step_replay_run(&gradient_replay.replay));
        float *before = test_read(gradient_replay.passes.blocks.before),
              *after = test_read(gradient_replay.passes.blocks.after),
              *gradient = test_read(gradient_replay.passes.blocks.gradient);
        for (uint64_t i = 0; i < influence.count; i++) {
            double by = (double)before[i] - after[i], expected = influence.rates[i] * gradient[i];
            moved += gradient[i] != 0.0f;
            wrong += fabs(by - expected) > 1e-3 * fabs(expected) + 1.2e-7 * fabs(before[i]);
        }
        if (wrong || moved < 100)
            fail_msg("case %zu: %llu rates of %llu are wrong", c, (unsigned long long)wrong, (unsigned long long)moved);
        vw_gradient_replay_destroy(&gradient_replay);
        vw_influence_destroy(&influence);
    }
}

// Were H 1 / P, what is gained by a photo would be what plain descent on it gains.
TEST(a_photo_that_helps_has_influence_above_zero) {
    struct vw_config config = gradient_config();
    struct opened opened;
    struct vw_influence influence;
    struct vw_gradient_replay gradient_replay;
    struct vw_photo_products products[TRAINS];
    double scores[TRAINS], size = 0;
    config.optimizer = VW_OPTIMIZER_SGD;
    config.learning_rate = 0.1;
    open_training(&opened, &config);
    ASSERT_OK(vw_influence_create(&opened.params, &(struct vw_influence_settings){.draws = 1}, &influence));
    memcpy(influence.mean, influence.pull, influence.count * sizeof *influence.pull);
    ASSERT_OK(vw_influence_score(&influence, scores));
    vw_influence_destroy(&influence);
    ASSERT_OK(vw_gradient_replay_create(&opened.params, &gradient_replay));
    ASSERT_OK(vw_gradient_replay_go_to(&gradient_replay, STEPS));
    vw_submission_begin(gradient_replay.replay.submission);
    vw_gradient_replay_record_validation(&gradient_replay, 0);
    ASSERT_OK(vw_step_replay_run(&gradient_replay.replay));
    ASSERT_OK(vw_gradient_replay_try_photos(&gradient_replay, STEPS + 1, products));
    vw_gradient_replay_destroy(&gradient_replay);
    for (uint32_t i = 0; i < TRAINS; i++) size += fabs(products[i].by_step) / TRAINS;
    for (uint32_t i = 0; i < TRAINS; i++) assert_true(fabs(TRAINS * scores[i] - products[i].by_step) < 0.01 * size);
}

static void check_solution(const struct opened *opened, double scale) {
    const struct vw_influence_settings settings = {.iterations = 300, .damping = 0.05, .scale = scale};
    struct vw_influence influence;
    struct vw_influence_result result = {0};
    double scores[TRAINS], exact[TRAINS], difference = 0;
    ASSERT_OK(vw_influence_create(&opened->params, &settings, &influence));
    ASSERT_OK(vw_influence_solve(&influence, &result));
    assert_true(result.found && result.scale == scale);
    double *found = test_allocate(influence.count, sizeof *found),
           *solved = vw_allocate(influence.count, sizeof *solved);
    memcpy(found, influence.mean, influence.count * sizeof *found);
    influence.first_counted = settings.iterations - 8 * TRAINS; // fewer products, of which the test takes many
    double residual = solve_by_conjugate_gradients(&influence, solved);
    for (uint64_t i = 0; i < influence.count; i++)
        if (influence.rates[i] > 0) difference += pow(found[i] - solved[i], 2) / influence.rates[i];
    difference = sqrt(difference / product_of(&influence, solved, solved));
    printf("influence: scale %g, growth %.2f, off by %.3f, residual of the other %.4f\n", result.scale, result.growth,
           difference, residual);
    assert_true(residual < 0.02);
    assert_true(difference < 0.05);
    ASSERT_OK(vw_influence_score(&influence, scores));
    vw_influence_destroy(&influence);

    ASSERT_OK(vw_influence_create(&opened->params, &settings, &influence)); // with the params at the end
    memcpy(influence.mean, solved, influence.count * sizeof *solved);
    ASSERT_OK(vw_influence_score(&influence, exact));
    vw_influence_destroy(&influence);
    assert_true(vw_pearson(scores, exact, TRAINS) > 0.98);
}

TEST(influence_solves_its_equation) {
    struct vw_config config = gradient_config();
    struct opened opened;
    open_training(&opened, &config);
    check_solution(&opened, 1);
    check_solution(&opened, 4);
}

TEST(influence_that_diverges_has_no_score) {
    struct vw_config config = gradient_config();
    struct opened opened;
    struct vw_influence_result result = {0}, direct = {0};
    double scores[TRAINS], raised[TRAINS];
    open_training(&opened, &config);
    struct vw_influence_settings settings = {.iterations = 20, .scale = 1e-3, .scale_max = 2e-3};
    ASSERT_OK(vw_influence_scores(&opened.params, &settings, scores, &result));
    assert_false(result.found);
    for (uint32_t i = 0; i < TRAINS; i++) assert_true(isnan(scores[i]));
    settings.scale_max = 0;
    ASSERT_OK(vw_influence_scores(&opened.params, &settings, raised, &result));
    assert_true(result.found && result.scale > 2e-3);
    assert_true(result.growth <= 1 / VW_INFLUENCE_DAMPING);
    settings.scale = result.scale;
    ASSERT_OK(vw_influence_scores(&opened.params, &settings, scores, &direct));
    assert_memory_equal(scores, raised, sizeof scores);
    assert_true(direct.iterations == settings.iterations && result.iterations > direct.iterations);
}

static bool ask_to_stop(void *context) {
    uint32_t *asked = context;
    return ++*asked > 1;
}

TEST(what_cannot_be_followed_is_refused) {
    struct vw_config config = gradient_config();
    struct opened opened;
    struct vw_in_run_credit credits[STEPS];
    uint32_t asked = 0;
    open_training(&opened, &config);
    opened.params.interrupt = (struct vw_interrupt){ask_to_stop, &asked};
    assert_int_equal(vw_tracin_scores(&opened.params, 2, &(struct vw_tracin_score[TRAINS]){0}[0]),
                     VW_ERROR_INTERRUPTED);
    strcpy(config.effects, "pose");
    open_training(&opened, &config);
    ASSERT_FAILS(vw_in_run_credits(&opened.params, credits), VW_ERROR_USAGE, "--effects -pose");
}

TEST_GROUP(NULL, test_gpu_close)
