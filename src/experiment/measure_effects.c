#include "experiment/measure_effects.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/output/json_output.h"
#include "experiment/sweep/paired_timing.h"
#include "train/trainer.h"
#include "base/memory.h"

enum { ROUNDS = 12, STEPS_PER_BATCH = 8, TRAININGS_MAX = VW_EFFECT_COUNT_MAX + 2 };
static const char none[] = "(all)";

static enum vw_status enter(const struct vw_trainer_params *shared, const char *without,
                            struct vw_timed_trainer *timed) {
    struct vw_effect_verdict effects[VW_EFFECT_COUNT_MAX];
    struct vw_trainer_params params = *shared;
    memcpy(effects, shared->effects, shared->effect_count * sizeof *effects);
    for (uint32_t i = 0; i < shared->effect_count; i++)
        if (without == none || (without && !strcmp(effects[i].name, without))) effects[i].on = false;
    params.effects = effects;
    return vw_timed_trainer_open(&params, ROUNDS, timed);
}

static void finish(const struct vw_timed_trainer *timed, struct vw_measured_training *training) {
    struct vw_step_timing result = vw_timed_trainer_result(timed, ROUNDS);
    training->ms_per_step = result.ms_per_step;
    training->psnr_db = result.psnr_db;
    training->param_count = timed->param_count;
    training->device_bytes = timed->device_bytes;
}

static void list_trainings(const struct vw_effect_verdict *effects, uint32_t effect_count,
                           struct vw_measurement *measurement) {
    measurement->trainings[measurement->count++].without = NULL;
    for (uint32_t i = 0; i < effect_count; i++)
        if (effects[i].on) measurement->trainings[measurement->count++].without = effects[i].name;
    if (measurement->count > 2) measurement->trainings[measurement->count++].without = none;
}

enum vw_status vw_measure_effects(const struct vw_options *options, const struct vw_scene *scene, struct vw_gpu *gpu,
                                  const struct vw_effect_verdict *effects, uint32_t effect_count,
                                  struct vw_measurement *measurement) {
    struct vw_timed_trainer *trainers = vw_allocate(TRAININGS_MAX, sizeof *trainers);
    if (!trainers) return VW_ERROR_MEMORY;
    measurement->steps = ROUNDS * 2 * STEPS_PER_BATCH; // a turn is two batches
    const struct vw_trainer_params params = {.gpu = gpu,
                                             .scene = scene,
                                             .config = &options->config,
                                             .effects = effects,
                                             .effect_count = effect_count,
                                             .validate = true,
                                             .steps_per_batch = STEPS_PER_BATCH};
    list_trainings(effects, effect_count, measurement);
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < measurement->count; i++) {
        const char *without = measurement->trainings[i].without;
        status = enter(&params, without, &trainers[i]);
        if (!status && i == 0) { // the device layer's own transfer buffer came with the first
            vw_timed_trainer_close(&trainers[i]);
            status = enter(&params, without, &trainers[i]);
        }
    }
    if (!status) status = vw_paired_timing_run(trainers, measurement->count, ROUNDS);
    for (uint32_t i = 0; i < measurement->count; i++) {
        if (!status) finish(&trainers[i], &measurement->trainings[i]);
        vw_timed_trainer_close(&trainers[i]);
    }
    free(trainers);
    return status;
}

void vw_measurement_print(const struct vw_measurement *measurement) {
    if (!measurement->count) return;
    const struct vw_measured_training *all = &measurement->trainings[0];
    printf(
        "\nmeasured over %u steps, trainings in turn: all effects called for take %.3g ms per step and reach %.2f dB\n",
        measurement->steps, all->ms_per_step, all->psnr_db);
    printf("effect          ms on     ms off    params    bytes       PSNR gained, dB\n");
    for (uint32_t i = 1; i < measurement->count; i++) {
        const struct vw_measured_training *off = &measurement->trainings[i];
        printf("%-15s %-9.4g %-9.4g %-9" PRId64 " %-11" PRId64 " %+.2f\n", off->without, all->ms_per_step,
               off->ms_per_step, (int64_t)(all->param_count - off->param_count),
               (int64_t)(all->device_bytes - off->device_bytes), all->psnr_db - off->psnr_db);
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
        json_t *entry =
            json_pack("{s:s, s:f, s:f, s:I, s:I, s:o}", "effect", off->without, "ms_per_step_on", all->ms_per_step,
                      "ms_per_step_off", off->ms_per_step, "params", (json_int_t)(all->param_count - off->param_count),
                      "bytes", (json_int_t)(all->device_bytes - off->device_bytes), "psnr_gained_db",
                      vw_json_real(all->psnr_db - off->psnr_db));
        if (json_array_append_new(array, entry)) {
            json_decref(array);
            array = NULL;
        }
    }
    return array;
}
