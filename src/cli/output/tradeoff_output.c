#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/text.h"
#include "cli/output/print.h"
#include "cli/output/results.h"
#include "viewworth/value.h"

static double real_at(const struct vw_sweep_metrics *metric, size_t offset) {
    return *(const double *)((const char *)metric + offset);
}

static bool is_shown(const struct vw_sweep_metrics *metric) { return !strcmp(metric->method, vw_value_default_method); }
static bool is_choice(const struct vw_sweep_metrics *metric) {
    return is_shown(metric) && strcmp(metric->parameter, "full_resolution") != 0;
}

// Prints the rows of the default method.
static void print_table(const struct vw_sweep *sweep) {
    struct vw_sweep_metrics *shown = vw_allocate(sweep->metric_count, sizeof *shown);
    uint32_t count = 0;
    for (uint32_t i = 0; shown && i < sweep->metric_count; i++)
        if (is_shown(&sweep->metrics[i])) shown[count++] = sweep->metrics[i];
    const struct vw_rows rows = vw_sweep_rows(shown, count);
    vw_print_rows(&rows);
    free(shown);
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
    vw_print("%s: %u configurations, %u seed%s each, scores by %s\n\n", sweep->params->common.scene.path,
             sweep->configurations->count, sweep->params->common.seeds, vw_plural(sweep->params->common.seeds),
             vw_value_default_method);
    print_table(sweep);
    vw_print("\nfront    1: no other configuration reaches that PSNR in less time\n");
    print_knee(sweep, "PSNR within 0.3 dB of the best", offsetof(struct vw_sweep_metrics, val_psnr), 0.3, 2);
    print_knee(sweep, "agreement within 0.02", offsetof(struct vw_sweep_metrics, agreement_pearson), 0.02, 3);
    print_knee(sweep, "r of two seeds within 0.02", offsetof(struct vw_sweep_metrics, seed_pearson), 0.02, 3);
    print_missing_psnr(sweep);
    vw_print("table    %s\n", sweep->csv_path);
    if (sweep->report_path) vw_print("report   %s\n", sweep->report_path);
}

// ---- JSON ----

enum vw_status vw_sweep_print(const struct vw_sweep *sweep, bool json) {
    if (!json) {
        print_text(sweep);
        return VW_OK;
    }
    const struct vw_rows metrics = vw_sweep_rows(sweep->metrics, sweep->metric_count);
    return vw_json_print(json_pack("{s:s, s:I, s:I, s:s, s:s*, s:o}", "scene", sweep->params->common.scene.path,
                                   "configurations", (json_int_t)sweep->configurations->count, "seeds",
                                   (json_int_t)sweep->params->common.seeds, "table", sweep->csv_path, "report",
                                   sweep->report_path, "metrics", vw_rows_to_json(&metrics)));
}
