// `value --first-order`: the slope of validation along a step is the reference's gradient times the step, and what the
// step does is that slope as learning rates shrink; the run itself is left alone.
#include "support/cmocka_test.h"

#include <stdint.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "reference/reference.h"
#include "support/trainer_fixture.h"
#include "gpu/compute.h"
#include "train/trainer.h"
#include "base/memory.h"

static struct vw_config probing_config(void) {
    struct vw_config config = test_config();
    config.first_order = true;
    config.burn_in_epochs = 1;
    return config;
}

// ---- The run --------------------------------------------------------------------------------------------------------

static void probes_leave_the_run_alone(void **state) {
    (void)state;
    static const char *const effects[] = {"none", "sky,appearance,appearance_code", "occupancy"};
    struct vw_scene *scene = test_scene();
    for (size_t i = 0; i < VW_ARRAY_COUNT(effects); i++) {
        struct vw_config pilot = probing_config(), plain;
        strcpy(pilot.effects, effects[i]);
        pilot.beta1 = i == 0 ? 0.9 : 0.0;
        plain = pilot;
        plain.first_order = false;
        struct test_run *probed = test_run(scene, &pilot, true, 0), *bare = test_run(scene, &plain, true, 0);
        assert_int_equal(bare->probe_count, 0);
        assert_int_equal(probed->probe_count, 2 * 5); // the steps behind burn-in
        for (uint32_t k = 0; k < probed->probe_count; k++) {
            const struct vw_probe *probe = &probed->probes[k];
            assert_true(probe->step == 6 + k && probe->index == 0 && probe->kind == VW_PROBE_FIRST_ORDER);
            assert_true(probe->view == VW_RECORD_UNTRAINED && isfinite(probe->val_psnr) && isfinite(probe->val_l1));
        }
        probed->probe_count = 0;
        test_run_assert_same(bare, probed);
        test_run_free(probed);
        test_run_free(bare);
    }
    vw_scene_close(&scene);
}

// ---- Against the reference ------------------------------------------------------------------------------------------

// The derivative of a loss, summed over the rays of a validation view, along the step.
static double dot_step(const struct reference_step *reference, const struct reference_params *before,
                       const struct reference_params *after) {
    double dot = 0.0;
    const double *gradient = (const double *)&reference->d_weights, *from = (const double *)&before->weights,
                 *to = (const double *)&after->weights;
    for (size_t i = 0; i < sizeof reference->d_weights / sizeof *gradient; i++) dot += gradient[i] * (to[i] - from[i]);
    for (size_t i = 0; i < 2 * (size_t)reference->model->pair_count; i++)
        dot += reference->d_grid[i] * (after->grid[i] - before->grid[i]);
    for (size_t i = 0; i < 3 * VW_SKY_COLUMNS && reference->model->sky.size_bytes; i++)
        dot += reference->d_sky[i / 3][i % 3] * (after->sky[i / 3][i % 3] - before->sky[i / 3][i % 3]);
    return dot;
}

struct slopes {
    double psnr, pooled, l1;
};

struct summed_loss {
    double value, slope;
};

static struct summed_loss loss_of_view(const struct vw_trainer *trainer, const struct vw_ray *rays, uint32_t count,
                                       uint32_t loss, const struct reference_params *before,
                                       const struct reference_params *after) {
    struct model model = trainer->model;
    model.specialization.loss = loss;
    struct reference_step *reference = reference_step_create(&model, rays, count);
    reference_step_forward(reference, before, false, 0);
    reference_step_backward(reference, before);
    struct summed_loss result = {reference->loss, dot_step(reference, before, after)};
    reference_step_destroy(reference);
    return result;
}

static void *read_all(struct vw_buffer *buffer) {
    void *bytes = vw_allocate(vw_buffer_size_bytes(buffer), 1);
    ASSERT_OK(vw_buffer_read(buffer, 0, bytes, vw_buffer_size_bytes(buffer)));
    return bytes;
}

// Of the step that the trainer took last.
static struct slopes reference_slopes(struct vw_trainer *trainer) {
    float *from = read_all(trainer->probes.first_order->before), *to = read_all(trainer->probes.first_order->after);
    struct vw_ray *rays = read_all(trainer->validation.evaluator.rays);
    struct vw_ray_range *ranges = read_all(trainer->validation.ranges);
    struct reference_params *before = reference_params_create(&trainer->model, from),
                            *after = reference_params_create(&trainer->model, to);
    struct slopes slopes = {0};
    struct summed_loss squared = {0};
    const double decibels = -10.0 / log(10.0);
    double pixels = 0.0;
    for (uint32_t i = 0; i < trainer->validation.view_count; i++) {
        const struct vw_ray *first = rays + ranges[i].first;
        struct summed_loss l2 = loss_of_view(trainer, first, ranges[i].count, LOSS_L2, before, after);
        slopes.psnr += decibels * l2.slope / l2.value / trainer->validation.view_count;
        slopes.l1 += loss_of_view(trainer, first, ranges[i].count, LOSS_L1, before, after).slope;
        squared.value += l2.value;
        squared.slope += l2.slope;
        pixels += trainer->validation.pixel_counts[i];
    }
    slopes.pooled = decibels * squared.slope / squared.value;
    slopes.l1 /= pixels;
    reference_params_destroy(before);
    reference_params_destroy(after);
    free(from);
    free(to);
    free(rays);
    free(ranges);
    return slopes;
}

// Takes what is left of a batch of one step, and one more.
static bool take_step(struct vw_trainer *trainer, struct vw_probe *probe) {
    const struct vw_step_record *records;
    uint32_t count;
    bool probed = false;
    ASSERT_OK(vw_trainer_advance(trainer, &records, &count));
    assert_true(count > 0);
    while (count) {
        probed = records[count - 1].probe_count > 0;
        if (probed) *probe = records[count - 1].probes[0];
        ASSERT_OK(vw_trainer_collect(trainer, &records, &count));
    }
    return probed;
}

struct misfit {
    double psnr, pooled, l1; // root mean square over steps, as a share of that of the slopes
};

static double squared(double x) { return x * x; }

static struct misfit misfit_to_reference(const struct vw_config *config) {
    struct vw_scene *scene = test_scene();
    struct vw_trainer *trainer = test_trainer_create(scene, config, true, 1);
    struct vw_probe probe = {0};
    struct slopes off = {0}, scale = {0};
    while (probe.step < vw_trainer_total_steps(trainer)) {
        if (!take_step(trainer, &probe)) continue;
        struct slopes reference = reference_slopes(trainer);
        off.psnr += squared(probe.val_psnr - reference.psnr);
        off.pooled += squared(probe.val_psnr_pooled - reference.pooled);
        off.l1 += squared(probe.val_l1 - reference.l1);
        scale.psnr += squared(reference.psnr);
        scale.pooled += squared(reference.pooled);
        scale.l1 += squared(reference.l1);
    }
    vw_trainer_destroy(&trainer);
    vw_scene_close(&scene);
    assert_true(scale.psnr > 0.0 && scale.pooled > 0.0 && scale.l1 > 0.0);
    return (struct misfit){sqrt(off.psnr / scale.psnr), sqrt(off.pooled / scale.pooled), sqrt(off.l1 / scale.l1)};
}

static void a_probe_is_the_gradient_times_the_step(void **state) {
    (void)state;
    // About twice what was seen. L1 has kinks wherever a validation pixel is met exactly, and a larger step passes more
    // of them.
    const struct {
        const char *effects;
        double learning_rate, beta1, psnr_tolerance, l1_tolerance;
    } cases[] = {
        {"none", 3e-4, 0.0, 0.0015, 0.0015}, {"none", 3e-3, 0.0, 0.001, 0.015}, {"none", 1e-2, 0.0, 0.015, 0.035},
        {"none", 3e-3, 0.9, 0.001, 0.006},   {"sky", 3e-3, 0.0, 0.005, 0.015},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        struct vw_config config = probing_config();
        config.epochs = 8;
        config.learning_rate = cases[i].learning_rate;
        config.beta1 = cases[i].beta1;
        strcpy(config.effects, cases[i].effects);
        struct misfit misfit = misfit_to_reference(&config);
        if (!(misfit.psnr <= cases[i].psnr_tolerance && misfit.pooled <= cases[i].psnr_tolerance &&
              misfit.l1 <= cases[i].l1_tolerance))
            fail_msg(
                "%s, --lr %g, --beta1 %g: off by %g, %g and %g of the slopes of PSNR, of its pooled form and of L1",
                cases[i].effects, cases[i].learning_rate, cases[i].beta1, misfit.psnr, misfit.pooled, misfit.l1);
    }
}

// ---- Small steps ----------------------------------------------------------------------------------------------------

struct ratio {
    double psnr, l1; // what all steps predict, by what they did
};

// Of three epochs that begin with a trained field.
static struct ratio predicted_by_actual(const struct vw_scene *scene, const struct test_run *trained,
                                        double learning_rate) {
    struct vw_config config = probing_config();
    config.learning_rate = learning_rate;
    config.burn_in_epochs = 0;
    struct test_run *run = vw_allocate(1, sizeof *run);
    struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 0);
    ASSERT_OK(vw_buffer_write(trainer->field.params, 0, trained->params, 4 * (uint64_t)trained->param_words));
    test_run_finish(trainer, run);
    vw_trainer_destroy(&trainer);
    const struct vw_step_record *start = &run->records[run->probes[0].step - 1], *end = &run->records[run->count - 1];
    double psnr = 0.0, l1 = 0.0;
    for (uint32_t i = 0; i < run->probe_count; i++) {
        psnr += run->probes[i].val_psnr;
        l1 += run->probes[i].val_l1;
    }
    assert_int_equal(run->probe_count, run->count - 1);
    struct ratio ratio = {psnr / (end->val_psnr - start->val_psnr), l1 / (end->val_l1 - start->val_l1)};
    test_run_free(run);
    return ratio;
}

// The steps' deltas add up to last minus first; the slopes add up to nearly that where steps are short: what they leave
// out is of the second order, so that its share falls as the steps do. (In a new field it does not: its values before
// the ReLUs are so near 0 that any step flips some.)
static void predictions_come_true_as_steps_shrink(void **state) {
    (void)state;
    const double rates[] = {1e-3, 1e-4}; // of shorter steps, the slopes are lost in the rounding of params
    double psnr[2], l1[2];
    struct vw_scene *scene = test_scene();
    struct vw_config config = test_config();
    config.epochs = 8;
    struct test_run *trained = test_run(scene, &config, true, 0);
    for (int i = 0; i < 2; i++) {
        struct ratio ratio = predicted_by_actual(scene, trained, rates[i]);
        psnr[i] = fabs(ratio.psnr - 1.0);
        l1[i] = fabs(ratio.l1 - 1.0);
    }
    if (!(psnr[0] < 0.1 && psnr[1] < psnr[0] / 4.0))
        fail_msg("the slopes of PSNR leave out %g of long steps and %g of short ones", psnr[0], psnr[1]);
    if (!(l1[0] < 0.1 && l1[1] < 0.003)) // of either sign: kinks
        fail_msg("the slopes of L1 leave out %g of long steps and %g of short ones", l1[0], l1[1]);
    test_run_free(trained);
    vw_scene_close(&scene);
}

static void a_step_that_is_skipped_predicts_nothing(void **state) {
    (void)state;
    struct vw_scene *scene = test_scene();
    struct vw_config config = probing_config();
    struct test_run *run = vw_allocate(1, sizeof *run);
    struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 1);
    const float nan = NAN;
    ASSERT_OK(vw_buffer_write(trainer->field.params, trainer->model.weights.offset_bytes, &nan, sizeof nan));
    test_run_finish(trainer, run);
    assert_int_equal(run->probe_count, 2 * 5);
    for (uint32_t i = 0; i < run->probe_count; i++)
        assert_true(isnan(run->probes[i].val_psnr) && isnan(run->probes[i].val_psnr_pooled) &&
                    isnan(run->probes[i].val_l1));
    vw_trainer_destroy(&trainer);
    test_run_free(run);
    vw_scene_close(&scene);
}

static void without_validation_there_is_nothing_to_predict(void **state) {
    (void)state;
    struct vw_scene *scene = test_scene();
    struct vw_config config = probing_config();
    struct vw_trainer *trainer = NULL;
    const struct vw_trainer_params params = {.gpu = test_gpu(), .scene = scene, .config = &config};
    assert_int_equal(test_trainer_open(params, &trainer), VW_ERROR_USAGE);
    assert_non_null(strstr(vw_error_message(), "--first-order: needs validation"));
    vw_scene_close(&scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(probes_leave_the_run_alone),
        cmocka_unit_test(a_probe_is_the_gradient_times_the_step),
        cmocka_unit_test(predictions_come_true_as_steps_shrink),
        cmocka_unit_test(a_step_that_is_skipped_predicts_nothing),
        cmocka_unit_test(without_validation_there_is_nothing_to_predict),
    };
    return cmocka_run_group_tests(tests, NULL, test_gpu_close);
}
