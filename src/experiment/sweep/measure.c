#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/memory.h"
#include "base/statistics.h"
#include "experiment/experiment.h"
#include "experiment/paired_timing.h"
#include "experiment/sweep/state.h"
#include "experiment/sweep/sweep.h"
#include "train/trainer.h"
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

static enum vw_status find(struct vw_sweep_state *state, uint32_t configuration, bool *found) {
    enum vw_status status = VW_OK;
    *found = true;
    for (size_t i = 0; i < VW_ARRAY_COUNT(quantities) && *found && !status; i++)
        status = vw_sweeps_find(state->store, state->configuration_ids[configuration], quantities[i].name, found,
                                field_of(&state->measured[configuration], &quantities[i]));
    return status;
}

static enum vw_status record(struct vw_sweep_state *state, uint32_t configuration) {
    struct vw_measurement measurements[VW_ARRAY_COUNT(quantities)];
    for (size_t i = 0; i < VW_ARRAY_COUNT(quantities); i++)
        measurements[i] =
            (struct vw_measurement){quantities[i].name, *field_of(&state->measured[configuration], &quantities[i])};
    return vw_sweeps_keep(state->store, state->configuration_ids[configuration], measurements,
                          VW_ARRAY_COUNT(quantities));
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

static struct vw_step_times times_of(const struct vw_timed_trainer *timed) {
    struct vw_step_timing result = vw_timed_trainer_result(timed, ROUNDS);
    return (struct vw_step_times){result.ms_per_step, result.cpu_ms_per_step};
}

// Times the base and the configuration without and with scoring, in pairs, on one device while others rest.
static enum vw_status time_configuration(struct vw_sweep_state *state, uint32_t configuration) {
    enum { BASE, TRAIN, VALUE, TRAINERS };
    const struct vw_session *session = &state->session;
    const struct vw_config *base = &state->configurations->configurations[0].config,
                           *ours = &state->configurations->configurations[configuration].config;
    struct vw_measured_configuration *measured = &state->measured[configuration];
    struct vw_timed_trainer trainers[TRAINERS] = {0};
    struct vw_effect_verdict effects[VW_EFFECT_COUNT_MAX];
    enum vw_status status = choose_effects(state, configuration, effects);
    const struct vw_trainer_params params[] = {params_of(session, base, session->effects, true),
                                               params_of(session, ours, effects, false),
                                               params_of(session, ours, effects, true)};
    for (int i = 0; i < TRAINERS && !status; i++) status = vw_timed_trainer_open(&params[i], ROUNDS, &trainers[i]);
    if (!status) status = vw_paired_timing_run(trainers, TRAINERS, ROUNDS, &state->params->common.interrupt);
    if (!status)
        *measured = (struct vw_measured_configuration){.train = times_of(&trainers[TRAIN]),
                                                       .value = times_of(&trainers[VALUE]),
                                                       .base = times_of(&trainers[BASE]),
                                                       .device_bytes = (double)trainers[VALUE].device_bytes};
    for (int i = 0; i < TRAINERS; i++) vw_timed_trainer_close(&trainers[i]);
    return status;
}

enum vw_status vw_sweep_time_steps(struct vw_sweep_state *state) {
    const struct vw_session *session = &state->session;
    enum vw_status status = VW_OK;
    vw_log_info("timing   the steps of %u configurations%s", state->configurations->count,
                vw_effects_is_on(session->effects, session->effect_count, "occupancy")
                    ? ", before occupancy skips empty space"
                    : "");
    for (uint32_t configuration = 0; configuration < state->configurations->count && !status; configuration++) {
        bool found = false;
        status = find(state, configuration, &found);
        if (!status && !found) status = time_configuration(state, configuration);
        if (!status && !found) status = record(state, configuration);
        if (!status && !found)
            vw_log_info("timed    %s: %.3g ms a step, %.3g with scoring (%u of %u)",
                        state->configurations->configurations[configuration].name,
                        state->measured[configuration].train.wall_ms, state->measured[configuration].value.wall_ms,
                        configuration + 1, state->configurations->count);
    }
    return status;
}

uint64_t vw_sweep_steps(const struct vw_sweep_state *state, uint32_t configuration) {
    return (uint64_t)state->configurations->configurations[configuration].config.epochs * state->retrainer.train_count;
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

enum vw_status vw_sweep_find_psnr(struct vw_sweep_state *state, uint32_t configuration, bool *found) {
    return vw_sweeps_find(state->store, state->configuration_ids[configuration], "val_psnr", found,
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
    const struct vw_measurement measurement = {"val_psnr", same ? sum_db / state->params->common.seeds : NAN};
    state->measured[configuration].val_psnr = measurement.value;
    return status ? status : vw_sweeps_keep(state->store, state->configuration_ids[configuration], &measurement, 1);
}
