#include "cli/turns.h"

#include <math.h>
#include <string.h>

#include "cli/interrupt.h"
#include "viewworth/log.h"
#include "viewworth/statistics.h"

enum { LAST_ROUNDS = 3 }; // whose PSNR counts

enum vw_status vw_turn_taker_enter(const struct vw_trainer_params *params, uint32_t rounds, struct vw_turn_taker *taker) {
    struct vw_config config = *params->config;
    struct vw_trainer_params ours = *params;
    struct vw_trainer_stats stats;
    config.epochs = 1 + rounds * 2 * params->steps_per_batch; // of which only so many steps are taken
    ours.config = &config;
    uint64_t before = vw_gpu_buffer_bytes(params->gpu);
    enum vw_status status = vw_trainer_create(&ours, &taker->trainer);
    if (status) return status;
    vw_trainer_get_stats(taker->trainer, &stats);
    taker->param_count = stats.param_count;
    taker->device_bytes = stats.device_bytes - before;
    return VW_OK;
}

static enum vw_status take_turn(struct vw_turn_taker *taker, uint32_t round, bool last) {
    const struct vw_step_record *records;
    uint32_t count = 1, steps = 0;
    double started_s = vw_now_s(), started_cpu_s = vw_cpu_s();
    enum vw_status status = vw_trainer_advance(taker->trainer, &records, &count);
    while (!status && count > 0) {
        for (uint32_t i = 0; i < count; i++) {
            steps += records[i].step > 0;
            if (!last || !isfinite(records[i].val_psnr)) continue;
            taker->psnr_sum_db += records[i].val_psnr;
            taker->psnr_count++;
        }
        status = vw_trainer_collect(taker->trainer, &records, &count);
    }
    taker->ms_per_step[round] = steps ? 1e3 * (vw_now_s() - started_s) / steps : NAN;
    taker->cpu_ms_per_step[round] = steps ? 1e3 * (vw_cpu_s() - started_cpu_s) / steps : NAN;
    return status;
}

enum vw_status vw_turns_take(struct vw_turn_taker *takers, uint32_t count, uint32_t rounds) {
    enum vw_status status = VW_OK;
    for (uint32_t round = 0; round < rounds; round++)
        for (uint32_t i = 0; i < count && !status; i++) {
            status = take_turn(&takers[i], round, round >= rounds - LAST_ROUNDS);
            if (!status && vw_interrupt_requested()) status = vw_fail(VW_ERROR_INTERRUPTED, "interrupted while measuring; begin again");
        }
    return status;
}

struct vw_turn_result vw_turn_taker_conclude(const struct vw_turn_taker *taker, uint32_t rounds) {
    double wall_ms[VW_TURN_ROUNDS_MAX], cpu_ms[VW_TURN_ROUNDS_MAX];
    memcpy(wall_ms, taker->ms_per_step, sizeof wall_ms);
    memcpy(cpu_ms, taker->cpu_ms_per_step, sizeof cpu_ms);
    return (struct vw_turn_result){.ms_per_step = vw_median(wall_ms + 1, rounds - 1),
                                   .cpu_ms_per_step = vw_median(cpu_ms + 1, rounds - 1),
                                   .psnr_db = taker->psnr_count ? taker->psnr_sum_db / taker->psnr_count : NAN};
}

void vw_turn_taker_leave(struct vw_turn_taker *taker) { vw_trainer_destroy(&taker->trainer); }
