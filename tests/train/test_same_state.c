// `value --same-state N`: what its probes say, and that they leave the run alone.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "gpu/compute.h"
#include "support/temporary_folder.h"
#include "support/trainer_fixture.h"
#include "train/pixels.h"
#include "train/trainer.h"

enum { TRAINS = 5 }; // photos of test_scene()

static struct vw_config probing_config(void) {
    struct vw_config config = test_config();
    config.epochs = 7;
    config.burn_in_epochs = 2;
    config.same_state = 2; // of the five epochs 2 to 6: 3 and 5
    return config;
}

static struct test_run *probed_run(const struct vw_config *config, uint32_t steps_per_batch) {
    struct vw_scene *scene = test_scene();
    struct test_run *run = test_run(scene, config, true, steps_per_batch);
    vw_scene_close(&scene);
    return run;
}

TEST(probes_leave_the_run_alone) {
    static const char *const effects[] = {"none", "appearance,appearance_code", "occupancy"};
    for (size_t i = 0; i < VW_ARRAY_COUNT(effects); i++) {
        struct vw_config pilot = probing_config(), plain;
        strcpy(pilot.effects, effects[i]);
        pilot.beta1 = i == 0 ? 0.9 : 0.0;
        plain = pilot;
        plain.same_state = 0;
        struct test_run *probed = probed_run(&pilot, 0), *bare = probed_run(&plain, 0);
        assert_int_equal(bare->probe_count, 0);
        assert_int_equal(probed->probe_count, 2 * TRAINS * SAME_STATE_DRAWS);
        assert_int_equal(probed->stats.same_state_steps, probed->probe_count);
        probed->probe_count = 0;
        test_run_assert_same(bare, probed);
        test_run_free(probed);
        test_run_free(bare);
    }
}

// Every photo in turn, from the states behind epochs 3 and 5.
TEST(every_photo_is_probed_at_every_state) {
    struct vw_config config = probing_config();
    struct vw_scene *scene = test_scene();
    struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 1);
    struct test_run *run = vw_allocate(1, sizeof *run);
    test_run_finish(trainer, run);
    assert_int_equal(run->probe_count, 2 * TRAINS * SAME_STATE_DRAWS);
    for (uint32_t i = 0; i < run->probe_count; i++) {
        const struct vw_probe *probe = &run->probes[i];
        uint32_t index = i % (TRAINS * SAME_STATE_DRAWS);
        assert_int_equal(probe->step, TRAINS * (i < TRAINS * SAME_STATE_DRAWS ? 4 : 6));
        assert_int_equal(probe->index, index);
        assert_int_equal(probe->kind, VW_PROBE_SAME_STATE);
        assert_int_equal(probe->view, trainer->schedule.train_views[index / SAME_STATE_DRAWS]);
        for (uint32_t k = i - index; k < i; k++) assert_false(test_same_bits(run->probes[k].val_psnr, probe->val_psnr));
    }
    vw_trainer_destroy(&trainer);
    test_run_free(run);
    vw_scene_close(&scene);
}

TEST(submissions_of_any_size_give_the_same_bits) {
    struct vw_config config = probing_config();
    config.noise_floor = true; // the others share the step's probes and the scalars
    config.burn_in_epochs = 0;
    config.same_state = 3;
    struct test_run *single = probed_run(&config, 1);
    assert_true(single->probe_count > 3 * TRAINS * SAME_STATE_DRAWS);
    for (uint32_t steps = 0; steps <= 64; steps = steps ? 4 * steps : 4) {
        struct test_run *other = probed_run(&config, steps);
        test_run_assert_same(single, other);
        test_run_free(other);
    }
    test_run_free(single);
}

// ---- Against a step that is taken by hand ---------------------------------------------------------------------------

// Takes batches until a step with such probes is handed out, which ends its batch. Returns the step's number.
static uint64_t stop_at_first_state(struct vw_trainer *trainer, struct test_run *run) {
    const struct vw_step_record *records;
    uint32_t count;
    while (run->probe_count == 0) {
        ASSERT_OK(vw_trainer_advance(trainer, &records, &count));
        assert_true(count > 0);
        test_run_keep(run, records, count);
    }
    return run->records[run->count - 1].step;
}

// The step behind the trainer's state, on pixels of a photo that another trainer might have drawn, and its validation.
static struct vw_probe step_by_hand(struct vw_trainer *trainer, uint64_t number, uint32_t view, uint32_t draw) {
    struct vw_submission *batch = NULL;
    struct vw_probe measured;
    vw_pixels_draw(trainer->scene, view, &(struct vw_pixel_draw){trainer->config.seed, number, draw, 0},
                   trainer->config.rays, vw_buffer_map(trainer->pixels));
    ASSERT_OK(vw_submission_create(trainer->gpu, &batch));
    vw_submission_begin(batch);
    vw_step_record_passes(&trainer->step, batch, number, 0, 0);
    vw_validation_record(&trainer->validation, batch, 0);
    ASSERT_OK(vw_submission_submit(batch));
    ASSERT_OK(vw_submission_wait(batch));
    vw_probe_read(&trainer->probes.context, vw_buffer_map(trainer->scalars), true, &measured);
    vw_submission_destroy(&batch);
    return measured;
}

TEST(a_probe_is_the_step_from_the_checkpointed_state) {
    char *folder = temporary_folder_create();
    const char *path = temporary_path(folder, "checkpoint");
    struct vw_config config = probing_config();
    config.beta1 = 0.9; // so that moments matter
    struct vw_scene *scene = test_scene();
    struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 3);
    struct test_run *run = vw_allocate(1, sizeof *run);
    uint64_t last = stop_at_first_state(trainer, run), loaded = 0;
    ASSERT_OK(vw_trainer_save_checkpoint(trainer, path)); // nothing is in flight
    vw_trainer_destroy(&trainer);
    assert_int_equal(run->probe_count, TRAINS * SAME_STATE_DRAWS);
    for (uint32_t i = 0; i < run->probe_count; i++) {
        trainer = test_trainer_create(scene, &config, true, 1);
        ASSERT_OK(vw_trainer_load_checkpoint(trainer, path, UINT64_MAX, &loaded));
        assert_int_equal(loaded, last);
        struct vw_probe by_hand = step_by_hand(trainer, last + 1, run->probes[i].view, 1 + PROBE_RESAMPLES + i);
        assert_true(test_same_bits(by_hand.val_psnr, run->probes[i].val_psnr));
        assert_true(test_same_bits(by_hand.val_psnr_pooled, run->probes[i].val_psnr_pooled));
        assert_true(test_same_bits(by_hand.val_l1, run->probes[i].val_l1));
        vw_trainer_destroy(&trainer);
    }
    test_run_free(run);
    vw_scene_close(&scene);
    temporary_folder_remove(folder);
}

// Resumed at a state that was probed, a run goes on and does not probe it again.
TEST(a_run_goes_on_from_a_probed_state) {
    char *folder = temporary_folder_create();
    const char *path = temporary_path(folder, "checkpoint");
    struct vw_config config = probing_config();
    struct vw_scene *scene = test_scene();
    struct test_run *whole = test_run(scene, &config, true, 0), *parts = vw_allocate(1, sizeof *parts);
    struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 0);
    uint64_t last = stop_at_first_state(trainer, parts), loaded = 0;
    ASSERT_OK(vw_trainer_save_checkpoint(trainer, path));
    vw_trainer_destroy(&trainer);
    trainer = test_trainer_create(scene, &config, true, 0);
    ASSERT_OK(vw_trainer_load_checkpoint(trainer, path, UINT64_MAX, &loaded));
    assert_int_equal(loaded, last);
    test_run_finish(trainer, parts);
    test_run_assert_same(whole, parts);
    vw_trainer_destroy(&trainer);
    test_run_free(whole);
    test_run_free(parts);
    vw_scene_close(&scene);
    temporary_folder_remove(folder);
}

// ---- Which states ---------------------------------------------------------------------------------------------------

static uint32_t states_due(const struct vw_probe_context *context) {
    uint32_t due = 0;
    for (uint64_t step = 0; step <= vw_photo_order_total_steps(context->schedule); step++)
        due += vw_same_state_due(context, step);
    return due;
}

TEST(there_are_as_many_states_as_asked_for) {
    for (uint32_t counted = 1; counted <= 12; counted += 1 + counted / 4) {
        for (uint32_t states = 1; states <= counted; states++) {
            struct vw_config config = probing_config();
            config.burn_in_epochs = 3;
            config.epochs = 3 + counted;
            config.same_state = states;
            struct vw_photo_order schedule = {.train_count = TRAINS, .epochs = config.epochs};
            const struct vw_probe_context context = {.config = &config, .schedule = &schedule};
            ASSERT_OK(vw_config_check(&config));
            assert_int_equal(states_due(&context), states);
            if (states == 1) assert_true(vw_same_state_due(&context, TRAINS * (3 + counted / 2 + 1))); // the middle
        }
    }
}

TEST(what_cannot_be_probed_is_refused) {
    struct vw_scene *scene = test_scene();
    struct vw_config config = probing_config();
    struct vw_trainer *trainer = NULL;
    config.same_state = 6;
    assert_int_equal(vw_config_check(&config), VW_ERROR_USAGE); // five epochs
    assert_non_null(strstr(vw_error_message(), "--same-state 6"));
    config = probing_config();
    const struct vw_trainer_params params = {.gpu = test_gpu(), .scene = scene, .config = &config};
    assert_int_equal(test_trainer_open(params, &trainer), VW_ERROR_USAGE); // nothing is validated
    assert_non_null(strstr(vw_error_message(), "--same-state: needs validation"));
    vw_scene_close(&scene);
}

// The states that are probed depend on how many epochs there are, so that such a run cannot be extended; others can.
TEST(the_epochs_belong_to_such_a_run) {
    struct vw_config config = probing_config(), longer = config, read;
    longer.epochs++;
    for (uint32_t states = 0; states <= 2; states += 2) {
        config.same_state = longer.same_state = states;
        char *one = vw_config_to_json(&config, true), *other = vw_config_to_json(&longer, true),
             *all = vw_config_to_json(&config, false);
        assert_int_equal(strcmp(one, other) == 0, states == 0);
        ASSERT_OK(vw_config_from_json(all, &read));
        assert_int_equal(read.same_state, states);
        free(one);
        free(other);
        free(all);
    }
}

TEST_GROUP(NULL, test_gpu_close)
