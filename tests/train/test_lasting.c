// The backward pass of lasting credit: that it replays the run, that its bits do not depend on how it is cut or
// interrupted, and that it says what happens when steps are longer or shorter.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "base/statistics.h"
#include "support/temporary_folder.h"
#include "support/trainer_fixture.h"
#include "train/adjoint/lasting.h"

enum { TRAINS = 5, EPOCHS = 12, STEPS = EPOCHS * TRAINS, STEPS_MAX = 300, VIEWS = TEST_VALS }; // photos of test_scene()
enum { CHECKED = 10 }; // steps that are made longer and shorter

static struct vw_config lasting_config_of(enum vw_field field) {
    struct vw_config config = test_config_of(field);
    config.epochs = EPOCHS;
    config.rays = 120;
    config.loss = VW_LOSS_L2;
    return config;
}

static struct vw_config lasting_config(void) { return lasting_config_of(VW_FIELD_HASH); }

struct replay {
    const struct test_run *run;
    uint64_t told;
};

static enum vw_status compare_replayed(void *context, const struct vw_step_record *record) {
    struct replay *replay = context;
    const struct vw_step_record *own = &replay->run->records[record->step];
    assert_int_equal(record->step, ++replay->told);
    assert_int_equal(record->view, own->view);
    assert_true(test_same_bits(record->train_loss, own->train_loss));
    return VW_OK;
}

static struct vw_lasting *open_lasting(const struct vw_scene *scene, const struct vw_config *config, uint32_t rays,
                                       bool by_view, uint64_t memory_bytes, struct replay *replay) {
    const struct vw_effect_decision *effects;
    uint32_t effect_count;
    struct vw_trainer *trainer = test_trainer_create(scene, config, true, 0);
    struct vw_lasting *lasting = NULL;
    effects = vw_trainer_effects(trainer, &effect_count);
    const struct vw_trainer_params training = {.gpu = test_gpu(),
                                               .scene = scene,
                                               .config = config,
                                               .validate = true,
                                               .effects = effects,
                                               .effect_count = effect_count};
    const struct vw_lasting_params params = {.training = &training,
                                             .rays = rays,
                                             .by_view = by_view,
                                             .memory_bytes = memory_bytes,
                                             .replayed = replay ? compare_replayed : NULL,
                                             .context = replay};
    ASSERT_OK(vw_lasting_create(&params, &lasting));
    test_release(trainer);
    return lasting;
}

// Finds all credits that are left, by step; returns how many there were.
static uint32_t backward(struct vw_lasting *lasting, struct vw_lasting_credit *by_step) {
    const struct vw_lasting_credit *credits;
    uint32_t count, total = 0;
    for (bool done = false; !done;) {
        ASSERT_OK(vw_lasting_advance(lasting, &credits, &count, &done));
        for (uint32_t i = 0; i < count; i++) by_step[credits[i].step] = credits[i];
        total += count;
    }
    return total;
}

static void assert_same_credits(const struct vw_lasting_credit *a, const struct vw_lasting_credit *b, uint64_t steps) {
    for (uint64_t step = 1; step <= steps; step++) {
        assert_int_equal(a[step].view, b[step].view);
        assert_true(test_same_bits(a[step].psnr, b[step].psnr) && test_same_bits(a[step].loss, b[step].loss));
        assert_true(test_same_bits(a[step].size_psnr, b[step].size_psnr));
    }
}

// Asserts that predictions of a backward pass correlate with what retrainings measure by at least `pearson`.
static void assert_agree(const double *predicted, const double *measured, uint32_t count, double pearson) {
    double seen = vw_pearson(predicted, measured, count);
    if (!(seen >= pearson)) {
        for (uint32_t i = 0; i < count; i++) printf("predicted %g, measured %g\n", predicted[i], measured[i]);
        fail_msg("%u predicted and measured values agree by %g only", count, seen);
    }
}

// Asserts that both have the same size: what is measured is not a multiple of what is predicted.
static void assert_same_size(const double *predicted, const double *measured, uint32_t count) {
    double products = 0, squares = 0;
    for (uint32_t i = 0; i < count; i++) {
        products += predicted[i] * measured[i];
        squares += predicted[i] * predicted[i];
    }
    if (!(fabs(products / squares - 1) < 0.25)) fail_msg("%g is measured for 1 predicted", products / squares);
}

TEST(replays_the_run_and_passes_the_gate) {
    const struct vw_config config = lasting_config();
    struct vw_scene *scene = test_scene();
    struct test_run *run = test_run(scene, &config, true, 0);
    struct replay replay = {.run = run};
    struct vw_lasting_credit credits[STEPS + 1] = {0};
    struct vw_lasting *lasting = open_lasting(scene, &config, 0, false, 0, &replay);
    assert_int_equal(backward(lasting, credits), STEPS);
    assert_int_equal(replay.told, STEPS);
    const uint64_t from = 5 * TRAINS;
    struct vw_lasting_check checks[TRAINS];
    double predicted[TRAINS] = {0}, measured[TRAINS], predicted_loss[TRAINS] = {0}, measured_loss[TRAINS];
    for (uint32_t i = 0; i < TRAINS; i++) {
        checks[i].view = credits[1 + i].view;
        for (uint64_t step = from + 1; step <= STEPS; step++) {
            if (credits[step].view != checks[i].view) continue;
            predicted[i] += credits[step].psnr;
            predicted_loss[i] += credits[step].loss;
        }
    }
    ASSERT_OK(vw_lasting_measure(lasting, run->records, from, checks, TRAINS));
    for (uint32_t i = 0; i < TRAINS; i++) {
        measured[i] = checks[i].measured_psnr;
        measured_loss[i] = checks[i].measured_loss;
    }
    assert_agree(predicted, measured, TRAINS, 0.9);
    assert_agree(predicted_loss, measured_loss, TRAINS, 0.9);
    assert_same_size(predicted, measured, TRAINS);
    assert_same_size(predicted_loss, measured_loss, TRAINS);
    run->records[STEPS].val_psnr = run->records[STEPS].val_l1 = NAN; // as of a step that was not finite
    ASSERT_OK(vw_lasting_measure(lasting, run->records, from, checks, 1));
    assert_near(checks[0].measured_psnr, measured[0], 1e-9);
    assert_near(checks[0].measured_loss, measured_loss[0], 1e-9);
    vw_lasting_destroy(&lasting);
}

static float *read_floats(struct vw_buffer *buffer, uint64_t offset_bytes, uint64_t count) {
    float *values = test_allocate(count, sizeof *values);
    ASSERT_OK(vw_buffer_read(buffer, offset_bytes, values, count * sizeof *values));
    return values;
}

// Changes the step that was kept last, in one range of params and moments: with momentum a gradient that is longer by
// `extra` moves the moment, and with it this step and later ones.
static void nudge_range(const struct vw_lasting *lasting, uint32_t place, const struct vw_param_range *range,
                        struct vw_buffer *moments, float extra) {
    uint64_t block = lasting->replay.context->field->model->param_bytes, first = range->offset_bytes,
             floats = range->size_bytes / 4;
    double own = 1.0 - lasting->replay.context->config->beta1;
    float *before = read_floats(lasting->stored.params, block * place + first, floats),
          *gradient = read_floats(lasting->stored.gradients, block * place + first, floats),
          *after = read_floats(lasting->replay.context->field->params, first, floats),
          *moment = read_floats(moments, 0, floats);
    for (uint64_t i = 0; i < floats; i++) {
        double nudge = extra * own * gradient[i],
               rate = moment[i] != 0.0f ? ((double)before[i] - after[i]) / moment[i] : 0.0;
        after[i] = (float)(after[i] - rate * nudge);
        moment[i] = (float)(moment[i] + nudge);
    }
    ASSERT_OK(vw_buffer_write(lasting->replay.context->field->params, first, after, 4 * floats));
    ASSERT_OK(vw_buffer_write(moments, 0, moment, 4 * floats));
}

static void nudge(const struct vw_lasting *lasting, uint32_t place, float extra) {
    const struct vw_step_passes *step = lasting->replay.context->step;
    const struct vw_model *model = step->field->model;
    const struct vw_param_range moved = {.offset_bytes = model->weights.offset_bytes,
                                         .size_bytes = 16ull * model->moved_columns};
    if (vw_volume_step_of(step)->grid_moment1)
        nudge_range(lasting, place, &vw_volume_of(model)->grid, vw_volume_step_of(step)->grid_moment1, extra);
    nudge_range(lasting, place, &moved, step->weight_moments, extra);
}

// Returns U in dB after a training in which the gradient of step `scaled` is longer by `extra`, from the segment's
// beginning.
static double retrain_psnr(struct vw_lasting *lasting, uint64_t scaled, float extra) {
    const struct vw_trainer_parts *context = lasting->replay.context;
    uint64_t segment = (scaled - 1) / lasting->segment_steps;
    bool momentum = context->config->beta1 > 0;
    double psnr = 0.0;
    vw_submission_begin(lasting->replay.submission);
    vw_snapshot_record_restore(&lasting->starts[segment], lasting->replay.submission);
    ASSERT_OK(vw_step_replay_run(&lasting->replay));
    for (uint64_t step = segment * lasting->segment_steps + 1, first = step; step <= lasting->replay.total_steps;
         first = step) {
        bool nudged = false; // ends a submission: the host has to touch the state after that step
        vw_submission_begin(lasting->replay.submission);
        for (; step <= lasting->replay.total_steps && step - first < lasting->replay.submission_steps && !nudged;
             step++) {
            uint32_t place = (uint32_t)(step - first), pixel = vw_step_replay_draw(&lasting->replay, step, place),
                     row = vw_step_replay_row(&lasting->replay, place);
            nudged = momentum && step == scaled;
            if (nudged)
                vw_adjoint_record_stored_step(&lasting->backward, &lasting->stored, lasting->replay.submission, step,
                                              pixel, row, 0);
            else {
                vw_step_record_gradients(context->step, lasting->replay.submission, step, pixel);
                vw_step_record_update(context->step, lasting->replay.submission, step, pixel,
                                      step == scaled ? extra : 0.0f);
                vw_step_record_loss(context->step, lasting->replay.submission, pixel, row);
            }
            if (vw_lasting_is_state(lasting, step) && !nudged)
                vw_validation_record(context->validation, lasting->replay.submission, row);
        }
        ASSERT_OK(vw_step_replay_run(&lasting->replay));
        const vw_float4 *rows = vw_buffer_map(context->scalars);
        for (uint64_t i = first; i < step; i++)
            if (vw_lasting_is_state(lasting, i) && !(nudged && i == scaled))
                psnr += vw_validation_read(context->validation,
                                           rows + vw_step_replay_row(&lasting->replay, (uint32_t)(i - first)), NULL)
                            .val_psnr;
        if (!nudged) continue;
        nudge(lasting, 0, extra);
        if (!vw_lasting_is_state(lasting, scaled)) continue;
        vw_submission_begin(lasting->replay.submission);
        vw_validation_record(context->validation, lasting->replay.submission, 0);
        ASSERT_OK(vw_step_replay_run(&lasting->replay));
        psnr += vw_validation_read(context->validation, rows, NULL).val_psnr;
    }
    return psnr / vw_lasting_state_count(lasting);
}

// Single steps are longer and shorter by a tenth, all else is as it was. The backward pass leaves most out of the
// derivative far from the end: how a step changes the rates of later ones, kinks, curvature beyond Gauss-Newton's.
TEST(a_step_says_what_it_leaves) {
    static const struct {
        const char *effects;
        double beta1;
        uint32_t epochs;
        uint64_t memory_bytes; // for segments of about 20 steps, from whose beginnings steps are tried
        enum vw_field field;
        uint32_t importance_samples; // with which the learning rate decays
        enum vw_coarse_network coarse_network;
        bool full; // with --full alone: the other cases have all that is theirs
    } cases[] = {{"none", 0, EPOCHS, 3 << 20, VW_FIELD_HASH, 0, VW_COARSE_NETWORK_SHARED, true},
                 {"none", 0.9, EPOCHS, 3 << 20, VW_FIELD_HASH, 0, VW_COARSE_NETWORK_SHARED, false},
                 {"appearance,appearance_code", 0, EPOCHS, 3 << 20, VW_FIELD_HASH, 0, VW_COARSE_NETWORK_SHARED, false},
                 {"none", 0, EPOCHS, 1 << 20, VW_FIELD_MLP, 0, VW_COARSE_NETWORK_SHARED, true},
                 {"none", 0, EPOCHS, 3 << 20, VW_FIELD_HASH, 8, VW_COARSE_NETWORK_SHARED, true},
                 {"none", 0, EPOCHS, 2 << 20, VW_FIELD_MLP, 8, VW_COARSE_NETWORK_OWN, true},
                 {"none", 0.9, EPOCHS, 2 << 20, VW_FIELD_MLP, 8, VW_COARSE_NETWORK_OWN, false}};
    struct vw_scene *scene = test_scene();
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        if (cases[i].full && !test_is_full()) continue;
        struct vw_config config = lasting_config_of(cases[i].field);
        struct vw_lasting_credit credits[STEPS_MAX + 1] = {0};
        double predicted[CHECKED], measured[CHECKED];
        config.epochs = cases[i].epochs;
        config.beta1 = cases[i].beta1;
        config.importance_samples = cases[i].importance_samples;
        config.coarse_network = cases[i].coarse_network;
        if (config.importance_samples) config.samples = 8, config.learning_rate_decay = 0.3;
        strcpy(config.effects, cases[i].effects);
        struct vw_lasting *lasting = open_lasting(scene, &config, 0, false, cases[i].memory_bytes, NULL);
        backward(lasting, credits);
        for (uint32_t k = 0; k < CHECKED; k++) {
            uint64_t step = lasting->replay.total_steps - 2 * k;
            predicted[k] = credits[step].psnr;
            measured[k] = (retrain_psnr(lasting, step, 0.1f) - retrain_psnr(lasting, step, -0.1f)) / 0.2;
        }
        assert_agree(predicted, measured, CHECKED / 2, 0.95);
        assert_agree(predicted, measured, CHECKED, 0.8);
        assert_same_size(predicted, measured, CHECKED);
        vw_lasting_destroy(&lasting);
    }
}

// Segments into which the training is cut, and where the backward pass was stopped, change no bit; how many rays it
// takes does.
TEST(bits_do_not_depend_on_the_way) {
    const struct vw_config config = lasting_config();
    struct vw_scene *scene = test_scene();
    struct vw_lasting_credit whole[STEPS + 1] = {0}, cut[STEPS + 1] = {0}, thin[STEPS + 1] = {0};
    struct vw_lasting *lasting = open_lasting(scene, &config, 0, false, 0, NULL);
    assert_int_equal(lasting->segment_count, 1);
    backward(lasting, whole);
    vw_lasting_destroy(&lasting);

    char *folder = temporary_folder_create();
    const char *path = temporary_path(folder, "backward");
    const struct vw_lasting_credit *credits;
    uint32_t count = 0;
    uint64_t next = 0;
    bool done;
    lasting = open_lasting(scene, &config, 0, false, 2 << 20, NULL);
    assert_true(lasting->segment_count > 3);
    while (lasting->next_step >= vw_lasting_first_state(lasting)) {
        ASSERT_OK(vw_lasting_advance(lasting, &credits, &count, &done));
        for (uint32_t i = 0; i < count; i++) cut[credits[i].step] = credits[i];
    }
    uint64_t stopped = lasting->next_step;
    uint32_t rows[STEPS], *loaded = NULL;
    for (uint32_t i = 0; i < STEPS; i++) rows[i] = i;
    ASSERT_OK(vw_lasting_save(lasting, path, rows, sizeof *rows));
    vw_lasting_destroy(&lasting);
    assert_true(stopped > 0 && stopped < STEPS);
    lasting = open_lasting(scene, &config, 0, false, 2 << 20, NULL);
    assert_int_equal(vw_lasting_load(lasting, path, 2 * sizeof *rows, (void **)&loaded, &next), VW_ERROR_INPUT);
    assert_null(loaded); // rows of another size
    ASSERT_OK(vw_lasting_load(lasting, path, sizeof *rows, (void **)&loaded, &next));
    assert_int_equal(next, stopped);
    assert_memory_equal(loaded, rows, (STEPS - stopped) * sizeof *rows);
    free(loaded);
    assert_int_equal(backward(lasting, cut), stopped);
    vw_lasting_destroy(&lasting);
    assert_same_credits(whole, cut, STEPS);

    lasting = open_lasting(scene, &config, 60, false, 0, NULL);
    assert_int_equal(vw_lasting_load(lasting, path, sizeof *rows, (void **)&loaded, &next),
                     VW_ERROR_INPUT); // the settings are other ones
    backward(lasting, thin);
    vw_lasting_destroy(&lasting);
    temporary_folder_remove(folder);
    double full[STEPS], half[STEPS];
    for (uint32_t i = 0; i < STEPS; i++) full[i] = whole[i + 1].psnr, half[i] = thin[i + 1].psnr;
    assert_true(memcmp(full, half, sizeof full) != 0);
    assert_agree(full, half, STEPS, 0.95);
}

// Goes back with a credit for every validation view; theirs, by step and view. Whether the adjoints of the views were
// on the device.
static bool go_back_with_views(const struct vw_scene *scene, const struct vw_config *config, uint64_t memory_bytes,
                               const char *path, struct vw_lasting_credit *by_step, double (*by_view)[VIEWS]) {
    const struct vw_lasting_credit *credits;
    uint32_t count, submissions = 0;
    struct vw_lasting *lasting = open_lasting(scene, config, 0, true, memory_bytes, NULL);
    assert_int_equal(lasting->replay.context->validation->view_count, VIEWS);
    for (bool done = false; !done;) {
        ASSERT_OK(vw_lasting_advance(lasting, &credits, &count, &done));
        for (uint32_t i = 0; i < count; i++) {
            by_step[credits[i].step] = credits[i];
            memcpy(by_view[credits[i].step], credits[i].view_psnr, sizeof *by_view);
        }
        submissions += count > 0;
        if (!path || submissions != 2) continue;
        void *none = NULL;
        uint64_t next; // goes on in another backward pass, once
        ASSERT_OK(vw_lasting_save(lasting, path, NULL, 0));
        vw_lasting_destroy(&lasting);
        lasting = open_lasting(scene, config, 0, true, memory_bytes, NULL);
        ASSERT_OK(vw_lasting_load(lasting, path, 0, &none, &next));
        free(none);
        path = NULL;
    }
    bool on_device = vw_adjoint_views_bytes(&lasting->backward) > 0;
    vw_lasting_destroy(&lasting);
    return on_device;
}

// PSNR is the mean over views, and the backward pass is linear in what it begins with. Beside rounding, a difference of
// colours takes its step by the length of what is carried back, which is another for each view and crosses other kinks:
// 0.05 % of a step's credits are seen and 0.5 % allowed for.
TEST(views_share_the_credit) {
    const struct vw_config config = lasting_config();
    struct vw_scene *scene = test_scene();
    char *folder = temporary_folder_create();
    struct vw_lasting_credit plain[STEPS + 1] = {0}, credits[STEPS + 1] = {0}, cut[STEPS + 1] = {0};
    double views[STEPS + 1][VIEWS] = {0}, cut_views[STEPS + 1][VIEWS] = {0};
    struct vw_lasting *lasting = open_lasting(scene, &config, 0, false, 0, NULL);
    backward(lasting, plain);
    assert_null(plain[STEPS].view_psnr);
    vw_lasting_destroy(&lasting);
    assert_true(go_back_with_views(scene, &config, 0, NULL, credits, views));
    assert_same_credits(plain, credits, STEPS);
    double apart = 0, worst = 0, total[VIEWS] = {0};
    for (uint32_t step = 1; step <= STEPS; step++) {
        double mean = 0, size = 0;
        for (uint32_t view = 0; view < VIEWS; view++) {
            mean += views[step][view] / VIEWS;
            size += fabs(views[step][view]) / VIEWS;
            total[view] += views[step][view];
            apart += fabs(views[step][view] - views[step][0]);
        }
        worst = fmax(worst, fabs(mean - credits[step].psnr) / (size + 1e-9));
    }
    printf("views: off by at most %.2g of a step's credits\n", worst);
    assert_true(worst < 0.005);
    assert_true(apart > 0.1 * fabs(total[0])); // they are not the same
    struct vw_lasting_state least;             // state with the least memory: the views' adjoints are the host's then
    lasting = open_lasting(scene, &config, 0, false, 2 << 20, NULL);
    vw_lasting_get_state(lasting, &least);
    vw_lasting_destroy(&lasting);
    assert_false(
        go_back_with_views(scene, &config, least.memory_bytes, temporary_path(folder, "backward"), cut, cut_views));
    assert_same_credits(plain, cut, STEPS);
    assert_memory_equal(views, cut_views, sizeof views);
    temporary_folder_remove(folder);
}

TEST_GROUP(NULL, test_gpu_close)
