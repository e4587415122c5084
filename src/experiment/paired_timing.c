#include "experiment/paired_timing.h"

#include <math.h>
#include <string.h>

#include "base/clock.h"
#include "base/statistics.h"
#include "gpu/compute.h"

enum { LAST_ROUNDS = 3 }; // their PSNR counts

enum vw_status vw_timed_trainer_open(const struct vw_trainer_params *params, uint32_t rounds,
                                     struct vw_timed_trainer *timed) {
    struct vw_config config = *params->config;
    struct vw_trainer_params ours = *params;
    struct vw_trainer_stats stats;
    config.epochs = 1 + rounds * 2 * params->steps_per_submission; // an epoch has at least one step
    ours.config = &config;
    uint64_t before = vw_gpu_buffer_bytes(params->gpu);
    enum vw_status status = vw_trainer_create(&ours, &timed->trainer);
    if (status) return status;
    vw_trainer_get_stats(timed->trainer, &stats);
    timed->param_count = stats.param_count;
    timed->device_bytes = stats.device_bytes - before;
    return VW_OK;
}

static enum vw_status take_steps(struct vw_timed_trainer *timed, uint32_t round, bool last) {
    const struct vw_step_record *records;
    uint32_t count = 1, steps = 0;
    double started_s = vw_now_s(), started_cpu_s = vw_cpu_s();
    enum vw_status status = vw_trainer_advance(timed->trainer, &records, &count);
    while (!status && count > 0) {
        for (uint32_t i = 0; i < count; i++) {
            steps += records[i].step > 0;
            if (!last || !isfinite(records[i].val_psnr)) continue;
            timed->psnr_sum_db += records[i].val_psnr;
            timed->psnr_count++;
        }
        status = vw_trainer_collect(timed->trainer, &records, &count);
    }
    timed->ms_per_step[round] = steps ? 1e3 * (vw_now_s() - started_s) / steps : NAN;
    timed->cpu_ms_per_step[round] = steps ? 1e3 * (vw_cpu_s() - started_cpu_s) / steps : NAN;
    return status;
}

enum vw_status vw_paired_timing_run(struct vw_timed_trainer *trainers, uint32_t count, uint32_t rounds,
                                    const struct vw_interrupt *interrupt) {
    enum vw_status status = VW_OK;
    for (uint32_t round = 0; round < rounds; round++)
        for (uint32_t i = 0; i < count && !status; i++) {
            status = take_steps(&trainers[i], round, round >= rounds - LAST_ROUNDS);
            if (!status && vw_interrupt_requested(interrupt))
                status = vw_fail(VW_ERROR_INTERRUPTED, "interrupted while timing steps; start again");
        }
    return status;
}

struct vw_step_timing vw_timed_trainer_result(const struct vw_timed_trainer *timed, uint32_t rounds) {
    double wall_ms[VW_TIMING_ROUNDS_MAX], cpu_ms[VW_TIMING_ROUNDS_MAX];
    memcpy(wall_ms, timed->ms_per_step, sizeof wall_ms);
    memcpy(cpu_ms, timed->cpu_ms_per_step, sizeof cpu_ms);
    return (struct vw_step_timing){.ms_per_step = vw_median(wall_ms + 1, rounds - 1),
                                   .cpu_ms_per_step = vw_median(cpu_ms + 1, rounds - 1),
                                   .psnr_db = timed->psnr_count ? timed->psnr_sum_db / timed->psnr_count : NAN};
}

void vw_timed_trainer_close(struct vw_timed_trainer *timed) { vw_trainer_destroy(&timed->trainer); }
