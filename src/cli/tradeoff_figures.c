#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/scoring.h"
#include "cli/seed_runs.h"
#include "cli/tradeoff.h"
#include "value/agreement.h"
#include "value/contest.h"
#include "value/front.h"
#include "value/score_tables.h"
#include "viewworth/memory.h"

enum { SEEDS_MAX = 50 };

// ---- From ledgers to score tables ---------------------------------------------------------------------------------------

// The scores of a point's runs, method by method: values[seed * photo_count + photo].
static enum vw_status read_tables(const struct vw_tradeoff *tradeoff, uint32_t point, struct vw_score_tables *tables) {
    const struct vw_config *config = &tradeoff->points.points[point].config;
    struct vw_ledger *ledgers[SEEDS_MAX] = {0};
    struct vw_value_input runs[SEEDS_MAX] = {0};
    uint32_t count = tradeoff->options->seeds;
    char *folder = vw_tradeoff_folder(tradeoff, point);
    enum vw_status status = folder ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < count && !status; i++) {
        status = vw_seed_run_open(folder, config->seed + i, &ledgers[i]);
        if (!status) status = vw_scoring_load(ledgers[i], config, &runs[i]);
    }
    if (!status) status = vw_score_tables_make(runs, count, config->epochs, tables); // a run may hold more
    for (uint32_t i = 0; i < count; i++) {
        vw_scoring_unload(&runs[i]);
        vw_ledger_close(&ledgers[i]);
    }
    free(folder);
    return status;
}

// ---- Correlations -------------------------------------------------------------------------------------------------------

// Of the same method's scores with the same seeds at two points: means over the seeds. NaN where one point lacks the method.
static enum vw_status compare_points(const struct vw_score_tables *ours, const struct vw_score_table *table,
                                     const struct vw_score_tables *theirs, double *pearson, double *spearman) {
    struct vw_agreement pairs[SEEDS_MAX];
    uint32_t photos = ours->photo_count;
    const struct vw_score_table *other = theirs ? vw_score_tables_find(theirs, table->method) : NULL;
    enum vw_status status = VW_OK;
    *pearson = *spearman = NAN;
    if (!other || theirs->photo_count != photos) return VW_OK;
    for (uint32_t i = 0; i < ours->run_count && !status; i++)
        status = vw_agreement_of_pair(table->values + (size_t)i * photos, other->values + (size_t)i * photos, NULL, photos, &pairs[i]);
    if (status) return status;
    *pearson = vw_agreement_summarise(pairs, ours->run_count, VW_AGREEMENT_PEARSON).mean;
    *spearman = vw_agreement_summarise(pairs, ours->run_count, VW_AGREEMENT_SPEARMAN).mean;
    return VW_OK;
}

static enum vw_status compare_seeds(const struct vw_score_tables *tables, const struct vw_score_table *table,
                                    struct vw_tradeoff_figure *figure) {
    struct vw_agreement *pairs = NULL;
    uint32_t count = 0;
    enum vw_status status = vw_agreement_of_pairs(tables, table, &pairs, &count);
    if (status) return status;
    figure->seed_pearson = vw_agreement_summarise(pairs, count, VW_AGREEMENT_PEARSON).mean;
    figure->seed_spearman = vw_agreement_summarise(pairs, count, VW_AGREEMENT_SPEARMAN).mean;
    free(pairs);
    return VW_OK;
}

// ---- Truth --------------------------------------------------------------------------------------------------------------

// The methods that have a score for every photo: one that is missing cannot be summed over halves. Owned by the caller.
static struct vw_contestant *list_contestants(const struct vw_score_tables *tables, uint32_t *count) {
    struct vw_contestant *contestants = vw_allocate(tables->count, sizeof *contestants);
    *count = 0;
    for (uint32_t i = 0; i < tables->count && contestants; i++) {
        bool complete = true;
        for (size_t j = 0; j < (size_t)tables->run_count * tables->photo_count; j++) complete &= isfinite(tables->tables[i].values[j]) != 0;
        if (complete) contestants[(*count)++] = (struct vw_contestant){tables->tables[i].method, tables->tables[i].values};
    }
    return contestants;
}

// How well the methods find what is spoiled, and foretell what halves reach. `figures` has one for each table.
static enum vw_status judge(const struct vw_tradeoff *tradeoff, const struct vw_score_tables *tables, const char *const *truths,
                            struct vw_tradeoff_figure *figures) {
    uint32_t count = 0;
    struct vw_judgements judgements = {0};
    struct vw_contestant *contestants = list_contestants(tables, &count);
    const struct vw_contest contest = {.photos = tradeoff->laboratory.train_views,
                                       .truths = truths,
                                       .photo_count = tables->photo_count,
                                       .contestants = contestants,
                                       .contestant_count = count,
                                       .seed_count = tables->run_count};
    enum vw_status status = contestants ? VW_OK : VW_ERROR_MEMORY;
    if (!status && tables->unspoiled) status = vw_judge_detection(&contest, &judgements);
    if (!status && tradeoff->subsets.count) status = vw_judge_subsets(&contest, &tradeoff->subsets, &judgements);
    for (uint32_t i = 0; i < tables->count && !status; i++) {
        const struct vw_judgement *auc = vw_judgements_find(&judgements, "auc", "spoiled", figures[i].method);
        const struct vw_judgement *lds = vw_judgements_find(&judgements, "lds", "val_psnr", figures[i].method);
        if (auc) figures[i].auc = auc->value;
        if (lds) figures[i].lds = lds->value, figures[i].lds_low = lds->low, figures[i].lds_high = lds->high;
    }
    free(judgements.rows);
    free(contestants);
    return status;
}

// ---- Figures ------------------------------------------------------------------------------------------------------------

static struct vw_tradeoff_figure begin_figure(const struct vw_tradeoff *tradeoff, uint32_t point) {
    const struct vw_tradeoff_point *of_point = &tradeoff->points.points[point];
    const struct vw_measured_point *measured = &tradeoff->measured[point];
    double train_ms, value_ms;
    vw_tradeoff_step_ms(tradeoff, point, &train_ms, &value_ms);
    uint64_t steps = vw_tradeoff_steps(tradeoff, point);
    return (struct vw_tradeoff_figure){.point = of_point->name,
                                       .knob = of_point->knob,
                                       .setting = of_point->setting,
                                       .base = point == 0,
                                       .epochs = of_point->config.epochs,
                                       .steps = (uint32_t)steps,
                                       .train_ms = train_ms,
                                       .value_ms = value_ms,
                                       .scoring_ratio = value_ms / train_ms,
                                       .run_seconds = 1e-3 * value_ms * (double)steps,
                                       .device_mib = measured->device_bytes / 0x1p20,
                                       .val_psnr = measured->val_psnr,
                                       .all_pixels_pearson = NAN,
                                       .all_pixels_spearman = NAN,
                                       .auc = NAN,
                                       .lds = NAN,
                                       .lds_low = NAN,
                                       .lds_high = NAN};
}

static enum vw_status add_figures(struct vw_tradeoff *tradeoff, const struct vw_score_tables *all, uint32_t point, size_t *capacity,
                                  const char *const *truths) {
    const struct vw_score_tables *tables = &all[point];
    const struct vw_tradeoff_points *points = &tradeoff->points;
    bool same_trainings = point == 0 || !strcmp(points->points[point].knob, "val-rays");
    const struct vw_score_tables *all_pixels = same_trainings && points->all_pixels != UINT32_MAX ? &all[points->all_pixels] : NULL;
    enum vw_status status =
        vw_grow((void **)&tradeoff->figures, capacity, tradeoff->figure_count + tables->count, sizeof *tradeoff->figures);
    for (uint32_t i = 0; i < tables->count && !status; i++) {
        const struct vw_score_table *table = &tables->tables[i];
        struct vw_tradeoff_figure *figure = &tradeoff->figures[tradeoff->figure_count + i];
        *figure = begin_figure(tradeoff, point);
        figure->method = table->method;
        status = compare_seeds(tables, table, figure);
        if (!status)
            status = compare_points(tables, table, &all[points->exhaustive], &figure->agreement_pearson, &figure->agreement_spearman);
        if (!status) status = compare_points(tables, table, all_pixels, &figure->all_pixels_pearson, &figure->all_pixels_spearman);
    }
    if (!status) status = judge(tradeoff, tables, truths, tradeoff->figures + tradeoff->figure_count);
    if (!status) tradeoff->figure_count += tables->count;
    return status;
}

// Marks the fronts among the figures of one method, which has one for every point at most. The exhaustive point agrees with itself, and
// is no choice.
static void mark_fronts(struct vw_tradeoff *tradeoff, const char *method) {
    struct vw_tradeoff_figure *figures[VW_POINTS_MAX];
    double seconds[VW_POINTS_MAX] = {0}, psnr_db[VW_POINTS_MAX] = {0}, agreement[VW_POINTS_MAX] = {0};
    bool psnr_front[VW_POINTS_MAX], score_front[VW_POINTS_MAX];
    uint32_t count = 0;
    for (uint32_t i = 0; i < tradeoff->figure_count; i++) {
        struct vw_tradeoff_figure *figure = &tradeoff->figures[i];
        if (strcmp(figure->method, method) != 0) continue;
        bool exhaustive = !strcmp(figure->knob, "exhaustive");
        seconds[count] = figure->run_seconds;
        psnr_db[count] = figure->val_psnr;
        agreement[count] = exhaustive ? NAN : figure->agreement_pearson;
        figures[count++] = figure;
    }
    vw_front_mark(seconds, psnr_db, count, psnr_front);
    vw_front_mark(seconds, agreement, count, score_front);
    for (uint32_t i = 0; i < count; i++) figures[i]->psnr_front = psnr_front[i], figures[i]->score_front = score_front[i];
}

enum vw_status vw_tradeoff_make_figures(struct vw_tradeoff *tradeoff) {
    uint32_t point_count = tradeoff->points.count;
    struct vw_score_tables *all = vw_allocate(point_count, sizeof *all);
    bool known = false; // says score_tables, too
    const char **truths = vw_laboratory_list_truths(&tradeoff->laboratory, &known);
    size_t capacity = 0;
    enum vw_status status = all && truths ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < point_count && !status; i++) status = read_tables(tradeoff, i, &all[i]);
    for (uint32_t i = 0; i < point_count && !status; i++) status = add_figures(tradeoff, all, i, &capacity, truths);
    for (uint32_t i = 0; i < tradeoff->figure_count && !status; i++) {
        bool first = true;
        for (uint32_t j = 0; j < i && first; j++) first = strcmp(tradeoff->figures[j].method, tradeoff->figures[i].method) != 0;
        if (first) mark_fronts(tradeoff, tradeoff->figures[i].method);
    }
    for (uint32_t i = 0; i < point_count && all; i++) vw_score_tables_free(&all[i]);
    free(truths);
    free(all);
    return status;
}
