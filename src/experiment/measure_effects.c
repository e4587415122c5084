#include "experiment/measure_effects.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "experiment/paired_timing.h"
#include "train/trainer.h"

enum { ROUNDS = 12, STEPS_PER_BATCH = 8, TRAININGS_MAX = VW_EFFECT_COUNT_MAX + 2 };
static const char all[] = "(all)";

static enum vw_status open_trainer(const struct vw_trainer_params *shared, const char *without,
                                   struct vw_timed_trainer *timed) {
    struct vw_effect_verdict effects[VW_EFFECT_COUNT_MAX];
    struct vw_trainer_params params = *shared;
    memcpy(effects, shared->effects, shared->effect_count * sizeof *effects);
    for (uint32_t i = 0; i < shared->effect_count; i++)
        if (without == all || (without && !strcmp(effects[i].name, without))) effects[i].on = false;
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
                           struct vw_measured_effects *measured) {
    measured->trainings[measured->count++].without = NULL;
    for (uint32_t i = 0; i < effect_count; i++)
        if (effects[i].on) measured->trainings[measured->count++].without = effects[i].name;
    if (measured->count > 2) measured->trainings[measured->count++].without = all;
}

static enum vw_status open_trainers(const struct vw_trainer_params *params, const struct vw_measured_effects *measured,
                                    struct vw_timed_trainer *trainers) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < measured->count; i++) {
        status = open_trainer(params, measured->trainings[i].without, &trainers[i]);
        if (!status && i == 0) { // the first one also allocates the device's transfer buffer: open it again without
            vw_timed_trainer_close(&trainers[i]);
            status = open_trainer(params, measured->trainings[i].without, &trainers[i]);
        }
    }
    return status;
}

enum vw_status vw_measure_effects(const struct vw_measure_effects_params *params,
                                  struct vw_measured_effects *measured) {
    struct vw_timed_trainer *trainers = vw_allocate(TRAININGS_MAX, sizeof *trainers);
    if (!trainers) return VW_ERROR_MEMORY;
    measured->steps = ROUNDS * 2 * STEPS_PER_BATCH; // a round is two batches of each
    const struct vw_trainer_params shared = {.gpu = params->gpu,
                                             .scene = params->scene,
                                             .config = params->config,
                                             .effects = params->effects,
                                             .effect_count = params->effect_count,
                                             .validate = true,
                                             .steps_per_batch = STEPS_PER_BATCH};
    list_trainings(params->effects, params->effect_count, measured);
    enum vw_status status = open_trainers(&shared, measured, trainers);
    if (!status) status = vw_paired_timing_run(trainers, measured->count, ROUNDS, &params->interrupt);
    for (uint32_t i = 0; i < measured->count; i++) {
        if (!status) finish(&trainers[i], &measured->trainings[i]);
        vw_timed_trainer_close(&trainers[i]);
    }
    free(trainers);
    return status;
}
