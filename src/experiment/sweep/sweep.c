#include "experiment/sweep/sweep.h"

#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/hash.h"
#include "base/inside.h"
#include "base/memory.h"
#include "base/text.h"
#include "experiment/experiment.h"
#include "experiment/sweep/state.h"
#include "run/outputs/report_folder.h"
#include "train/trainer.h"
#include "viewworth/log.h"

// ---- Opening ----

// Hashes all that a configuration's measurements depend on: the base's run, which covers scene, device and shaders, and
// the configuration's own config and length.
static enum vw_status name_configuration(struct vw_sweep_state *state, uint32_t place) {
    const struct vw_sweep_configuration *configuration = &state->configurations->configurations[place];
    struct vw_hasher hasher;
    uint8_t hash[VW_HASH_BYTES];
    char *config = vw_config_to_json(&configuration->config, false);
    if (!config) return VW_ERROR_MEMORY;
    vw_hasher_begin(&hasher);
    vw_hasher_add_text(&hasher, "viewworth configuration 1");
    vw_hasher_add_text(&hasher, state->base_id);
    vw_hasher_add_text(&hasher, config);
    vw_hasher_add_integer(&hasher, configuration->downscale);
    vw_hasher_add_integer(&hasher, state->params->common.seeds);
    vw_hasher_end(&hasher, hash);
    vw_hash_to_hex(hash, state->configuration_ids[place]);
    free(config);
    return VW_OK;
}

// Names the base's training: its run_id covers scene, device, driver and shaders.
static enum vw_status name_base(struct vw_sweep_state *state) {
    const struct vw_session *session = &state->session;
    const struct vw_trainer_params params = {.gpu = session->devices[0].gpu,
                                             .scene = session->scene,
                                             .config = state->params->common.config,
                                             .effects = session->effects,
                                             .effect_count = session->effect_count,
                                             .validate = true};
    struct vw_trainer *trainer = NULL;
    uint8_t run_id[VW_HASH_BYTES];
    enum vw_status status = vw_trainer_create(&params, &trainer);
    if (!status) status = vw_trainer_run_id(trainer, run_id);
    if (!status) vw_hash_to_hex(run_id, state->base_id);
    vw_trainer_destroy(&trainer);
    return status;
}

static enum vw_status open_sweep(struct vw_sweep_state *state) {
    const struct vw_experiment_params *common = &state->params->common;
    uint32_t downscale = common->scene.downscale ? common->scene.downscale : 1;
    enum vw_status status = vw_experiment_open_session(common, &state->session);
    if (!status && !state->session.scene->split_count[VW_SPLIT_VAL])
        status = vw_fail(VW_ERROR_INPUT, "%s: has no validation photos; name some by --val", common->scene.path);
    if (!status) status = vw_session_decide_effects(common->config, &state->session);
    if (!status) status = name_base(state);
    if (!status) status = vw_sweep_store_open(common->out, &state->store);
    if (!status)
        status = vw_sweep_configurations_list(common->config, downscale, state->params->parameters, &state->session,
                                              state->configurations);
    for (uint32_t i = 0; i < state->configurations->count && !status; i++) status = name_configuration(state, i);
    return status;
}

// ---- Runs ----

// Estimates from the time of steps; setting up and measuring are left out.
static void log_duration(const struct vw_sweep_state *state) {
    uint32_t count = state->configurations->count, seeds = state->params->common.seeds;
    double seconds = 0, train_ms, value_ms;
    char about[VW_DURATION_BYTES];
    for (uint32_t i = 0; i < count; i++) {
        vw_sweep_step_ms(state, i, &train_ms, &value_ms);
        seconds += 1e-3 * value_ms * (double)vw_sweep_steps(state, i) * seeds;
    }
    vw_text_duration(seconds, about);
    vw_log_info("tradeoff %u configurations with %u seeds each: about %s in all, less what is done already; Ctrl-C "
                "keeps what is done",
                count, seeds, about);
}

// Returns whether a configuration's folder has the ledgers of all seeds.
static bool has_runs(const struct vw_experiment_params *common, const char *folder) {
    bool there = true;
    for (uint32_t i = 0; i < common->seeds && there; i++) {
        char *path = vw_seed_run_path(folder, common->config->seed + i, "ledger.db");
        there = path && vw_file_exists(path);
        free(path);
    }
    return there;
}

static enum vw_status make_runs(const struct vw_sweep_state *state, uint32_t place, const char *folder) {
    const struct vw_sweep_configuration *configuration = &state->configurations->configurations[place];
    struct vw_experiment_params runs = state->params->common;
    struct vw_session session = {0}; // its own: downscale and effects may differ
    runs.out = folder;
    runs.config = &configuration->config;
    runs.scene.downscale = configuration->downscale;
    vw_log_info("configuration    %s (%u of %u)", configuration->name, place + 1, state->configurations->count);
    enum vw_status status = vw_seed_runs_make(&runs, &session);
    vw_session_close(&session);
    return status;
}

// Makes a configuration's runs, which are finished if its PSNR is recorded.
static enum vw_status make_configuration(struct vw_sweep_state *state, uint32_t place, const char *folder) {
    const char *out = state->params->common.out;
    bool known = vw_sweep_find_psnr(state, place);
    enum vw_status status = vw_folder_check_inside(out, folder + strlen(out) + 1); // the part below OUT
    if (status || (known && has_runs(&state->params->common, folder))) return status;
    status = make_runs(state, place, folder);
    return status || known ? status : vw_sweep_measure_psnr(state, place);
}

static enum vw_status make_configurations(struct vw_sweep_state *state) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < state->configurations->count && !status; i++) {
        char *folder = vw_sweep_folder(state, i);
        status = folder ? make_configuration(state, i, folder) : VW_ERROR_MEMORY;
        free(folder);
    }
    return status;
}

// ---- Results ----

static enum vw_status write_results(struct vw_sweep_state *state, struct vw_sweep *sweep) {
    const char *out = state->params->common.out;
    const struct vw_report_params report = {.scene = state->session.scene, .options.no_thumbnails = true};
    sweep->csv_path = vw_path_join(out, "tradeoff.csv");
    if (!sweep->csv_path) return VW_ERROR_MEMORY;
    const struct vw_rows rows = vw_sweep_rows(sweep->metrics, sweep->metric_count);
    enum vw_status status = vw_rows_write_csv(sweep->csv_path, &rows);
    if (!status) sweep->report_path = vw_report_folder_finish(out, &report, "tradeoff.csv", vw_rows_to_texts(&rows));
    return status;
}

// ---- All of it ----

static enum vw_status make(struct vw_sweep_state *state, struct vw_sweep *sweep) {
    const struct vw_experiment_params *common = &state->params->common;
    enum vw_status status = vw_experiment_check(common, common->seeds, true);
    if (!status) status = vw_out_lock_take(common->out, &state->lock);
    if (!status) status = open_sweep(state);
    if (!status) status = vw_sweep_time_steps(state);
    if (status) return status;
    log_duration(state);
    status = make_configurations(state);
    if (!status) status = vw_sweep_make_metrics(state, sweep);
    return status ? status : write_results(state, sweep);
}

enum vw_status vw_sweep_make(const struct vw_sweep_params *params, struct vw_sweep *sweep) {
    *sweep = (struct vw_sweep){.params = params, .configurations = vw_allocate(1, sizeof *sweep->configurations)};
    struct vw_sweep_state *state = vw_allocate(1, sizeof *state);
    if (!sweep->configurations || !state) {
        free(state);
        return VW_ERROR_MEMORY;
    }
    state->params = params;
    state->configurations = sweep->configurations;
    enum vw_status status = make(state, sweep);
    vw_sweep_store_close(&state->store);
    vw_session_close(&state->session);
    vw_out_lock_release(&state->lock);
    free(state);
    return status;
}

void vw_sweep_free(struct vw_sweep *sweep) {
    free(sweep->configurations);
    free(sweep->metrics);
    free(sweep->csv_path);
    free(sweep->report_path);
}
