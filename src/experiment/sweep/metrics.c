#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/statistics.h"
#include "experiment/experiment.h"
#include "experiment/sweep/sweep.h"
#include "run/scoring.h"
#include "value/evaluation/score_tables.h"

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

enum vw_status vw_sweep_make_metrics(struct vw_sweep *sweep) {
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
