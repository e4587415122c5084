#include <math.h>
#include <stdio.h>
#include <string.h>

#include "cli/output/json_output.h"
#include "experiment/sweep/sweep.h"
#include "base/csv.h"
#include "viewworth/value.h"

// ---- CSV
// ----------------------------------------------------------------------------------------------------------------

static void print_field(FILE *stream, const struct vw_sweep_column *column, const struct vw_sweep_metrics *metric) {
    const void *value = (const char *)metric + column->offset;
    switch (column->kind) {
    case VW_TRADEOFF_TEXT: vw_csv_write_text(stream, *(const char *const *)value); break;
    case VW_TRADEOFF_WHOLE: fprintf(stream, "%u", *(const uint32_t *)value); break;
    case VW_TRADEOFF_REAL: vw_csv_write_real(stream, *(const double *)value); break;
    }
}

static void print_csv(FILE *stream, const void *context) {
    const struct vw_sweep *tradeoff = context;
    uint32_t count = 0;
    const struct vw_sweep_column *columns = vw_sweep_columns(&count);
    for (uint32_t i = 0; i < count; i++) fprintf(stream, "%s%s", i ? "," : "", columns[i].name);
    fputc('\n', stream);
    for (uint32_t row = 0; row < tradeoff->metric_count; row++) {
        for (uint32_t i = 0; i < count; i++) {
            if (i) fputc(',', stream);
            print_field(stream, &columns[i], &tradeoff->metrics[row]);
        }
        fputc('\n', stream);
    }
}

enum vw_status vw_sweep_write_csv(const struct vw_sweep *tradeoff, const char *path) {
    return vw_csv_write_file(path, print_csv, tradeoff);
}

// ---- The table
// ----------------------------------------------------------------------------------------------------------

enum { CELL_BYTES = 32 };

// A column of the table: digits behind the configuration, and whether it is left out where no configuration has a
// value.
static const struct column {
    const char *title;
    size_t offset;
    int width, digits;
} columns[] = {
    {"run, s", offsetof(struct vw_sweep_metrics, run_seconds), 8, 1},
    {"step, ms", offsetof(struct vw_sweep_metrics, train_ms), 8, 2},
    {"scored/un", offsetof(struct vw_sweep_metrics, scoring_ratio), 9, 2},
    {"MiB", offsetof(struct vw_sweep_metrics, device_mib), 6, 1},
    {"PSNR, dB", offsetof(struct vw_sweep_metrics, val_psnr), 8, 2},
    {"r seeds", offsetof(struct vw_sweep_metrics, seed_pearson), 7, 3},
    {"rho", offsetof(struct vw_sweep_metrics, seed_spearman), 6, 3},
    {"r full_resolution", offsetof(struct vw_sweep_metrics, agreement_pearson), 12, 3},
    {"rho", offsetof(struct vw_sweep_metrics, agreement_spearman), 6, 3},
    {"r all pixels", offsetof(struct vw_sweep_metrics, all_pixels_pearson), 12, 3},
    {"AUC", offsetof(struct vw_sweep_metrics, auc), 5, 2},
    {"LDS", offsetof(struct vw_sweep_metrics, lds), 5, 2},
};
enum { COLUMN_COUNT = sizeof columns / sizeof columns[0], NAME_WIDTH = 24 };

static double real_at(const struct vw_sweep_metrics *metric, size_t offset) {
    return *(const double *)((const char *)metric + offset);
}

static bool is_shown(const struct vw_sweep_metrics *metric) { return !strcmp(metric->method, vw_value_default_method); }
static bool is_choice(const struct vw_sweep_metrics *metric) {
    return is_shown(metric) && strcmp(metric->parameter, "full_resolution") != 0;
}

static bool is_used(const struct vw_sweep *tradeoff, const struct column *column) {
    for (uint32_t i = 0; i < tradeoff->metric_count; i++)
        if (is_shown(&tradeoff->metrics[i]) && isfinite(real_at(&tradeoff->metrics[i], column->offset))) return true;
    return false;
}

static void print_row(const struct vw_sweep *tradeoff, const struct vw_sweep_metrics *metric) {
    printf("%-*s", NAME_WIDTH, metric->configuration);
    for (int c = 0; c < COLUMN_COUNT; c++) {
        char text[CELL_BYTES] = "-";
        double value = real_at(metric, columns[c].offset);
        if (!is_used(tradeoff, &columns[c])) continue;
        if (isfinite(value)) snprintf(text, sizeof text, "%.*f", columns[c].digits, value);
        printf("  %*s", columns[c].width, text);
    }
    printf("  %s%s\n", metric->psnr_pareto_front ? "P" : "", metric->score_pareto_front ? "S" : "");
}

// The cheapest configuration that comes within a tolerance of the best: what costs more buys little.
static void print_knee(const struct vw_sweep *tradeoff, const char *what, size_t offset, double tolerance, int digits) {
    const struct vw_sweep_metrics *best = NULL, *knee = NULL;
    for (uint32_t i = 0; i < tradeoff->metric_count; i++) {
        const struct vw_sweep_metrics *metric = &tradeoff->metrics[i];
        double worth = real_at(metric, offset);
        if (!is_choice(metric) || !isfinite(worth)) continue;
        if (!best || worth > real_at(best, offset)) best = metric;
    }
    for (uint32_t i = 0; i < tradeoff->metric_count && best; i++) {
        const struct vw_sweep_metrics *metric = &tradeoff->metrics[i];
        bool near = real_at(metric, offset) >= real_at(best, offset) - tolerance;
        if (is_choice(metric) && near && (!knee || metric->run_seconds < knee->run_seconds)) knee = metric;
    }
    if (knee)
        printf("knee     %s: %s reaches %.*f in %.3g s; the best, %s, %.*f in %.3g s\n", what, knee->configuration,
               digits, real_at(knee, offset), knee->run_seconds, best->configuration, digits, real_at(best, offset),
               best->run_seconds);
}

void vw_sweep_print(const struct vw_sweep *tradeoff, const char *csv_path, const char *report_path) {
    printf("%s: %u configurations, %u seeds each, scores by %s\n\n%-*s", tradeoff->options->operand,
           tradeoff->configurations.count, tradeoff->options->seeds, vw_value_default_method, NAME_WIDTH,
           "configuration");
    for (int c = 0; c < COLUMN_COUNT; c++)
        if (is_used(tradeoff, &columns[c])) printf("  %*s", columns[c].width, columns[c].title);
    printf("  front\n");
    for (uint32_t i = 0; i < tradeoff->metric_count; i++)
        if (is_shown(&tradeoff->metrics[i])) print_row(tradeoff, &tradeoff->metrics[i]);
    printf("\nfront    P: no other configuration reaches that PSNR in less time; S: none agrees as well with the "
           "full_resolution scores in less time\n");
    print_knee(tradeoff, "PSNR within 0.3 dB of the best", offsetof(struct vw_sweep_metrics, val_psnr), 0.3, 2);
    print_knee(tradeoff, "agreement within 0.02", offsetof(struct vw_sweep_metrics, agreement_pearson), 0.02, 3);
    print_knee(tradeoff, "r of two seeds within 0.02", offsetof(struct vw_sweep_metrics, seed_pearson), 0.02, 3);
    for (uint32_t i = 0; i < tradeoff->configurations.count; i++)
        if (isnan(tradeoff->measured[i].val_psnr))
            printf("no PSNR  of %s: other pixels count there than at the base\n",
                   tradeoff->configurations.configurations[i].name);
    printf("table    %s\n", csv_path);
    if (report_path) printf("report   %s\n", report_path);
}

// ---- JSON
// ---------------------------------------------------------------------------------------------------------------

static json_t *metric_to_json(const struct vw_sweep_metrics *metric) {
    uint32_t count = 0;
    const struct vw_sweep_column *all = vw_sweep_columns(&count);
    json_t *object = json_object();
    bool failed = !object;
    for (uint32_t i = 0; i < count && !failed; i++) {
        const void *value = (const char *)metric + all[i].offset;
        json_t *json = all[i].kind == VW_TRADEOFF_TEXT    ? json_string(*(const char *const *)value)
                       : all[i].kind == VW_TRADEOFF_WHOLE ? json_integer(*(const uint32_t *)value)
                                                          : vw_json_real(*(const double *)value);
        failed = json_object_set_new(object, all[i].name, json) != 0;
    }
    if (!failed) return object;
    json_decref(object);
    return NULL;
}

enum vw_status vw_sweep_print_json(const struct vw_sweep *tradeoff, const char *csv_path, const char *report_path) {
    json_t *metrics = json_array();
    bool failed = !metrics;
    for (uint32_t i = 0; i < tradeoff->metric_count && !failed; i++)
        failed = json_array_append_new(metrics, metric_to_json(&tradeoff->metrics[i])) != 0;
    if (!failed)
        return vw_json_print(json_pack("{s:s, s:I, s:I, s:s, s:s*, s:o}", "scene", tradeoff->options->operand,
                                       "configurations", (json_int_t)tradeoff->configurations.count, "seeds",
                                       (json_int_t)tradeoff->options->seeds, "table", csv_path, "report", report_path,
                                       "metrics", metrics));
    json_decref(metrics);
    return vw_json_print(NULL);
}
