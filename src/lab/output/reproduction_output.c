#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/memory.h"
#include "cli/output/print.h"
#include "lab/output/results.h"
#include "viewworth/value.h"

enum { NAME_WIDTH = 18, CELL_WIDTH = 21 };

static const struct {
    enum vw_agreement_measure measure;
    const char *heading;
} columns[] = {
    {VW_AGREEMENT_PEARSON, "r"},
    {VW_AGREEMENT_SPEARMAN, "rho"},
    {VW_AGREEMENT_TRIMMED_PEARSON, "r without 2 extremes"},
    {VW_AGREEMENT_CLEAN_PEARSON, "r within clean"},
    {VW_AGREEMENT_POSITIVE_JACCARD, "same positive set"},
};

static const struct vw_reproduction_stop *last_stop(const struct vw_reproduction *reproduction) {
    return &reproduction->stops[reproduction->stop_count - 1];
}

// Returns the place of a method among a stop's tables; their count when no run has it.
static uint32_t find_method(const struct vw_reproduction_stop *stop, const char *method) {
    const struct vw_score_table *table = vw_score_tables_find(&stop->tables, method);
    return table ? (uint32_t)(table - stop->tables.tables) : stop->tables.count;
}

static struct vw_agreement_summary summarise(const struct vw_reproduction *reproduction,
                                             const struct vw_reproduction_stop *stop, uint32_t method,
                                             enum vw_agreement_measure measure) {
    return vw_full_agreement_summarise(stop->pairs[method], reproduction->pair_count, measure);
}

// ---- Text ----

static int name_width(const struct vw_score_tables *tables) {
    size_t width = NAME_WIDTH;
    for (uint32_t i = 0; i < tables->count; i++)
        if (strlen(tables->tables[i].method) > width) width = strlen(tables->tables[i].method);
    return (int)width;
}

// Returns the width of a column; 0 at the end of a line, so that it has no blanks. Coverage follows after all columns.
static int width_of(size_t column, size_t column_count) {
    return column + 1 < column_count || column_count == VW_ARRAY_COUNT(columns) ? CELL_WIDTH : 0;
}

static void print_cell(const struct vw_agreement_summary *summary, int width) {
    char text[64] = "-";
    if (summary->pairs > 1)
        snprintf(text, sizeof text, "%.3f [%.3f %.3f]", summary->mean, summary->lowest, summary->highest);
    else if (summary->pairs) snprintf(text, sizeof text, "%.3f", summary->mean);
    vw_print("  %-*s", width, text);
}

static void print_row(const struct vw_reproduction *reproduction, const struct vw_reproduction_stop *stop,
                      uint32_t method, size_t column_count) {
    for (size_t i = 0; i < column_count; i++) {
        struct vw_agreement_summary summary = summarise(reproduction, stop, method, columns[i].measure);
        print_cell(&summary, width_of(i, column_count));
    }
    struct vw_coverage coverage = vw_agreement_coverage(&stop->tables, &stop->tables.tables[method]);
    if (column_count < VW_ARRAY_COUNT(columns)) vw_print("\n");
    else if (coverage.intervals) vw_print("  %.3f of %u\n", coverage.share, coverage.intervals);
    else vw_print("  -\n");
}

static void print_headings(size_t column_count) {
    for (size_t i = 0; i < column_count; i++) vw_print("  %-*s", width_of(i, column_count), columns[i].heading);
    vw_print(column_count < VW_ARRAY_COUNT(columns) ? "\n" : "  intervals that hold the mean\n");
}

static void print_by_epochs(const struct vw_reproduction *reproduction) {
    vw_print("\n%s after fewer epochs\n%-6s  %13s", vw_value_default_method, "epochs", "training rays");
    print_headings(2);
    for (uint32_t i = 0; i < reproduction->stop_count; i++) {
        const struct vw_reproduction_stop *stop = &reproduction->stops[i];
        uint32_t method = find_method(stop, vw_value_default_method);
        vw_print("%6u  %13" PRIu64, stop->epochs, stop->training_rays);
        if (method < stop->tables.count) print_row(reproduction, stop, method, 2);
        else vw_print("\n");
    }
}

static void print_costs(const struct vw_reproduction *reproduction) {
    const struct vw_score_tables *tables = &last_stop(reproduction)->tables;
    if (!reproduction->methods.scorers) return;
    vw_print("\nwhat the scores of one run take\n%-*s  run-equivalents  CPU s\n", name_width(tables), "method");
    for (uint32_t i = 0; i < tables->count; i++) {
        const char *method = tables->tables[i].method;
        const struct vw_scorer_cost *cost = vw_reproduced_methods_cost(&reproduction->methods, method);
        if (!cost) continue;
        vw_print("%-*s  %15.4g", name_width(tables), method, cost->trainings);
        if (cost->seconds > 0) vw_print("  %.3g\n", cost->seconds);
        else vw_print("  -\n");
    }
}

static void print_text(const struct vw_reproduction *reproduction) {
    const struct vw_reproduction_stop *stop = last_stop(reproduction);
    const struct vw_config *config = reproduction->params->config;
    vw_print(
        "agreement of scores between seeds %" PRIu64 " to %" PRIu64 " (varying %s): %u photos, %u epochs, %" PRIu64
        " training rays a run\nmean over %u pair%s of seeds [lowest highest]; same positive set: photos above 0 in "
        "both / in either\n2 extremes: the two photos farthest from the median; intervals that hold the mean: share of "
        "the runs' 95 %% intervals that contain the mean over seeds\n%-*s",
        config->seed, config->seed + reproduction->params->seeds - 1, vw_vary_name(config->vary),
        stop->tables.photo_count, stop->epochs, stop->training_rays, reproduction->pair_count,
        reproduction->pair_count > 1 ? "s" : "", name_width(&stop->tables), "method");
    print_headings(VW_ARRAY_COUNT(columns));
    for (uint32_t method = 0; method < stop->tables.count; method++) {
        vw_print("%-*s", name_width(&stop->tables), stop->tables.tables[method].method);
        print_row(reproduction, stop, method, VW_ARRAY_COUNT(columns));
    }
    print_by_epochs(reproduction);
    print_costs(reproduction);
    if (reproduction->lasting.photo_count) vw_lasting_seeds_print(&reproduction->lasting, config->seed);
    vw_print("\nagreement  %s\nscatter    %s\n", reproduction->agreement_path, reproduction->scatter_path);
    if (reproduction->report_path) vw_print("report     %s\n", reproduction->report_path);
}

// ---- JSON ----

static json_t *summary_to_json(const struct vw_agreement_summary *summary) {
    return json_pack("{s:o, s:o, s:o, s:I}", "mean", vw_json_real(summary->mean), "lowest",
                     vw_json_real(summary->lowest), "highest", vw_json_real(summary->highest), "pairs",
                     (json_int_t)summary->pairs);
}

static json_t *method_to_json(const struct vw_reproduction *reproduction, const struct vw_reproduction_stop *stop,
                              uint32_t method) {
    const struct vw_score_table *table = &stop->tables.tables[method];
    json_t *object = json_pack("{s:s, s:s}", "method", table->method, "unit", table->unit);
    for (enum vw_agreement_measure measure = 0; measure < VW_AGREEMENT_COUNT; measure++) {
        struct vw_agreement_summary summary = summarise(reproduction, stop, method, measure);
        vw_json_set(&object, vw_agreement_name(measure), summary_to_json(&summary));
    }
    struct vw_coverage coverage = vw_agreement_coverage(&stop->tables, table);
    vw_json_set(
        &object, "interval_coverage",
        json_pack("{s:o, s:I}", "share", vw_json_real(coverage.share), "intervals", (json_int_t)coverage.intervals));
    const struct vw_scorer_cost *cost = vw_reproduced_methods_cost(&reproduction->methods, table->method);
    if (cost)
        vw_json_set(&object, "cost",
                    json_pack("{s:f, s:o}", "run_equivalents", cost->trainings, "seconds",
                              vw_json_real(cost->seconds > 0 ? cost->seconds : NAN)));
    return object;
}

static json_t *stop_to_json(const struct vw_reproduction *reproduction, const struct vw_reproduction_stop *stop) {
    json_t *methods = json_array();
    for (uint32_t i = 0; i < stop->tables.count; i++) vw_json_append(&methods, method_to_json(reproduction, stop, i));
    return json_pack("{s:I, s:I, s:o}", "epochs", (json_int_t)stop->epochs, "training_rays",
                     (json_int_t)stop->training_rays, "methods", methods);
}

// Returns JSON whose `by_epochs` contains all methods after more and more epochs; the last entry is after all.
static json_t *reproduction_to_json(const struct vw_reproduction *reproduction) {
    const struct vw_experiment_params *params = reproduction->params;
    json_t *stops = json_array(), *seeds = json_array();
    for (uint32_t i = 0; i < reproduction->stop_count; i++)
        vw_json_append(&stops, stop_to_json(reproduction, &reproduction->stops[i]));
    for (uint32_t i = 0; i < params->seeds; i++)
        vw_json_append(&seeds, json_integer((json_int_t)(params->config->seed + i)));
    json_t *lasting = reproduction->lasting.photo_count ? vw_lasting_seeds_to_json(&reproduction->lasting) : NULL;
    return json_pack("{s:s, s:o, s:s, s:I, s:o, s:o*, s:s, s:s, s:s*}", "scene", params->scene.path, "seeds", seeds,
                     "vary", vw_vary_name(params->config->vary), "photos",
                     (json_int_t)last_stop(reproduction)->tables.photo_count, "by_epochs", stops, "lasting", lasting,
                     "agreement", reproduction->agreement_path, "scatter", reproduction->scatter_path, "report",
                     reproduction->report_path);
}

enum vw_status vw_reproduction_print(const struct vw_reproduction *reproduction, bool json) {
    if (json) return vw_json_print(reproduction_to_json(reproduction));
    print_text(reproduction);
    return VW_OK;
}
