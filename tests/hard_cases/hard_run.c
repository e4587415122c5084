#include "hard_cases/hard_run.h"
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "base/statistics.h"
#include "gpu/compute.h"
#include "reference/reference.h"
#include "support/gpu_fixture.h"
#include "support/trainer_fixture.h"
#include "train/trainer.h"
#include "train/trainer_private.h"

// Root mean squares and means of errors differ by no more than the largest error of a colour: see
// hard_check_rendering().
static const double ERROR_TOLERANCE = 1e-5;
static const double PSNR_TOLERANCE_DB = 1e-12; // the same formula in double

static struct vw_trainer *trainer; // trainer of the run under way

struct vw_config hard_run_config(void) {
    struct vw_config config = test_config();
    config.seed = 331;
    config.rays = 64;
    config.log2_table = 8;
    return config;
}

static void check_record(struct hard_finding *finding, const struct vw_step_record *record) {
    const double values[] = {record->val_psnr, record->val_psnr_pooled, record->val_l1};
    for (size_t i = 0; i < VW_ARRAY_COUNT(values); i++)
        hard_require(finding, record->nonfinite ? isnan(values[i]) : isfinite(values[i]),
                     "a record is finite, or flagged without values");
    if (record->step > 0 && !record->nonfinite)
        hard_require(finding, isfinite(record->train_loss), "the loss of a sound step is finite");
    if (record->nonfinite) return;
    double psnr = 0.0;
    for (uint32_t i = 0; i < record->view_count; i++) psnr += vw_psnr_db(record->views[i].mse) / record->view_count;
    hard_require(finding, fabs(record->val_psnr - psnr) <= PSNR_TOLERANCE_DB, "PSNR is the mean over the views");
}

static void file_record(struct hard_run *run, const struct vw_step_record *record) {
    if (run->steps++ == 0) run->first = *record;
    run->flagged_steps += record->nonfinite;
    run->view_count = record->view_count;
    memcpy(run->views, record->views, record->view_count * sizeof *record->views);
    run->last = *record;
    run->first.views = run->last.views = NULL;
}

// Finds the view's gain and bias by the reference, from what the reference rendered; 0 where nothing is fitted.
static struct reference_photo fit(const struct reference_step *reference, struct vw_ray_range range) {
    struct reference_photo photo = {0};
    double *rendered = test_allocate(range.count, sizeof *rendered),
           *target = test_allocate(range.count, sizeof *target);
    for (int c = 0; c < 3 && range.count; c++) {
        uint32_t count = 0;
        for (uint32_t ray = range.first; ray < range.first + range.count; ray++) {
            if (reference->rays[ray].weight == 0.0) continue;
            rendered[count] = reference->colours[ray][c];
            target[count++] = reference->rays[ray].target[c];
        }
        reference_fit_channel(rendered, target, count, &photo.gain[c], &photo.bias[c]);
    }
    return photo;
}

// Pixels without weight count neither as errors nor in the means.
static void compare_view(struct hard_finding *finding, const struct reference_step *reference,
                         struct vw_ray_range range, const struct reference_photo *photo, uint32_t view,
                         const struct vw_view_error *device) {
    double squared = 0.0, absolute = 0.0, values = 0.0;
    for (uint32_t ray = range.first; ray < range.first + range.count; ray++) {
        double seen[3];
        reference_appear(photo, reference->colours[ray], seen);
        for (int c = 0; c < 3 && reference->rays[ray].weight != 0.0; c++) {
            double error = seen[c] - reference->rays[ray].target[c];
            squared += error * error;
            absolute += fabs(error);
            values += 1.0;
        }
    }
    hard_compare(finding, "RMSE of a view", view, sqrt(device->mse), sqrt(squared / values), 1.0, ERROR_TOLERANCE);
    hard_compare(finding, "L1 of a view", view, device->l1, absolute / values, 1.0, ERROR_TOLERANCE);
}

static void compare_validation(struct hard_finding *finding, const float *params, const struct hard_run *run) {
    struct vw_ray *rays = test_read(trainer->validation.evaluator.rays);
    struct vw_ray_range *ranges = test_read(trainer->validation.ranges);
    struct reference_params *reference_params = reference_params_create(&trainer->model, params);
    struct vw_ray_range *fit_ranges =
        trainer->validation.view_fit.ranges ? test_read(trainer->validation.view_fit.ranges) : NULL;
    struct reference_step *reference =
        reference_step_create(&trainer->model, rays, trainer->validation.evaluator.ray_count);
    reference_step_forward(reference, reference_params, false, 0);
    for (uint32_t i = 0; i < run->view_count; i++) {
        struct reference_photo photo = fit(reference, fit_ranges ? fit_ranges[i] : (struct vw_ray_range){0});
        compare_view(finding, reference, ranges[i], &photo, i, &run->views[i]);
    }
}

static void run_to_the_end(struct hard_finding *finding, struct hard_run *run) {
    const struct vw_step_record *records;
    uint32_t count;
    do {
        ASSERT_OK(vw_trainer_advance(trainer, &records, &count));
        for (uint32_t i = 0; i < count; i++) {
            assert_true(records[i].view_count <= HARD_VIEWS_MAX);
            check_record(finding, &records[i]);
            file_record(run, &records[i]);
        }
    } while (count);
}

static struct hard_run train(struct hard_finding *finding, const struct vw_scene *scene, const struct vw_config *config,
                             bool well) {
    struct hard_run run = {0};
    trainer = test_trainer_open(
        (struct vw_trainer_params){.gpu = test_gpu(), .scene = scene, .config = config, .validate = true});
    float *before = test_read(trainer->field.params);
    run_to_the_end(finding, &run);
    float *params = test_read(trainer->field.params);
    for (uint64_t i = 0; i < trainer->model.param_bytes / sizeof *params; i++)
        hard_require(finding, isfinite(params[i]), "every param is finite");
    run.still = !memcmp(params, before, trainer->model.param_bytes);
    if (well) {
        hard_require(finding, run.flagged_steps == 0, "no step is flagged");
        compare_validation(finding, params, &run);
    }
    test_release(trainer);
    return run;
}

struct hard_run hard_train(struct hard_finding *finding, const struct vw_scene *scene, const struct vw_config *config) {
    return train(finding, scene, config, false);
}

struct hard_run hard_train_well(struct hard_finding *finding, const struct vw_scene *scene,
                                const struct vw_config *config) {
    return train(finding, scene, config, true);
}
