#include "cli/measure_effects.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/json_output.h"
#include "viewworth/log.h"
#include "viewworth/memory.h"
#include "viewworth/statistics.h"

enum {
    ROUNDS = 12,
    STEPS_PER_BATCH = 8, // a round is two batches
    LAST_ROUNDS = 3,     // whose PSNR counts
    TRAININGS_MAX = VW_EFFECT_COUNT_MAX + 2,
};
static const char none[] = "(all)";

// One of the trainings that take turns, so that what else the machine does meets all of them alike.
struct contender {
    struct vw_trainer *trainer;
    double ms_per_step[ROUNDS];
    double psnr_sum_db;
    uint32_t psnr_count;
};

static enum vw_status take_round(struct contender *contender, uint32_t round) {
    const struct vw_step_record *records;
    uint32_t count = 1, steps = 0;
    double started_s = vw_now_s();
    enum vw_status status = vw_trainer_advance(contender->trainer, &records, &count);
    while (!status && count > 0) {
        for (uint32_t i = 0; i < count; i++) {
            steps += records[i].step > 0;
            if (round < ROUNDS - LAST_ROUNDS || !isfinite(records[i].val_psnr)) continue;
            contender->psnr_sum_db += records[i].val_psnr;
            contender->psnr_count++;
        }
        status = vw_trainer_collect(contender->trainer, &records, &count);
    }
    contender->ms_per_step[round] = steps ? 1e3 * (vw_now_s() - started_s) / steps : NAN;
    return status;
}

// The first round compiles and warms up.
static void conclude(struct contender *contender, struct vw_measured_training *training) {
    training->ms_per_step = vw_median(contender->ms_per_step + 1, ROUNDS - 1);
    training->psnr_db = contender->psnr_count ? contender->psnr_sum_db / contender->psnr_count : NAN;
}

static enum vw_status enter(const struct vw_trainer_params *shared, struct contender *contender, struct vw_measured_training *training) {
    struct vw_effect_verdict effects[VW_EFFECT_COUNT_MAX];
    struct vw_trainer_params params = *shared;
    struct vw_trainer_stats stats;
    memcpy(effects, shared->effects, shared->effect_count * sizeof *effects);
    for (uint32_t i = 0; i < shared->effect_count; i++)
        if (training->without == none || (training->without && !strcmp(effects[i].name, training->without))) effects[i].on = false;
    params.effects = effects;
    uint64_t before = vw_gpu_buffer_bytes(shared->gpu);
    enum vw_status status = vw_trainer_create(&params, &contender->trainer);
    if (status) return status;
    vw_trainer_get_stats(contender->trainer, &stats);
    training->param_count = stats.param_count;
    training->device_bytes = stats.device_bytes - before;
    return VW_OK;
}

static void list_trainings(const struct vw_effect_verdict *effects, uint32_t effect_count, struct vw_measurement *measurement) {
    measurement->trainings[measurement->count++].without = NULL;
    for (uint32_t i = 0; i < effect_count; i++)
        if (effects[i].on) measurement->trainings[measurement->count++].without = effects[i].name;
    if (measurement->count > 2) measurement->trainings[measurement->count++].without = none;
}

enum vw_status vw_measure_effects(const struct vw_options *options, const struct vw_scene *scene, struct vw_gpu *gpu,
                                  const struct vw_effect_verdict *effects, uint32_t effect_count, struct vw_measurement *measurement) {
    struct contender *contenders = vw_allocate(TRAININGS_MAX, sizeof *contenders);
    struct vw_config config = options->config;
    if (!contenders) return VW_ERROR_MEMORY;
    measurement->steps = ROUNDS * 2 * STEPS_PER_BATCH;
    config.epochs = 1 + measurement->steps; // of which only so many steps are taken
    const struct vw_trainer_params params = {.gpu = gpu,
                                             .scene = scene,
                                             .config = &config,
                                             .effects = effects,
                                             .effect_count = effect_count,
                                             .validate = true,
                                             .steps_per_batch = STEPS_PER_BATCH};
    list_trainings(effects, effect_count, measurement);
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < measurement->count; i++) {
        status = enter(&params, &contenders[i], &measurement->trainings[i]);
        if (!status && i == 0) { // the device layer's own transfer buffer came with the first
            vw_trainer_destroy(&contenders[i].trainer);
            status = enter(&params, &contenders[i], &measurement->trainings[i]);
        }
    }
    for (uint32_t round = 0; round < ROUNDS; round++)
        for (uint32_t i = 0; !status && i < measurement->count; i++) status = take_round(&contenders[i], round);
    for (uint32_t i = 0; i < measurement->count; i++) {
        conclude(&contenders[i], &measurement->trainings[i]);
        vw_trainer_destroy(&contenders[i].trainer);
    }
    free(contenders);
    return status;
}

void vw_measurement_print(const struct vw_measurement *measurement) {
    if (!measurement->count) return;
    const struct vw_measured_training *all = &measurement->trainings[0];
    printf("\nmeasured over %u steps, trainings in turn: all effects called for take %.3g ms per step and reach %.2f dB\n",
           measurement->steps, all->ms_per_step, all->psnr_db);
    printf("effect          ms on     ms off    params    bytes       PSNR gained, dB\n");
    for (uint32_t i = 1; i < measurement->count; i++) {
        const struct vw_measured_training *off = &measurement->trainings[i];
        printf("%-15s %-9.4g %-9.4g %-9" PRId64 " %-11" PRId64 " %+.2f\n", off->without, all->ms_per_step, off->ms_per_step,
               (int64_t)(all->param_count - off->param_count), (int64_t)(all->device_bytes - off->device_bytes),
               all->psnr_db - off->psnr_db);
    }
    for (uint32_t i = 1; i < measurement->count; i++)
        if (!strcmp(measurement->trainings[i].without, "masks"))
            printf("without masks, masked pixels are validated on, too: its dB compare other pixels\n");
}

json_t *vw_measurement_to_json(const struct vw_measurement *measurement) {
    json_t *array = json_array();
    const struct vw_measured_training *all = &measurement->trainings[0];
    for (uint32_t i = 1; array && i < measurement->count; i++) {
        const struct vw_measured_training *off = &measurement->trainings[i];
        json_t *entry = json_pack("{s:s, s:f, s:f, s:I, s:I, s:o}", "effect", off->without, "ms_per_step_on", all->ms_per_step,
                                  "ms_per_step_off", off->ms_per_step, "params", (json_int_t)(all->param_count - off->param_count), "bytes",
                                  (json_int_t)(all->device_bytes - off->device_bytes), "psnr_gained_db",
                                  vw_json_real(all->psnr_db - off->psnr_db));
        if (json_array_append_new(array, entry)) {
            json_decref(array);
            array = NULL;
        }
    }
    return array;
}
