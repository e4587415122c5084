#include "run/plan/estimate.h"

#include <math.h>
#include <stdio.h>

#include "base/clock.h"
#include "train/trainer.h"

static const double MEASURED_SECONDS = 0.3;

static uint64_t count_host_bytes(const struct vw_scene *scene) {
    static const uint64_t channel_bytes[] = {[VW_PIXEL_UINT8] = 1, [VW_PIXEL_UINT16] = 2, [VW_PIXEL_FLOAT32] = 4};
    uint64_t sum = scene->point_count * sizeof *scene->points + scene->track_count * sizeof *scene->tracks;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        const struct vw_view *view = &scene->views[v];
        uint64_t pixels = (uint64_t)view->image.width_px * view->image.height_px; // 0 of excluded photos
        sum += pixels * (4 * channel_bytes[view->image.format] + (view->mask ? 1 : 0));
    }
    return sum;
}

// Times the steps after the first submission, which warms up.
static enum vw_status measure(struct vw_trainer *trainer, struct vw_estimate *estimate) {
    const struct vw_step_record *records = NULL;
    uint32_t count = 0;
    enum vw_status status = vw_trainer_advance(trainer, &records, &count);
    double started_s = vw_now_s(), passed_s = 0;
    while (!status && count > 0 && passed_s < MEASURED_SECONDS) {
        status = vw_trainer_advance(trainer, &records, &count);
        passed_s = vw_now_s() - started_s;
        estimate->measured_steps += count;
    }
    estimate->seconds_per_step = estimate->measured_steps ? passed_s / (double)estimate->measured_steps : NAN;
    return status;
}

enum vw_status vw_estimate_take_steps(const struct vw_trainer_params *params, struct vw_estimate *estimate) {
    struct vw_trainer *trainer = NULL;
    struct vw_trainer_stats stats;
    enum vw_status status = vw_trainer_create(params, &trainer);
    if (status) return status;
    vw_trainer_get_stats(trainer, &stats);
    estimate->param_count = stats.param_count;
    estimate->device_bytes = stats.device_bytes;
    estimate->steps = vw_trainer_total_steps(trainer);
    status = measure(trainer, estimate);
    vw_trainer_destroy(&trainer);
    return status;
}

void vw_estimate_run(const struct vw_config *config, const struct vw_scene *scene, struct vw_gpu *gpu,
                     const struct vw_effect_verdict *effects, uint32_t effect_count, struct vw_estimate *estimate) {
    estimate->host_bytes = count_host_bytes(scene);
    if (!gpu) return;
    snprintf(estimate->device, sizeof estimate->device, "%s", vw_gpu_get_info(gpu)->name);
    const struct vw_trainer_params params = {.gpu = gpu,
                                             .scene = scene,
                                             .config = config,
                                             .effects = effects,
                                             .effect_count = effect_count,
                                             .validate = true};
    if (vw_estimate_take_steps(&params, estimate))
        snprintf(estimate->missing, sizeof estimate->missing, "%.*s", (int)sizeof estimate->missing - 1,
                 vw_error_message());
}
