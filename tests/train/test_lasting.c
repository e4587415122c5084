// The backward sweep of lasting credit: that it replays the run, that its bits do not depend on how it is cut or
// interrupted, and that it says what happens when steps are longer or shorter.
#include "support/cmocka_test.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/statistics.h"
#include "support/temporary_folder.h"
#include "support/trainer_fixture.h"
#include "train/lasting.h"

enum { TRAINS = 5 }; // photos of test_scene()

static struct vw_config lasting_config(void) {
    struct vw_config config = test_config();
    config.epochs = 12;
    config.rays = 120;
    config.loss = VW_LOSS_L2;
    return config;
}

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
                                       uint64_t memory_bytes, struct replay *replay) {
    const struct vw_effect_verdict *effects;
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
                                             .memory_bytes = memory_bytes,
                                             .replayed = replay ? compare_replayed : NULL,
                                             .context = replay};
    ASSERT_OK(vw_lasting_create(&params, &lasting));
    vw_trainer_destroy(&trainer);
    return lasting;
}

// All credits that are left, by step; returns how many there were.
static uint32_t sweep(struct vw_lasting *lasting, struct vw_lasting_credit *by_step) {
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

static void gate_agrees(void **state) {
    (void)state;
    const struct vw_config config = lasting_config();
    struct vw_scene *scene = test_scene();
    struct test_run *run = test_run(scene, &config, true, 0);
    struct replay replay = {.run = run};
    struct vw_lasting_credit credits[12 * TRAINS + 1] = {0};
    struct vw_lasting *lasting = open_lasting(scene, &config, 0, 0, &replay);
    assert_int_equal(sweep(lasting, credits), 12 * TRAINS);
    assert_int_equal(replay.told, 12 * TRAINS);
    uint64_t from = 5 * TRAINS;
    struct vw_lasting_check checks[TRAINS];
    double predicted[TRAINS] = {0}, predicted_loss[TRAINS] = {0};
    for (uint32_t i = 0; i < TRAINS; i++) {
        checks[i].view = credits[1 + i].view;
        for (uint64_t step = from + 1; step <= 12 * TRAINS; step++)
            if (credits[step].view == checks[i].view) {
                predicted[i] += credits[step].psnr;
                predicted_loss[i] += credits[step].loss;
            }
    }
    for (uint64_t step = 12 * TRAINS; step > 0; step -= 1)
        if (step % 5 == 0 || step > 12 * TRAINS - 10) printf("%3d view %u psnr %9.5f loss %9.6f size %9.4f %9.5f\n", (int)step, credits[step].view, credits[step].psnr, credits[step].loss, credits[step].size_psnr, credits[step].size_loss);
    ASSERT_OK(vw_lasting_measure(lasting, from, checks, TRAINS));
    for (uint32_t i = 0; i < TRAINS; i++)
        printf("view %u: predicted %f measured %f; loss %f %f\n", checks[i].view, predicted[i], checks[i].measured_psnr,
               predicted_loss[i], checks[i].measured_loss);
    vw_lasting_destroy(&lasting);
    test_run_free(run);
    vw_scene_close(&scene);
}

static void bits_are_the_same(void **state) {
    (void)state;
    const struct vw_config config = lasting_config();
    struct vw_scene *scene = test_scene();
    struct vw_lasting_credit whole[12 * TRAINS + 1] = {0}, cut[12 * TRAINS + 1] = {0};
    struct vw_lasting *lasting = open_lasting(scene, &config, 0, 0, NULL);
    sweep(lasting, whole);
    vw_lasting_destroy(&lasting);
    lasting = open_lasting(scene, &config, 0, 2 << 20, NULL);
    struct vw_lasting_state status;
    vw_lasting_get_state(lasting, &status);
    printf("work %d memory %d\n", (int)status.work_total, (int)status.memory_bytes);
    sweep(lasting, cut);
    assert_same_credits(whole, cut, 12 * TRAINS);
    vw_lasting_destroy(&lasting);
    vw_scene_close(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(gate_agrees),
        cmocka_unit_test(bits_are_the_same),
    };
    return cmocka_run_group_tests(tests, NULL, test_gpu_close);
}
