#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/text.h"
#include "cli/output/print.h"
#include "cli/output/results.h"
#include "viewworth/value.h"

// ---- The table ----

enum { CELL_BYTES = 32 };

// A column of the table; it is left out when no configuration has a value.
static const struct column {
    const char *title;
    size_t offset;
    int width, digits;
} columns[] = {
    {"run, s", offsetof(struct vw_sweep_metrics, run_seconds), 8, 1},
    {"step, ms", offsetof(struct vw_sweep_metrics, train_ms), 8, 2},
    {"ratio", offsetof(struct vw_sweep_metrics, scoring_ratio), 6, 2},
    {"MiB", offsetof(struct vw_sweep_metrics, device_mib), 6, 1},
    {"PSNR, dB", offsetof(struct vw_sweep_metrics, val_psnr), 8, 2},
    {"r seeds", offsetof(struct vw_sweep_metrics, seed_pearson), 7, 3},
    {"rho", offsetof(struct vw_sweep_metrics, seed_spearman), 6, 3},
    {"r reference", offsetof(struct vw_sweep_metrics, agreement_pearson), 12, 3},
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

static bool is_used(const struct vw_sweep *sweep, const struct column *column) {
    for (uint32_t i = 0; i < sweep->metric_count; i++)
        if (is_shown(&sweep->metrics[i]) && isfinite(real_at(&sweep->metrics[i], column->offset))) return true;
    return false;
}

static void print_row(const struct vw_sweep *sweep, const struct vw_sweep_metrics *metric) {
    vw_print("%-*s", NAME_WIDTH, metric->configuration);
    for (int c = 0; c < COLUMN_COUNT; c++) {
        char text[CELL_BYTES] = "-";
        double value = real_at(metric, columns[c].offset);
        if (!is_used(sweep, &columns[c])) continue;
        if (isfinite(value)) snprintf(text, sizeof text, "%.*f", columns[c].digits, value);
        vw_print("  %*s", columns[c].width, text);
    }
    vw_print("  %s%s\n", metric->psnr_pareto_front ? "P" : "", metric->score_pareto_front ? "S" : "");
}

// Prints the knee: the fastest configuration within a tolerance of the best value. Slower ones gain little.
static void print_knee(const struct vw_sweep *sweep, const char *what, size_t offset, double tolerance, int digits) {
    const struct vw_sweep_metrics *best = NULL, *knee = NULL;
    for (uint32_t i = 0; i < sweep->metric_count; i++) {
        const struct vw_sweep_metrics *metric = &sweep->metrics[i];
        double quality = real_at(metric, offset);
        if (!is_choice(metric) || !isfinite(quality)) continue;
        if (!best || quality > real_at(best, offset)) best = metric;
    }
    for (uint32_t i = 0; i < sweep->metric_count && best; i++) {
        const struct vw_sweep_metrics *metric = &sweep->metrics[i];
        bool near = real_at(metric, offset) >= real_at(best, offset) - tolerance;
        if (is_choice(metric) && near && (!knee || metric->run_seconds < knee->run_seconds)) knee = metric;
    }
    if (!knee) return;
    char time[VW_DURATION_BYTES], best_time[VW_DURATION_BYTES];
    vw_text_duration(knee->run_seconds, time);
    vw_text_duration(best->run_seconds, best_time);
    vw_print("knee     %s: %s reaches %.*f in %s; the best, %s, %.*f in %s\n", what, knee->configuration, digits,
             real_at(knee, offset), time, best->configuration, digits, real_at(best, offset), best_time);
}

// Configurations that measure other pixels than the base have no PSNR.
static void print_missing_psnr(const struct vw_sweep *sweep) {
    for (uint32_t i = 0; i < sweep->metric_count; i++)
        if (is_shown(&sweep->metrics[i]) && isnan(sweep->metrics[i].val_psnr))
            vw_print("no PSNR  for %s: it measures other pixels than the base\n", sweep->metrics[i].configuration);
}

static void print_text(const struct vw_sweep *sweep) {
    vw_print("%s: %u configurations, %u seed%s each, scores by %s\n\n%-*s", sweep->params->common.scene.path,
             sweep->configurations->count, sweep->params->common.seeds, vw_plural(sweep->params->common.seeds),
             vw_value_default_method, NAME_WIDTH, "configuration");
    for (int c = 0; c < COLUMN_COUNT; c++)
        if (is_used(sweep, &columns[c])) vw_print("  %*s", columns[c].width, columns[c].title);
    vw_print("  Pareto front\n");
    for (uint32_t i = 0; i < sweep->metric_count; i++)
        if (is_shown(&sweep->metrics[i])) print_row(sweep, &sweep->metrics[i]);
    vw_print("\nfront    P: no other configuration reaches that PSNR in less time; S: no other agrees as well with the "
             "full_resolution reference in less time\n");
    print_knee(sweep, "PSNR within 0.3 dB of the best", offsetof(struct vw_sweep_metrics, val_psnr), 0.3, 2);
    print_knee(sweep, "agreement within 0.02", offsetof(struct vw_sweep_metrics, agreement_pearson), 0.02, 3);
    print_knee(sweep, "r of two seeds within 0.02", offsetof(struct vw_sweep_metrics, seed_pearson), 0.02, 3);
    print_missing_psnr(sweep);
    vw_print("table    %s\n", sweep->csv_path);
    if (sweep->report_path) vw_print("report   %s\n", sweep->report_path);
}

// ---- JSON ----

static json_t *field_to_json(const struct vw_column *column, const struct vw_sweep_metrics *metric) {
    const void *value = (const char *)metric + column->offset;
    switch (column->kind) {
    case VW_COLUMN_TEXT: return json_string(*(const char *const *)value);
    case VW_COLUMN_COUNT: return json_integer(*(const uint32_t *)value);
    default: return vw_json_real(*(const double *)value);
    }
    return NULL;
}

static json_t *metric_to_json(const struct vw_sweep_metrics *metric) {
    uint32_t count = 0;
    const struct vw_column *all = vw_sweep_columns(&count);
    json_t *object = json_object();
    for (uint32_t i = 0; i < count; i++) vw_json_set(&object, all[i].name, field_to_json(&all[i], metric));
    return object;
}

enum vw_status vw_sweep_print(const struct vw_sweep *sweep, bool json) {
    if (!json) {
        print_text(sweep);
        return VW_OK;
    }
    json_t *metrics = json_array();
    for (uint32_t i = 0; i < sweep->metric_count; i++) vw_json_append(&metrics, metric_to_json(&sweep->metrics[i]));
    return vw_json_print(json_pack("{s:s, s:I, s:I, s:s, s:s*, s:o}", "scene", sweep->params->common.scene.path,
                                   "configurations", (json_int_t)sweep->configurations->count, "seeds",
                                   (json_int_t)sweep->params->common.seeds, "table", sweep->csv_path, "report",
                                   sweep->report_path, "metrics", metrics));
}
