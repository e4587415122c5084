#include "experiment/sweep/sweep.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/inside.h"
#include "base/memory.h"
#include "base/statistics.h"
#include "base/text.h"
#include "experiment/experiment.h"
#include "experiment/measured_views.h"
#include "run/out_folder.h"
#include "run/outputs/report_folder.h"
#include "run/plan/plan.h"
#include "run/scoring.h"
#include "value/evaluation/score_tables.h"
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

// Switches the decisions of the base on and off as the configuration says.
static enum vw_status choose_effects(const struct vw_sweep *sweep, uint32_t configuration,
                                     struct vw_effect_decision effects[VW_EFFECT_COUNT_MAX]) {
    const struct vw_session *session = &sweep->session;
    memcpy(effects, session->effects, sizeof session->effects);
    return vw_effects_choose(sweep->configurations->configurations[configuration].config.effects, effects,
                             session->effect_count);
}

static struct vw_trainer_params params_of(const struct vw_session *session, const struct vw_config *config,
                                          const struct vw_effect_decision *effects) {
    return (struct vw_trainer_params){.gpu = session->devices[0].gpu,
                                      .scene = session->scene,
                                      .config = config,
                                      .effects = effects,
                                      .effect_count = session->effect_count,
                                      .steps_per_submission = STEPS_PER_SUBMISSION};
}

static enum vw_status time_configuration(struct vw_sweep *sweep, uint32_t configuration) {
    struct vw_effect_decision effects[VW_EFFECT_COUNT_MAX] = {0};
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
static bool sees_base_pixels(const struct vw_session *session, const struct vw_effect_decision *ours) {
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
    struct vw_effect_decision effects[VW_EFFECT_COUNT_MAX] = {0};
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

// ---- Columns ----

enum { SEEDS_MAX = 50 };

#define SHOWN(column_kind, member, heading, digits_shown)                                                              \
    { VW_CELL(#member, struct vw_sweep_metrics, column_kind, member), .title = heading, .digits = digits_shown }
static const struct vw_column columns[] = {
    SHOWN(TEXT, configuration, "configuration", 0),    VW_COLUMN(struct vw_sweep_metrics, TEXT, parameter),
    VW_COLUMN(struct vw_sweep_metrics, TEXT, value),   VW_COLUMN(struct vw_sweep_metrics, COUNT, base),
    VW_COLUMN(struct vw_sweep_metrics, COUNT, epochs), VW_COLUMN(struct vw_sweep_metrics, COUNT, steps),
    SHOWN(REAL_OR_NULL, train_ms, "step, ms", 2),      VW_COLUMN(struct vw_sweep_metrics, REAL_OR_NULL, value_ms),
    SHOWN(REAL_OR_NULL, scoring_ratio, "ratio", 2),    SHOWN(REAL_OR_NULL, run_seconds, "run, s", 1),
    SHOWN(REAL_OR_NULL, device_mib, "MiB", 1),         SHOWN(REAL_OR_NULL, val_psnr, "PSNR, dB", 2),
    SHOWN(COUNT, psnr_pareto_front, "front", 0),       VW_COLUMN(struct vw_sweep_metrics, TEXT, method),
    SHOWN(REAL_OR_NULL, seed_pearson, "r seeds", 3),   SHOWN(REAL_OR_NULL, agreement_pearson, "r reference", 3),
};

struct vw_rows vw_sweep_rows(const struct vw_sweep_metrics *metrics, uint32_t count) {
    return VW_ROWS(columns, metrics, count);
}

// ---- From ledgers to score tables ----

// Reads the scores of a configuration's runs, method by method: values[seed * photo_count + photo].
static enum vw_status read_tables(const struct vw_sweep *sweep, uint32_t configuration,
                                  struct vw_score_tables *tables) {
    const struct vw_sweep_configuration *made = &sweep->configurations->configurations[configuration];
    const struct vw_config *config = &made->config;
    struct vw_ledger *ledgers[SEEDS_MAX] = {0};
    struct vw_value_input runs[SEEDS_MAX] = {0};
    uint32_t count = sweep->params->common.seeds;
    char *folder = vw_sweep_folder(sweep->params->common.out, made);
    enum vw_status status = folder ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < count && !status; i++) {
        status = vw_seed_run_open(folder, config->seed + i, &ledgers[i]);
        if (!status) status = vw_scoring_load(ledgers[i], config, &runs[i]);
    }
    if (!status) status = vw_score_tables_make(runs, count, config->epochs, tables); // a run may have more
    for (uint32_t i = 0; i < count; i++) {
        vw_scoring_unload(&runs[i]);
        vw_ledger_close(&ledgers[i]);
    }
    free(folder);
    return status;
}

// ---- Correlations ----

// Returns the mean of Pearson's correlation over the pairs for which it is defined, and NaN where there is none.
static double mean_of(double sum, uint32_t pairs) { return pairs ? sum / pairs : NAN; }

static enum vw_status add_pair(const double *a, const double *b, uint32_t photos, double *sum, uint32_t *pairs) {
    double *kept = vw_allocate(photos, 2 * sizeof *kept);
    uint32_t count = 0;
    if (!kept) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < photos; i++) {
        if (!isfinite(a[i]) || !isfinite(b[i])) continue;
        kept[count] = a[i];
        kept[photos + count++] = b[i];
    }
    double pearson = vw_pearson(kept, kept + photos, count);
    free(kept);
    if (isfinite(pearson)) *sum += pearson, ++*pairs;
    return VW_OK;
}

// Correlates the same method's scores with the same seed here and in the full resolution.
static enum vw_status compare_with_full(const struct vw_score_tables *ours, const struct vw_score_table *table,
                                        const struct vw_score_tables *full, double *pearson) {
    uint32_t photos = ours->photo_count, pairs = 0;
    const struct vw_score_table *other = vw_score_tables_find(full, table->method);
    double sum = 0;
    enum vw_status status = VW_OK;
    bool comparable = other && full->photo_count == photos;
    for (uint32_t i = 0; i < ours->run_count && comparable && !status; i++)
        status = add_pair(table->values + (size_t)i * photos, other->values + (size_t)i * photos, photos, &sum, &pairs);
    *pearson = mean_of(sum, pairs);
    return status;
}

static enum vw_status compare_seeds(const struct vw_score_tables *tables, const struct vw_score_table *table,
                                    double *pearson) {
    uint32_t photos = tables->photo_count, pairs = 0;
    double sum = 0;
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < tables->run_count; i++)
        for (uint32_t j = i + 1; j < tables->run_count && !status; j++)
            status =
                add_pair(table->values + (size_t)i * photos, table->values + (size_t)j * photos, photos, &sum, &pairs);
    *pearson = mean_of(sum, pairs);
    return status;
}

// ---- Metrics ----

static struct vw_sweep_metrics begin_metric(const struct vw_sweep *sweep, uint32_t configuration) {
    const struct vw_sweep_configuration *of_configuration = &sweep->configurations->configurations[configuration];
    const struct vw_sweep_measures *measured = &sweep->measured[configuration];
    return (struct vw_sweep_metrics){.configuration = of_configuration->name,
                                     .parameter = of_configuration->parameter,
                                     .value = of_configuration->value,
                                     .base = configuration == 0,
                                     .epochs = of_configuration->config.epochs,
                                     .steps = (uint32_t)measured->steps,
                                     .train_ms = 1e3 * measured->train_s,
                                     .value_ms = 1e3 * measured->value_s,
                                     .scoring_ratio = measured->value_s / measured->train_s,
                                     .run_seconds = measured->value_s * (double)measured->steps,
                                     .device_mib = measured->device_bytes / 0x1p20,
                                     .val_psnr = measured->val_psnr};
}

// Marks the configurations on the Pareto front of time and PSNR.
static void find_front(const struct vw_sweep *sweep, bool on_front[VW_CONFIGURATIONS_MAX]) {
    double seconds[VW_CONFIGURATIONS_MAX] = {0}, psnr_db[VW_CONFIGURATIONS_MAX] = {0};
    for (uint32_t i = 0; i < sweep->configurations->count; i++) {
        seconds[i] = sweep->measured[i].value_s * (double)sweep->measured[i].steps;
        psnr_db[i] = sweep->measured[i].val_psnr;
    }
    vw_pareto_front_mark(seconds, psnr_db, sweep->configurations->count, on_front);
}

static enum vw_status add_metrics(const struct vw_score_tables *all, uint32_t configuration, bool on_front,
                                  size_t *capacity, struct vw_sweep *sweep) {
    const struct vw_score_tables *tables = &all[configuration], *full = &all[sweep->configurations->full_resolution];
    enum vw_status status =
        vw_grow((void **)&sweep->metrics, capacity, sweep->metric_count + tables->count, sizeof *sweep->metrics);
    for (uint32_t i = 0; i < tables->count && !status; i++) {
        struct vw_sweep_metrics *metric = &sweep->metrics[sweep->metric_count++];
        *metric = begin_metric(sweep, configuration);
        metric->psnr_pareto_front = on_front;
        metric->method = tables->tables[i].method;
        status = compare_seeds(tables, &tables->tables[i], &metric->seed_pearson);
        if (!status) status = compare_with_full(tables, &tables->tables[i], full, &metric->agreement_pearson);
    }
    return status;
}

static enum vw_status make_metrics(struct vw_sweep *sweep) {
    uint32_t count = sweep->configurations->count;
    struct vw_score_tables *all = vw_allocate(count, sizeof *all);
    bool on_front[VW_CONFIGURATIONS_MAX];
    size_t capacity = 0;
    enum vw_status status = all ? VW_OK : VW_ERROR_MEMORY;
    find_front(sweep, on_front);
    for (uint32_t i = 0; i < count && !status; i++) status = read_tables(sweep, i, &all[i]);
    for (uint32_t i = 0; i < count && !status; i++) status = add_metrics(all, i, on_front[i], &capacity, sweep);
    const struct vw_sweep_follower *follower = sweep->params->follower;
    if (!status && follower) status = follower->follow(follower->context, sweep, all);
    for (uint32_t i = 0; i < count && all; i++) vw_score_tables_free(&all[i]);
    free(all);
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
    if (!status) status = make_metrics(sweep);
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
