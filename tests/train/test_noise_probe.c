// `value --noise-floor`: what the probes of a run say, and that they leave the run alone.
#include "support/cmocka_test.h"

#include "support/trainer_fixture.h"
#include "train/trainer.h"

static struct vw_config probing_config(void) {
    struct vw_config config = test_config();
    config.noise_floor = true;
    config.burn_in_epochs = 2;
    config.epochs = 10; // every photo has its turn in eight
    return config;
}

TEST(probes_leave_the_run_alone) {
    struct vw_scene *scene = test_scene();
    struct vw_config pilot = probing_config(), plain = pilot;
    plain.noise_floor = false;
    struct test_run *probed = test_run(scene, &pilot, true, 0), *bare = test_run(scene, &plain, true, 0);
    assert_int_equal(bare->probe_count, 0);
    probed->probe_count = 0;
    test_run_assert_same(bare, probed);
    test_run_free(probed);
    test_run_free(bare);
    vw_scene_close(&scene);
}

// The step before which a probe was taken, and so the validation it starts from.
static const struct vw_step_record *before(const struct test_run *run, const struct vw_probe *probe) {
    return &run->records[probe->step - 1];
}

TEST(repeated_and_zero_rate_probes_change_nothing) {
    struct vw_scene *scene = test_scene();
    struct vw_config config = probing_config();
    struct test_run *run = test_run(scene, &config, true, 0);
    uint32_t exact = 0;
    for (uint32_t i = 0; i < run->probe_count; i++) {
        const struct vw_probe *probe = &run->probes[i];
        if (probe->kind == VW_PROBE_RESAMPLED) continue;
        assert_true(test_same_bits(probe->val_psnr, before(run, probe)->val_psnr));
        assert_true(test_same_bits(probe->val_psnr_pooled, before(run, probe)->val_psnr_pooled));
        assert_true(test_same_bits(probe->val_l1, before(run, probe)->val_l1));
        exact++;
    }
    assert_int_equal(exact, 2 * 5); // every photo once
    test_run_free(run);
    vw_scene_close(&scene);
}

TEST(resampled_steps_differ_as_steps_do) {
    struct vw_scene *scene = test_scene();
    struct vw_config config = probing_config();
    struct test_run *run = test_run(scene, &config, true, 0);
    uint32_t resampled = 0;
    for (uint32_t i = 0; i < run->probe_count; i++) {
        const struct vw_probe *probe = &run->probes[i];
        if (probe->kind != VW_PROBE_RESAMPLED) continue;
        const struct vw_step_record *own = &run->records[probe->step];
        assert_true(isfinite(probe->val_psnr));
        assert_false(test_same_bits(probe->val_psnr, own->val_psnr));               // other pixels
        assert_false(test_same_bits(probe->val_psnr, run->probes[i - 1].val_psnr)); // than the draw before, too
        assert_true(fabs(probe->val_psnr - own->val_psnr) < 1.0);                   // from the same state
        assert_true(own->epoch >= config.burn_in_epochs);
        resampled++;
    }
    assert_int_equal(resampled, PROBE_RESAMPLES * 5);
    test_run_free(run);
    vw_scene_close(&scene);
}

// A resampled step that happens to have the step's own pixels gives the step's own bits: here every pixel of every
// photo is the same one.
TEST(the_same_pixels_give_the_step_itself) {
    struct vw_scene *scene = synthetic_scene(
        &(struct synthetic_scene_params){.train_views = 5, .val_views = TEST_VALS, .width_px = 1, .height_px = 1});
    struct vw_config config = probing_config();
    struct test_run *run = test_run(scene, &config, true, 0);
    assert_true(run->probe_count > 0);
    for (uint32_t i = 0; i < run->probe_count; i++) {
        const struct vw_probe *probe = &run->probes[i];
        const struct vw_step_record *same =
            probe->kind == VW_PROBE_RESAMPLED ? &run->records[probe->step] : before(run, probe);
        assert_true(test_same_bits(probe->val_psnr, same->val_psnr) && test_same_bits(probe->val_l1, same->val_l1));
    }
    test_run_free(run);
    vw_scene_close(&scene);
}

TEST(without_validation_there_is_nothing_to_probe) {
    struct vw_scene *scene = test_scene();
    struct vw_config config = probing_config();
    struct vw_trainer *trainer = NULL;
    const struct vw_trainer_params params = {.gpu = test_gpu(), .scene = scene, .config = &config};
    assert_int_equal(test_trainer_open(params, &trainer), VW_ERROR_USAGE);
    vw_scene_close(&scene);
}

TEST_GROUP(NULL, test_gpu_close)
