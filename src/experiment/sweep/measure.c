#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/file.h"
#include "base/memory.h"
#include "base/statistics.h"
#include "experiment/experiment.h"
#include "experiment/sweep/state.h"
#include "experiment/sweep/sweep.h"
#include "gpu/compute.h"
#include "train/trainer.h"
#include "train/training_pool.h"
#include "viewworth/log.h"

enum { ROUNDS = 8, STEPS_PER_SUBMISSION = 2, PIXELS_OF_VIEW_MAX = 1 << 16 };

// ---- Recorded measurements ----

static const struct quantity {
    const char *name;
    size_t offset;
} quantities[] = {
#define QUANTITY(name, field)                                                                                          \
    { name, offsetof(struct vw_measured_configuration, field) }
    QUANTITY("train_ms", train.wall_ms),    QUANTITY("train_cpu_ms", train.cpu_ms),
    QUANTITY("value_ms", value.wall_ms),    QUANTITY("value_cpu_ms", value.cpu_ms),
    QUANTITY("base_ms", base.wall_ms),      QUANTITY("base_cpu_ms", base.cpu_ms),
    QUANTITY("device_bytes", device_bytes),
};

static double *field_of(struct vw_measured_configuration *measured, const struct quantity *quantity) {
    return (double *)((char *)measured + quantity->offset);
}

static bool find(struct vw_sweep_state *state, uint32_t configuration) {
    bool found = true;
    for (size_t i = 0; i < VW_ARRAY_COUNT(quantities) && found; i++)
        found = vw_sweep_store_find(&state->store, state->configuration_ids[configuration], quantities[i].name,
                                    field_of(&state->measured[configuration], &quantities[i]));
    return found;
}

static enum vw_status record(struct vw_sweep_state *state, uint32_t configuration) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(quantities); i++)
        vw_sweep_store_set(&state->store, state->configuration_ids[configuration], quantities[i].name,
                           *field_of(&state->measured[configuration], &quantities[i]));
    return vw_sweep_store_save(&state->store);
}

// ---- Time ----

static struct vw_trainer_params params_of(const struct vw_session *session, const struct vw_config *config,
                                          const struct vw_effect_verdict *effects, bool validate) {
    return (struct vw_trainer_params){.gpu = session->devices[0].gpu,
                                      .scene = session->scene,
                                      .config = config,
                                      .effects = effects,
                                      .effect_count = session->effect_count,
                                      .validate = validate,
                                      .steps_per_submission = STEPS_PER_SUBMISSION};
}

// Switches the verdicts of the base on and off as the configuration says.
static enum vw_status choose_effects(const struct vw_sweep_state *state, uint32_t configuration,
                                     struct vw_effect_verdict effects[VW_EFFECT_COUNT_MAX]) {
    const struct vw_session *session = &state->session;
    memcpy(effects, session->effects, sizeof session->effects);
    return vw_effects_choose(state->configurations->configurations[configuration].config.effects, effects,
                             session->effect_count);
}

// A training whose steps are timed. Several take a few steps each in turn, so that other load on the machine slows all
// alike: their times can be compared even on a busy machine.
struct timed {
    struct vw_trainer_params params;
    struct vw_trainer *trainer;
    uint32_t rounds;                        // that it has taken
    double wall_ms[ROUNDS], cpu_ms[ROUNDS]; // step times by round
    double device_bytes;
};
enum { BASE, TRAIN, VALUE, TIMED };
struct timing {
    struct timed trainings[TIMED];
    const struct vw_interrupt *interrupt;
};

static enum vw_status begin_timed(void *context, const struct vw_pool_seat *seat, enum vw_pool_answer *answer) {
    struct timed *timed = &((struct timing *)context)->trainings[seat->place];
    struct vw_trainer_params params = timed->params;
    struct vw_config config = *params.config;
    struct vw_trainer_stats stats;
    (void)answer;
    config.epochs = 1 + ROUNDS * 2 * STEPS_PER_SUBMISSION; // an epoch has at least one step
    params.config = &config;
    uint64_t before = vw_gpu_buffer_bytes(params.gpu);
    enum vw_status status = vw_trainer_create(&params, &timed->trainer);
    if (status) return status;
    vw_trainer_get_stats(timed->trainer, &stats);
    timed->device_bytes = (double)(stats.device_bytes - before);
    return VW_OK;
}

// Takes a round: two submissions of steps.
static enum vw_status take_round(void *context, const struct vw_pool_seat *seat, bool *ended) {
    const struct timing *timing = context;
    struct timed *timed = &((struct timing *)context)->trainings[seat->place];
    const struct vw_step_record *records;
    uint32_t count = 1, steps = 0;
    double began_s = vw_now_s(), began_cpu_s = vw_cpu_s();
    enum vw_status status = vw_trainer_advance(timed->trainer, &records, &count);
    while (!status && count > 0) {
        for (uint32_t i = 0; i < count; i++) steps += records[i].step > 0;
        status = vw_trainer_collect(timed->trainer, &records, &count);
    }
    timed->wall_ms[timed->rounds] = steps ? 1e3 * (vw_now_s() - began_s) / steps : NAN;
    timed->cpu_ms[timed->rounds] = steps ? 1e3 * (vw_cpu_s() - began_cpu_s) / steps : NAN;
    *ended = ++timed->rounds == ROUNDS;
    if (!status && vw_interrupt_requested(timing->interrupt))
        status = vw_fail(VW_ERROR_INTERRUPTED, "interrupted while timing steps; start again");
    return status;
}

static enum vw_status end_timed(void *context, const struct vw_pool_seat *seat, enum vw_status status) {
    vw_trainer_destroy(&((struct timing *)context)->trainings[seat->place].trainer);
    return status;
}

// Returns medians over all rounds but the first, which compiles and warms up.
static struct vw_step_times times_of(struct timed *timed) {
    return (struct vw_step_times){vw_median(timed->wall_ms + 1, ROUNDS - 1), vw_median(timed->cpu_ms + 1, ROUNDS - 1)};
}

// Times the base and the configuration without and with scoring, in turn, on one device while others rest.
static enum vw_status time_configuration(struct vw_sweep_state *state, uint32_t configuration) {
    const struct vw_session *session = &state->session;
    const struct vw_config *base = &state->configurations->configurations[0].config,
                           *ours = &state->configurations->configurations[configuration].config;
    struct vw_effect_verdict effects[VW_EFFECT_COUNT_MAX];
    enum vw_status status = choose_effects(state, configuration, effects);
    struct timing timing = {.trainings = {[BASE].params = params_of(session, base, session->effects, true),
                                          [TRAIN].params = params_of(session, ours, effects, false),
                                          [VALUE].params = params_of(session, ours, effects, true)},
                            .interrupt = &state->params->common.interrupt};
    const struct vw_training_pool pool = {.devices = session->devices,
                                          .device_count = 1,
                                          .together = TIMED,
                                          .begin = begin_timed,
                                          .advance = take_round,
                                          .end = end_timed,
                                          .context = &timing};
    if (!status) status = vw_training_pool_run(&pool, TIMED);
    if (status) return status;
    state->measured[configuration] =
        (struct vw_measured_configuration){.train = times_of(&timing.trainings[TRAIN]),
                                           .value = times_of(&timing.trainings[VALUE]),
                                           .base = times_of(&timing.trainings[BASE]),
                                           .device_bytes = timing.trainings[VALUE].device_bytes};
    return VW_OK;
}

enum vw_status vw_sweep_time_steps(struct vw_sweep_state *state) {
    enum vw_status status = VW_OK;
    vw_log_info("timing   the steps of %u configurations", state->configurations->count);
    for (uint32_t configuration = 0; configuration < state->configurations->count && !status; configuration++) {
        if (find(state, configuration)) continue;
        status = time_configuration(state, configuration);
        if (!status) status = record(state, configuration);
        if (!status)
            vw_log_info("timed    %s: %.3g ms a step, %.3g with scoring (%u of %u)",
                        state->configurations->configurations[configuration].name,
                        state->measured[configuration].train.wall_ms, state->measured[configuration].value.wall_ms,
                        configuration + 1, state->configurations->count);
    }
    return status;
}

uint64_t vw_sweep_steps(const struct vw_sweep_state *state, uint32_t configuration) {
    return (uint64_t)state->configurations->configurations[configuration].config.epochs *
           state->session.scene->split_count[VW_SPLIT_TRAIN];
}

void vw_sweep_step_ms(const struct vw_sweep_state *state, uint32_t configuration, double *train_ms, double *value_ms) {
    double base_ms[VW_CONFIGURATIONS_MAX];
    bool cpu = vw_gpu_get_info(state->session.devices[0].gpu)->kind == VW_GPU_CPU;
    const struct vw_measured_configuration *measured = &state->measured[configuration];
    for (uint32_t i = 0; i < state->configurations->count; i++) base_ms[i] = state->measured[i].base.wall_ms;
    double median_ms = vw_median(base_ms, state->configurations->count);
    double of_base_ms = cpu ? measured->base.cpu_ms : measured->base.wall_ms;
    *train_ms = (cpu ? measured->train.cpu_ms : measured->train.wall_ms) / of_base_ms * median_ms;
    *value_ms = (cpu ? measured->value.cpu_ms : measured->value.wall_ms) / of_base_ms * median_ms;
}

// ---- PSNR ----

char *vw_sweep_folder(const struct vw_sweep_state *state, uint32_t configuration) {
    return vw_format_text("%s/configurations/%s", state->params->common.out,
                          state->configurations->configurations[configuration].name);
}

static enum vw_status measure_field(struct vw_sweep_state *state, const char *path, const struct vw_config *config,
                                    const struct vw_effect_verdict *effects, double *psnr_db) {
    const struct vw_session *session = &state->session;
    struct vw_trainer_params params = params_of(session, config, effects, false);
    params.awaits_field = true;
    uint32_t *views = NULL, count = 0;
    struct vw_view_error *errors = NULL;
    struct vw_trainer *trainer = NULL;
    enum vw_status status = vw_scene_list_views(session->scene, VW_SPLIT_VAL, &views, &count);
    if (!status) errors = vw_allocate(count, sizeof *errors);
    if (!status && !errors) status = VW_ERROR_MEMORY;
    if (!status) status = vw_trainer_create(&params, &trainer);
    if (!status) status = vw_trainer_load_field(trainer, path);
    if (!status) status = vw_trainer_measure_views(trainer, views, count, PIXELS_OF_VIEW_MAX, errors);
    double weights = 0;
    *psnr_db = 0;
    for (uint32_t i = 0; i < count; i++) weights += session->scene->views[views[i]].weight;
    for (uint32_t i = 0; i < count && !status; i++)
        *psnr_db += session->scene->views[views[i]].weight * vw_psnr_db(errors[i].mse) / weights;
    vw_trainer_destroy(&trainer);
    free(errors);
    free(views);
    return status;
}

static enum vw_status measure_seed(struct vw_sweep_state *state, uint32_t configuration, uint32_t seed,
                                   double *psnr_db) {
    struct vw_effect_verdict effects[VW_EFFECT_COUNT_MAX];
    struct vw_config config = state->configurations->configurations[configuration].config;
    config.seed += seed;
    char *folder = vw_sweep_folder(state, configuration);
    char *path = folder ? vw_seed_run_path(folder, config.seed, "field.vwf") : NULL;
    enum vw_status status = path ? choose_effects(state, configuration, effects) : VW_ERROR_MEMORY;
    if (!status) status = measure_field(state, path, &config, effects, psnr_db);
    free(path);
    free(folder);
    return status;
}

bool vw_sweep_find_psnr(struct vw_sweep_state *state, uint32_t configuration) {
    return vw_sweep_store_find(&state->store, state->configuration_ids[configuration], "val_psnr",
                               &state->measured[configuration].val_psnr);
}

// Returns whether the base's pixels are measured; without masks, or where appearance fits left halves, others are.
static enum vw_status sees_base_pixels(const struct vw_sweep_state *state, uint32_t configuration, bool *same) {
    const struct vw_session *session = &state->session;
    struct vw_effect_verdict ours[VW_EFFECT_COUNT_MAX];
    enum vw_status status = choose_effects(state, configuration, ours);
    *same = vw_effects_fit_views(ours, session->effect_count) ==
                vw_effects_fit_views(session->effects, session->effect_count) &&
            vw_effects_is_on(ours, session->effect_count, "masks") ==
                vw_effects_is_on(session->effects, session->effect_count, "masks");
    return status;
}

enum vw_status vw_sweep_measure_psnr(struct vw_sweep_state *state, uint32_t configuration) {
    double sum_db = 0;
    bool same = true;
    enum vw_status status = sees_base_pixels(state, configuration, &same);
    for (uint32_t seed = 0; seed < state->params->common.seeds && !status && same; seed++) {
        double psnr_db = NAN;
        status = measure_seed(state, configuration, seed, &psnr_db);
        sum_db += psnr_db;
    }
    double psnr_db = same ? sum_db / state->params->common.seeds : NAN;
    if (status) return status;
    state->measured[configuration].val_psnr = psnr_db;
    vw_sweep_store_set(&state->store, state->configuration_ids[configuration], "val_psnr", psnr_db);
    return vw_sweep_store_save(&state->store);
}
