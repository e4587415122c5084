#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/statistics.h"
#include "experiment/experiment.h"
#include "experiment/sweep/state.h"
#include "experiment/sweep/sweep.h"
#include "run/scoring.h"
#include "value/evaluation/agreement.h"
#include "value/evaluation/score_tables.h"

enum { SEEDS_MAX = 50 };

#define SHOWN(column_kind, member, heading, digits_shown)                                                              \
    { VW_CELL(#member, struct vw_sweep_metrics, column_kind, member), .title = heading, .digits = digits_shown }
static const struct vw_column columns[] = {
    SHOWN(TEXT, configuration, "configuration", 0),
    VW_COLUMN(struct vw_sweep_metrics, TEXT, parameter),
    VW_COLUMN(struct vw_sweep_metrics, TEXT, value),
    VW_COLUMN(struct vw_sweep_metrics, COUNT, base),
    VW_COLUMN(struct vw_sweep_metrics, COUNT, epochs),
    VW_COLUMN(struct vw_sweep_metrics, COUNT, steps),
    SHOWN(REAL_OR_NULL, train_ms, "step, ms", 2),
    VW_COLUMN(struct vw_sweep_metrics, REAL_OR_NULL, value_ms),
    SHOWN(REAL_OR_NULL, scoring_ratio, "ratio", 2),
    SHOWN(REAL_OR_NULL, run_seconds, "run, s", 1),
    SHOWN(REAL_OR_NULL, device_mib, "MiB", 1),
    SHOWN(REAL_OR_NULL, val_psnr, "PSNR, dB", 2),
    SHOWN(COUNT, psnr_pareto_front, "front by PSNR", 0),
    VW_COLUMN(struct vw_sweep_metrics, TEXT, method),
    SHOWN(COUNT, score_pareto_front, "front by scores", 0),
    SHOWN(REAL_OR_NULL, seed_pearson, "r seeds", 3),
    SHOWN(REAL_OR_NULL, seed_spearman, "rho", 3),
    SHOWN(REAL_OR_NULL, agreement_pearson, "r reference", 3),
    SHOWN(REAL_OR_NULL, agreement_spearman, "rho", 3),
    SHOWN(REAL_OR_NULL, all_pixels_pearson, "r all pixels", 3),
    VW_COLUMN(struct vw_sweep_metrics, REAL_OR_NULL, all_pixels_spearman),
};

struct vw_rows vw_sweep_rows(const struct vw_sweep_metrics *metrics, uint32_t count) {
    return VW_ROWS(columns, metrics, count);
}

// ---- From ledgers to score tables ----

// Reads the scores of a configuration's runs, method by method: values[seed * photo_count + photo].
static enum vw_status read_tables(const struct vw_sweep_state *state, uint32_t configuration,
                                  struct vw_score_tables *tables) {
    const struct vw_config *config = &state->configurations->configurations[configuration].config;
    struct vw_ledger *ledgers[SEEDS_MAX] = {0};
    struct vw_value_input runs[SEEDS_MAX] = {0};
    uint32_t count = state->params->common.seeds;
    char *folder = vw_sweep_folder(state, configuration);
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

// Correlates the same method's scores with the same seed at two configurations, as means over the seeds. NaN where one
// configuration lacks the method.
static enum vw_status compare_configurations(const struct vw_score_tables *ours, const struct vw_score_table *table,
                                             const struct vw_score_tables *theirs, double *pearson, double *spearman) {
    struct vw_agreement_summary of_pearson = VW_AGREEMENT_NONE, of_spearman = VW_AGREEMENT_NONE;
    uint32_t photos = ours->photo_count;
    const struct vw_score_table *other = theirs ? vw_score_tables_find(theirs, table->method) : NULL;
    enum vw_status status = VW_OK;
    *pearson = *spearman = NAN;
    if (!other || theirs->photo_count != photos) return VW_OK;
    for (uint32_t i = 0; i < ours->run_count && !status; i++) {
        struct vw_agreement pair = {.pearson = NAN, .spearman = NAN};
        status = vw_agreement_of_pair(table->values + (size_t)i * photos, other->values + (size_t)i * photos, NULL,
                                      photos, &pair);
        vw_agreement_add(pair.pearson, &of_pearson);
        vw_agreement_add(pair.spearman, &of_spearman);
    }
    *pearson = of_pearson.mean;
    *spearman = of_spearman.mean;
    return status;
}

static enum vw_status compare_seeds(const struct vw_score_tables *tables, const struct vw_score_table *table,
                                    struct vw_sweep_metrics *metric) {
    struct vw_agreement_summary pearson, spearman;
    enum vw_status status =
        vw_agreement_of_runs(table->values, tables->run_count, tables->photo_count, &pearson, &spearman);
    metric->seed_pearson = pearson.mean;
    metric->seed_spearman = spearman.mean;
    return status;
}

// ---- Metrics ----

static struct vw_sweep_metrics begin_metric(const struct vw_sweep_state *state, uint32_t configuration) {
    const struct vw_sweep_configuration *of_configuration = &state->configurations->configurations[configuration];
    const struct vw_measured_configuration *measured = &state->measured[configuration];
    double train_ms, value_ms;
    vw_sweep_step_ms(state, configuration, &train_ms, &value_ms);
    uint64_t steps = vw_sweep_steps(state, configuration);
    return (struct vw_sweep_metrics){.configuration = of_configuration->name,
                                     .parameter = of_configuration->parameter,
                                     .value = of_configuration->value,
                                     .base = configuration == 0,
                                     .epochs = of_configuration->config.epochs,
                                     .steps = (uint32_t)steps,
                                     .train_ms = train_ms,
                                     .value_ms = value_ms,
                                     .scoring_ratio = value_ms / train_ms,
                                     .run_seconds = 1e-3 * value_ms * (double)steps,
                                     .device_mib = measured->device_bytes / 0x1p20,
                                     .val_psnr = measured->val_psnr,
                                     .all_pixels_pearson = NAN,
                                     .all_pixels_spearman = NAN};
}

static enum vw_status add_metrics(const struct vw_sweep_state *state, const struct vw_score_tables *all,
                                  uint32_t configuration, size_t *capacity, struct vw_sweep *sweep) {
    const struct vw_score_tables *tables = &all[configuration];
    const struct vw_sweep_configurations *configurations = state->configurations;
    bool same_trainings =
        configuration == 0 || !strcmp(configurations->configurations[configuration].parameter, "val-rays");
    const struct vw_score_tables *all_pixels =
        same_trainings && configurations->all_pixels != UINT32_MAX ? &all[configurations->all_pixels] : NULL;
    enum vw_status status =
        vw_grow((void **)&sweep->metrics, capacity, sweep->metric_count + tables->count, sizeof *sweep->metrics);
    for (uint32_t i = 0; i < tables->count && !status; i++) {
        const struct vw_score_table *table = &tables->tables[i];
        struct vw_sweep_metrics *metric = &sweep->metrics[sweep->metric_count + i];
        *metric = begin_metric(state, configuration);
        metric->method = table->method;
        status = compare_seeds(tables, table, metric);
        if (!status)
            status = compare_configurations(tables, table, &all[configurations->full_resolution],
                                            &metric->agreement_pearson, &metric->agreement_spearman);
        if (!status)
            status = compare_configurations(tables, table, all_pixels, &metric->all_pixels_pearson,
                                            &metric->all_pixels_spearman);
    }
    if (!status) sweep->metric_count += tables->count;
    return status;
}

// Marks the Pareto fronts among the metrics of one method, which has at most one per configuration. The full_resolution
// configuration is not on the front of agreement: it agrees with itself.
static void mark_fronts(struct vw_sweep *sweep, const char *method) {
    struct vw_sweep_metrics *metrics[VW_CONFIGURATIONS_MAX];
    double seconds[VW_CONFIGURATIONS_MAX] = {0}, psnr_db[VW_CONFIGURATIONS_MAX] = {0},
           agreement[VW_CONFIGURATIONS_MAX] = {0};
    bool psnr_pareto_front[VW_CONFIGURATIONS_MAX], score_pareto_front[VW_CONFIGURATIONS_MAX];
    uint32_t count = 0;
    for (uint32_t i = 0; i < sweep->metric_count; i++) {
        struct vw_sweep_metrics *metric = &sweep->metrics[i];
        if (strcmp(metric->method, method) != 0) continue;
        bool full_resolution = !strcmp(metric->parameter, "full_resolution");
        seconds[count] = metric->run_seconds;
        psnr_db[count] = metric->val_psnr;
        agreement[count] = full_resolution ? NAN : metric->agreement_pearson;
        metrics[count++] = metric;
    }
    vw_pareto_front_mark(seconds, psnr_db, count, psnr_pareto_front);
    vw_pareto_front_mark(seconds, agreement, count, score_pareto_front);
    for (uint32_t i = 0; i < count; i++)
        metrics[i]->psnr_pareto_front = psnr_pareto_front[i], metrics[i]->score_pareto_front = score_pareto_front[i];
}

enum vw_status vw_sweep_make_metrics(struct vw_sweep_state *state, struct vw_sweep *sweep) {
    uint32_t count = state->configurations->count;
    struct vw_score_tables *all = vw_allocate(count, sizeof *all);
    size_t capacity = 0;
    enum vw_status status = all ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < count && !status; i++) status = read_tables(state, i, &all[i]);
    for (uint32_t i = 0; i < count && !status; i++) status = add_metrics(state, all, i, &capacity, sweep);
    for (uint32_t i = 0; i < sweep->metric_count && !status; i++) {
        bool first = true;
        for (uint32_t j = 0; j < i && first; j++)
            first = strcmp(sweep->metrics[j].method, sweep->metrics[i].method) != 0;
        if (first) mark_fronts(sweep, sweep->metrics[i].method);
    }
    const struct vw_sweep_follower *follower = state->params->follower;
    if (!status && follower) status = follower->follow(follower->context, state, all);
    for (uint32_t i = 0; i < count && all; i++) vw_score_tables_free(&all[i]);
    free(all);
    return status;
}
