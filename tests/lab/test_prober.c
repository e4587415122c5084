// Probes of a run: their results, and that they leave the run alone.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "lab/probes/probe_plan.h"
#include "support/trainer_fixture.h"
#include "train/pixels.h"

enum { TRAINS = 5, STATES = 2, PROBES_MOST = 4096 }; // photos of test_scene()

static struct vw_config probing_config(void) {
    struct vw_config config = test_config();
    config.burn_in_epochs = 2;
    config.epochs = 10; // every photo has its turn in eight
    return config;
}

struct probed_run {
    struct test_run *run;
    struct vw_probe probes[PROBES_MOST];
    uint32_t count;
};

static void go_to(struct vw_trainer *trainer, uint64_t step, struct test_run *run) {
    vw_trainer_stop_after(trainer, step);
    test_run_advance(trainer, run);
}

// Takes a run with probes of noise and of some states.
static struct probed_run *probe_run(const struct vw_scene *scene, const struct vw_config *config, uint32_t states,
                                    uint32_t steps_per_submission) {
    struct probed_run *made = test_allocate(1, sizeof *made);
    struct vw_trainer *trainer = test_trainer_create(scene, config, true, steps_per_submission);
    struct vw_prober prober;
    made->run = test_allocate(1, sizeof *made->run);
    ASSERT_OK(vw_prober_create(trainer, &prober));
    const struct vw_probe_plan plan = {&trainer->photo_order, config->burn_in_epochs, config->epochs, states};
    for (uint64_t step = 0; step <= vw_trainer_total_steps(trainer); step++) {
        assert_true(made->count + vw_probes_of_state_most(&plan) <= PROBES_MOST);
        uint32_t count = vw_probes_list(&plan, step, made->probes + made->count);
        if (!count) continue;
        go_to(trainer, step, made->run);
        ASSERT_OK(vw_prober_take(&prober, step + 1, made->probes + made->count, count));
        made->count += count;
    }
    vw_trainer_stop_after(trainer, UINT64_MAX);
    test_run_finish(trainer, made->run);
    vw_prober_destroy(&prober);
    test_release(trainer);
    return made;
}

static bool same_result(const struct vw_probe *probe, const struct vw_step_record *record) {
    return test_same_bits(probe->val_psnr, record->val_psnr) && test_same_bits(probe->val_l1, record->val_l1) &&
           test_same_bits(probe->val_psnr_pooled, record->val_psnr_pooled);
}

// Compares the probed run with one without probes. Repeated validations and steps of learning rate 0 move nothing.
TEST(probes_leave_the_run_alone) {
    static const struct {
        double beta1;
        const char *effects;
    } cases[] = {
        {0.9, "none"}, {0.0, "appearance,appearance_code,sky,visibility"}, {0.9, "appearance_encoder,transient"}};
    struct vw_scene *scene = test_scene();
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        struct vw_config config = probing_config();
        config.beta1 = cases[i].beta1;
        strcpy(config.effects, cases[i].effects);
        struct probed_run *probed = probe_run(scene, &config, STATES, 0);
        struct test_run *bare = test_run(scene, &config, true, 0);
        uint32_t exact = 0, resampled = 0;
        test_run_assert_same(bare, probed->run);
        for (uint32_t k = 0; k < probed->count; k++) {
            const struct vw_probe *probe = &probed->probes[k];
            resampled += probe->kind == VW_PROBE_RESAMPLED;
            if (probe->kind > VW_PROBE_ZERO_LEARNING_RATE) continue;
            assert_true(same_result(probe, &bare->records[probe->step - 1]));
            exact++;
        }
        assert_int_equal(exact, 2 * TRAINS); // every photo once
        assert_int_equal(resampled, VW_PROBE_RESAMPLES * TRAINS);
        assert_int_equal(probed->count, exact + resampled + STATES * TRAINS * VW_SAME_STATE_DRAWS);
    }
}

TEST(resampled_steps_differ_as_steps_do) {
    struct vw_scene *scene = test_scene();
    struct vw_config config = probing_config();
    struct probed_run *probed = probe_run(scene, &config, 0, 0);
    for (uint32_t i = 0; i < probed->count; i++) {
        const struct vw_probe *probe = &probed->probes[i];
        const struct vw_step_record *own = &probed->run->records[probe->step];
        assert_true(own->epoch >= config.burn_in_epochs && own->view == probe->view);
        if (probe->kind != VW_PROBE_RESAMPLED) continue;
        assert_true(isfinite(probe->val_psnr));
        assert_false(test_same_bits(probe->val_psnr, own->val_psnr));                  // other pixels
        assert_false(test_same_bits(probe->val_psnr, probed->probes[i - 1].val_psnr)); // than the draw before, too
        assert_true(fabs(probe->val_psnr - own->val_psnr) < 1.0);                      // from the same state
    }
}

// A resampled step that happens to have the step's own pixels gives the step's own bits: here every pixel of every
// photo is the same one.
TEST(the_same_pixels_give_the_step_itself) {
    struct vw_scene *scene = synthetic_scene(
        &(struct synthetic_scene_params){.train_views = 5, .val_views = TEST_VALS, .width_px = 1, .height_px = 1});
    struct vw_config config = probing_config();
    struct probed_run *probed = probe_run(scene, &config, 0, 0);
    assert_true(probed->count > 0);
    for (uint32_t i = 0; i < probed->count; i++) {
        const struct vw_probe *probe = &probed->probes[i];
        uint64_t same = probe->kind == VW_PROBE_RESAMPLED ? probe->step : probe->step - 1;
        assert_true(same_result(probe, &probed->run->records[same]));
    }
}

TEST(submissions_of_any_size_give_the_same_bits) {
    struct vw_scene *scene = test_scene();
    struct vw_config config = probing_config();
    struct probed_run *single = probe_run(scene, &config, 3, 1);
    for (uint32_t steps = 0; steps <= 64; steps = steps ? 4 * steps : 4) {
        struct probed_run *other = probe_run(scene, &config, 3, steps);
        test_run_assert_same(single->run, other->run);
        assert_int_equal(single->count, other->count);
        assert_memory_equal(single->probes, other->probes, single->count * sizeof *single->probes);
    }
}

// Takes the step after the trainer's state, on a draw of pixels that nothing else takes, and validates.
static struct vw_step_record step_by_hand(struct vw_trainer *trainer, uint64_t number, uint32_t view, uint32_t draw) {
    struct vw_submission *submission = NULL;
    uint32_t rays = trainer->config.rays;
    struct vw_pixel *pixels = test_allocate(rays, sizeof *pixels);
    vw_pixels_draw(trainer->scene, view, &(struct vw_pixel_draw){trainer->config.seed, number, draw, 0}, rays, pixels);
    ASSERT_OK(vw_buffer_write(trainer->pixels, 0, pixels, rays * sizeof *pixels));
    ASSERT_OK(vw_submission_create(trainer->gpu, &submission));
    vw_submission_begin(submission);
    vw_step_record_passes(&trainer->step, submission, number, 0, 0);
    vw_validation_record(&trainer->validation, submission, 0);
    test_submit(submission);
    const struct vw_field_measurement measured =
        vw_validation_read(&trainer->validation, vw_buffer_map(trainer->scalars), NULL);
    vw_submission_destroy(&submission);
    return (struct vw_step_record){
        .val_psnr = measured.val_psnr, .val_psnr_pooled = measured.val_psnr_pooled, .val_l1 = measured.val_l1};
}

// Every photo is tried in turn, from the states at the ends of the epochs in the middle of two halves.
TEST(a_probe_of_a_state_is_the_next_step_from_there) {
    struct vw_scene *scene = test_scene();
    struct vw_config config = probing_config();
    config.beta1 = 0.9; // so that moments matter
    struct probed_run *probed = probe_run(scene, &config, STATES, 0);
    uint32_t found = 0;
    for (uint32_t i = 0; i < probed->count; i++) {
        const struct vw_probe *probe = &probed->probes[i];
        if (probe->kind != VW_PROBE_SAME_STATE) continue;
        uint32_t index = found++ % (TRAINS * VW_SAME_STATE_DRAWS);
        struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 1);
        struct test_run *run = test_allocate(1, sizeof *run);
        assert_int_equal(probe->step, TRAINS * (found <= TRAINS * VW_SAME_STATE_DRAWS ? 5 : 9));
        assert_int_equal(probe->view, trainer->photo_order.train_views[index / VW_SAME_STATE_DRAWS]);
        go_to(trainer, probe->step, run);
        const struct vw_step_record by_hand =
            step_by_hand(trainer, probe->step + 1, probe->view, 1 + VW_PROBE_RESAMPLES + index);
        assert_true(same_result(probe, &by_hand));
        test_release(trainer);
    }
    assert_int_equal(found, STATES * TRAINS * VW_SAME_STATE_DRAWS);
}

// Steps no longer than they were give the run itself, and longer ones something else.
TEST(lengthened_steps_are_those_of_the_run) {
    struct vw_scene *scene = test_scene();
    struct vw_config config = probing_config();
    struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 4);
    struct test_run *run = test_allocate(1, sizeof *run);
    struct vw_prober prober;
    struct vw_probe probes[PROBES_MOST];
    const struct vw_probe_plan plan = {&trainer->photo_order, config.burn_in_epochs, config.epochs, 0, 0.5};
    uint64_t step = (uint64_t)config.burn_in_epochs * TRAINS, total = vw_trainer_total_steps(trainer);
    ASSERT_OK(vw_prober_create(trainer, &prober));
    uint32_t count = vw_probes_list(&plan, step, probes);
    assert_true(count >= 2 * TRAINS && probes[0].extra == 0.5f && probes[1].extra == -0.5f);
    probes[0].extra = 0;
    go_to(trainer, step, run);
    ASSERT_OK(vw_prober_take(&prober, step + 1, probes, count));
    vw_trainer_stop_after(trainer, UINT64_MAX);
    test_run_finish(trainer, run);
    vw_prober_destroy(&prober);
    assert_true(same_result(&probes[0], &run->records[total]));
    for (uint32_t i = 1; i < 2 * TRAINS; i++)
        assert_false(test_same_bits(probes[i].val_psnr, probes[0].val_psnr) || isnan(probes[i].val_psnr));
    test_run_assert_same(test_run(scene, &config, true, 0), run);
    test_release(trainer);
}

TEST(there_are_as_many_states_as_asked_for) {
    for (uint32_t counted = 1; counted <= 12; counted += 1 + counted / 4)
        for (uint32_t states = 1; states <= counted; states++) {
            struct vw_photo_order order = {.train_count = TRAINS, .epochs = 3 + counted};
            const struct vw_probe_plan plan = {&order, 3, order.epochs, states};
            uint32_t due = 0;
            for (uint64_t step = 0; step <= vw_photo_order_total_steps(&order); step++)
                due += vw_probe_state_due(&plan, step);
            assert_int_equal(due, states);
            if (states == 1) assert_true(vw_probe_state_due(&plan, TRAINS * (3 + counted / 2 + 1))); // the middle
        }
}

TEST_GROUP(NULL, test_gpu_close)
