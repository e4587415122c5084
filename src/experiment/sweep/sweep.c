#include "experiment/sweep/sweep.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/inside.h"
#include "base/memory.h"
#include "base/text.h"
#include "experiment/measured_views.h"
#include "run/out_lock.h"
#include "run/outputs/report_folder.h"
#include "run/plan/estimate.h"
#include "viewworth/log.h"

enum { STEPS_PER_SUBMISSION = 2, TIMED_EPOCHS = 10000 }; // more epochs than are timed: those of a run may be few

static enum vw_status open_sweep(struct vw_sweep *sweep) {
    const struct vw_experiment_params *common = &sweep->params->common;
    enum vw_status status = vw_experiment_open_session(common, &sweep->session);
    if (!status && !sweep->session.scene->split_count[VW_SPLIT_VAL])
        status = vw_fail(VW_ERROR_INPUT, "%s: has no validation photos; name some by --val", common->scene.path);
    if (!status) status = vw_session_decide_effects(common->config, &sweep->session);
    if (!status)
        status = vw_sweep_configurations_list(common->config, common->scene.downscale, sweep->params->parameters,
                                              &sweep->session, sweep->configurations);
    return status;
}

// ---- Time ----

// Switches the verdicts of the base on and off as the configuration says.
static enum vw_status choose_effects(const struct vw_sweep *sweep, uint32_t configuration,
                                     struct vw_effect_verdict effects[VW_EFFECT_COUNT_MAX]) {
    const struct vw_session *session = &sweep->session;
    memcpy(effects, session->effects, sizeof session->effects);
    return vw_effects_choose(sweep->configurations->configurations[configuration].config.effects, effects,
                             session->effect_count);
}

static struct vw_trainer_params params_of(const struct vw_session *session, const struct vw_config *config,
                                          const struct vw_effect_verdict *effects) {
    return (struct vw_trainer_params){.gpu = session->devices[0].gpu,
                                      .scene = session->scene,
                                      .config = config,
                                      .effects = effects,
                                      .effect_count = session->effect_count,
                                      .steps_per_submission = STEPS_PER_SUBMISSION};
}

static enum vw_status time_configuration(struct vw_sweep *sweep, uint32_t configuration) {
    struct vw_effect_verdict effects[VW_EFFECT_COUNT_MAX] = {0};
    const struct vw_config *configured = &sweep->configurations->configurations[configuration].config;
    struct vw_config config = *configured;
    struct vw_estimate train = {0}, value = {0};
    config.epochs = TIMED_EPOCHS;
    struct vw_trainer_params params = params_of(&sweep->session, &config, effects);
    enum vw_status status = choose_effects(sweep, configuration, effects);
    if (!status) status = vw_estimate_take_steps(&params, &train);
    params.validate = true;
    if (!status) status = vw_estimate_take_steps(&params, &value);
    sweep->measured[configuration] = (struct vw_sweep_measures){
        .steps = (uint64_t)configured->epochs * sweep->session.scene->split_count[VW_SPLIT_TRAIN],
        .train_s = train.seconds_per_step,
        .value_s = value.seconds_per_step,
        .device_bytes = (double)value.device_bytes};
    return status;
}

// Times the steps of all configurations, and logs what the runs take; setting up and measuring are left out.
static enum vw_status time_steps(struct vw_sweep *sweep) {
    uint32_t count = sweep->configurations->count, seeds = sweep->params->common.seeds;
    double seconds = 0;
    char about[VW_DURATION_BYTES];
    vw_log_info("timing   the steps of %u configurations", count);
    for (uint32_t i = 0; i < count; i++) {
        enum vw_status status = time_configuration(sweep, i);
        if (!status && vw_interrupt_requested(&sweep->params->common.interrupt))
            status = vw_fail(VW_ERROR_INTERRUPTED, "interrupted while timing steps; start again");
        if (status) return status;
        seconds += sweep->measured[i].value_s * (double)sweep->measured[i].steps * seeds;
    }
    vw_text_duration(seconds, about);
    vw_log_info("tradeoff %u configurations with %u seeds each: about %s in all, less what is done already; Ctrl-C "
                "keeps what is done",
                count, seeds, about);
    return VW_OK;
}

// ---- PSNR ----

// Returns whether the base's pixels are measured; without masks, or where appearance fits left halves, others are.
static bool sees_base_pixels(const struct vw_session *session, const struct vw_effect_verdict *ours) {
    uint32_t count = session->effect_count;
    return vw_effects_fit_views(ours, count) == vw_effects_fit_views(session->effects, count) &&
           vw_effects_is_on(ours, count, "masks") == vw_effects_is_on(session->effects, count, "masks");
}

static enum vw_status measure_field(const struct vw_trainer_params *params, const char *path, double *psnr_db) {
    struct vw_trainer *trainer = NULL;
    struct vw_measured_views views = {0};
    struct vw_retrain_result result = {0};
    enum vw_status status = vw_trainer_create(params, &trainer);
    if (!status) status = vw_trainer_load_field(trainer, path);
    if (!status)
        status =
            vw_measured_views_make(trainer, params->scene, &(struct vw_retrain_params){0}, NULL, NULL, &views, &result);
    vw_measured_views_free(&views);
    vw_trainer_destroy(&trainer);
    *psnr_db = result.val_psnr;
    return status;
}

// Measures the fields of a configuration's runs on the photos of the base.
static enum vw_status measure_psnr(struct vw_sweep *sweep, uint32_t configuration, const char *folder) {
    struct vw_effect_verdict effects[VW_EFFECT_COUNT_MAX] = {0};
    struct vw_config config = sweep->configurations->configurations[configuration].config;
    struct vw_trainer_params params = params_of(&sweep->session, &config, effects);
    uint32_t seeds = sweep->params->common.seeds;
    double sum_db = 0, psnr_db;
    params.awaits_field = true;
    enum vw_status status = choose_effects(sweep, configuration, effects);
    bool same = !status && sees_base_pixels(&sweep->session, effects);
    for (uint32_t i = 0; i < seeds && same && !status; i++, config.seed++) {
        char *path = vw_seed_run_path(folder, config.seed, "field.vwf");
        status = path ? measure_field(&params, path, &psnr_db) : VW_ERROR_MEMORY;
        if (!status) sum_db += psnr_db;
        free(path);
    }
    sweep->measured[configuration].val_psnr = same ? sum_db / seeds : NAN;
    return status;
}

// ---- Runs ----

static enum vw_status make_configuration(struct vw_sweep *sweep, uint32_t place, const char *folder) {
    const struct vw_sweep_configuration *configuration = &sweep->configurations->configurations[place];
    struct vw_experiment_params runs = sweep->params->common;
    struct vw_session session = {0}; // its own: effects may differ
    enum vw_status status = vw_folder_check_inside(runs.out, folder + strlen(runs.out) + 1); // the part below OUT
    if (status) return status;
    runs.out = folder;
    runs.config = &configuration->config;
    vw_log_info("configuration    %s (%u of %u)", configuration->name, place + 1, sweep->configurations->count);
    status = vw_seed_runs_make(&runs, &session);
    vw_session_close(&session);
    return status ? status : measure_psnr(sweep, place, folder);
}

static enum vw_status make_configurations(struct vw_sweep *sweep) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < sweep->configurations->count && !status; i++) {
        char *folder = vw_sweep_folder(sweep->params->common.out, &sweep->configurations->configurations[i]);
        status = folder ? make_configuration(sweep, i, folder) : VW_ERROR_MEMORY;
        free(folder);
    }
    return status;
}

// ---- Results ----

static enum vw_status write_results(struct vw_sweep *sweep) {
    const char *out = sweep->params->common.out;
    const struct vw_report_params report = {.scene = sweep->session.scene, .options.no_thumbnails = true};
    sweep->csv_path = vw_path_join(out, "tradeoff.csv");
    if (!sweep->csv_path) return VW_ERROR_MEMORY;
    const struct vw_rows rows = vw_sweep_rows(sweep->metrics, sweep->metric_count);
    enum vw_status status = vw_rows_write_csv(sweep->csv_path, &rows);
    if (!status) sweep->report_path = vw_report_folder_finish(out, &report, "tradeoff.csv", vw_rows_to_texts(&rows));
    return status;
}

static enum vw_status make(struct vw_sweep *sweep, struct vw_out_lock **lock) {
    const struct vw_experiment_params *common = &sweep->params->common;
    enum vw_status status = vw_experiment_check(common, common->seeds, true);
    if (!status) status = vw_out_lock_take(common->out, lock);
    if (!status) status = open_sweep(sweep);
    if (!status) status = time_steps(sweep);
    if (!status) status = make_configurations(sweep);
    if (!status) status = vw_sweep_make_metrics(sweep);
    return status ? status : write_results(sweep);
}

enum vw_status vw_sweep_make(const struct vw_sweep_params *params, struct vw_sweep *sweep) {
    struct vw_out_lock *lock = NULL;
    *sweep = (struct vw_sweep){.params = params, .configurations = vw_allocate(1, sizeof *sweep->configurations)};
    enum vw_status status = sweep->configurations ? make(sweep, &lock) : VW_ERROR_MEMORY;
    vw_session_close(&sweep->session);
    vw_out_lock_release(&lock);
    return status;
}

void vw_sweep_free(struct vw_sweep *sweep) {
    free(sweep->configurations);
    free(sweep->metrics);
    free(sweep->csv_path);
    free(sweep->report_path);
}
