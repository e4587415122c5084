#include <math.h>
#include <stdio.h>
#include <string.h>

#include "cli/json_output.h"
#include "cli/tradeoff.h"
#include "viewworth/csv.h"
#include "viewworth/value.h"

// ---- CSV ----------------------------------------------------------------------------------------------------------------

static void print_field(FILE *stream, const struct vw_tradeoff_column *column, const struct vw_tradeoff_figure *figure) {
    const void *value = (const char *)figure + column->offset;
    switch (column->kind) {
    case VW_TRADEOFF_TEXT: vw_csv_write_text(stream, *(const char *const *)value); break;
    case VW_TRADEOFF_WHOLE: fprintf(stream, "%u", *(const uint32_t *)value); break;
    case VW_TRADEOFF_REAL: vw_csv_write_real(stream, *(const double *)value); break;
    }
}

static void print_csv(FILE *stream, const void *context) {
    const struct vw_tradeoff *tradeoff = context;
    uint32_t count = 0;
    const struct vw_tradeoff_column *columns = vw_tradeoff_columns(&count);
    for (uint32_t i = 0; i < count; i++) fprintf(stream, "%s%s", i ? "," : "", columns[i].name);
    fputc('\n', stream);
    for (uint32_t row = 0; row < tradeoff->figure_count; row++) {
        for (uint32_t i = 0; i < count; i++) {
            if (i) fputc(',', stream);
            print_field(stream, &columns[i], &tradeoff->figures[row]);
        }
        fputc('\n', stream);
    }
}

enum vw_status vw_tradeoff_write_csv(const struct vw_tradeoff *tradeoff, const char *path) {
    return vw_csv_write_file(path, print_csv, tradeoff);
}

// ---- The table ----------------------------------------------------------------------------------------------------------

enum { CELL_BYTES = 32 };

// A column of the table: digits behind the point, and whether it is left out where no point has a value.
static const struct column {
    const char *title;
    size_t offset;
    int width, digits;
} columns[] = {
    {"run, s", offsetof(struct vw_tradeoff_figure, run_seconds), 8, 1},
    {"step, ms", offsetof(struct vw_tradeoff_figure, train_ms), 8, 2},
    {"scored/un", offsetof(struct vw_tradeoff_figure, scoring_ratio), 9, 2},
    {"MiB", offsetof(struct vw_tradeoff_figure, device_mib), 6, 1},
    {"PSNR, dB", offsetof(struct vw_tradeoff_figure, val_psnr), 8, 2},
    {"r seeds", offsetof(struct vw_tradeoff_figure, seed_pearson), 7, 3},
    {"rho", offsetof(struct vw_tradeoff_figure, seed_spearman), 6, 3},
    {"r exhaustive", offsetof(struct vw_tradeoff_figure, agreement_pearson), 12, 3},
    {"rho", offsetof(struct vw_tradeoff_figure, agreement_spearman), 6, 3},
    {"r all pixels", offsetof(struct vw_tradeoff_figure, all_pixels_pearson), 12, 3},
    {"AUC", offsetof(struct vw_tradeoff_figure, auc), 5, 2},
    {"LDS", offsetof(struct vw_tradeoff_figure, lds), 5, 2},
};
enum { COLUMN_COUNT = sizeof columns / sizeof columns[0], NAME_WIDTH = 24 };

static double real_at(const struct vw_tradeoff_figure *figure, size_t offset) { return *(const double *)((const char *)figure + offset); }

static bool is_shown(const struct vw_tradeoff_figure *figure) { return !strcmp(figure->method, vw_value_default_method); }
static bool is_choice(const struct vw_tradeoff_figure *figure) { return is_shown(figure) && strcmp(figure->knob, "exhaustive") != 0; }

static bool is_used(const struct vw_tradeoff *tradeoff, const struct column *column) {
    for (uint32_t i = 0; i < tradeoff->figure_count; i++)
        if (is_shown(&tradeoff->figures[i]) && isfinite(real_at(&tradeoff->figures[i], column->offset))) return true;
    return false;
}

static void print_row(const struct vw_tradeoff *tradeoff, const struct vw_tradeoff_figure *figure) {
    printf("%-*s", NAME_WIDTH, figure->point);
    for (int c = 0; c < COLUMN_COUNT; c++) {
        char text[CELL_BYTES] = "-";
        double value = real_at(figure, columns[c].offset);
        if (!is_used(tradeoff, &columns[c])) continue;
        if (isfinite(value)) snprintf(text, sizeof text, "%.*f", columns[c].digits, value);
        printf("  %*s", columns[c].width, text);
    }
    printf("  %s%s\n", figure->psnr_front ? "P" : "", figure->score_front ? "S" : "");
}

// The cheapest point that comes within a tolerance of the best: what costs more buys little.
static void print_knee(const struct vw_tradeoff *tradeoff, const char *what, size_t offset, double tolerance, int digits) {
    const struct vw_tradeoff_figure *best = NULL, *knee = NULL;
    for (uint32_t i = 0; i < tradeoff->figure_count; i++) {
        const struct vw_tradeoff_figure *figure = &tradeoff->figures[i];
        double worth = real_at(figure, offset);
        if (!is_choice(figure) || !isfinite(worth)) continue;
        if (!best || worth > real_at(best, offset)) best = figure;
    }
    for (uint32_t i = 0; i < tradeoff->figure_count && best; i++) {
        const struct vw_tradeoff_figure *figure = &tradeoff->figures[i];
        bool near = real_at(figure, offset) >= real_at(best, offset) - tolerance;
        if (is_choice(figure) && near && (!knee || figure->run_seconds < knee->run_seconds)) knee = figure;
    }
    if (knee)
        printf("knee     %s: %s reaches %.*f in %.3g s; the best, %s, %.*f in %.3g s\n", what, knee->point, digits, real_at(knee, offset),
               knee->run_seconds, best->point, digits, real_at(best, offset), best->run_seconds);
}

void vw_tradeoff_print(const struct vw_tradeoff *tradeoff, const char *csv_path, const char *report_path) {
    printf("%s: %u points, %u seeds each, scores by %s\n\n%-*s", tradeoff->options->operand, tradeoff->points.count,
           tradeoff->options->seeds, vw_value_default_method, NAME_WIDTH, "point");
    for (int c = 0; c < COLUMN_COUNT; c++)
        if (is_used(tradeoff, &columns[c])) printf("  %*s", columns[c].width, columns[c].title);
    printf("  front\n");
    for (uint32_t i = 0; i < tradeoff->figure_count; i++)
        if (is_shown(&tradeoff->figures[i])) print_row(tradeoff, &tradeoff->figures[i]);
    printf("\nfront    P: no other point reaches that PSNR in less time; S: none agrees as well with the exhaustive scores in less time\n");
    print_knee(tradeoff, "PSNR within 0.3 dB of the best", offsetof(struct vw_tradeoff_figure, val_psnr), 0.3, 2);
    print_knee(tradeoff, "agreement within 0.02", offsetof(struct vw_tradeoff_figure, agreement_pearson), 0.02, 3);
    print_knee(tradeoff, "r of two seeds within 0.02", offsetof(struct vw_tradeoff_figure, seed_pearson), 0.02, 3);
    for (uint32_t i = 0; i < tradeoff->points.count; i++)
        if (isnan(tradeoff->measured[i].val_psnr))
            printf("no PSNR  of %s: other pixels count there than at the base\n", tradeoff->points.points[i].name);
    printf("table    %s\n", csv_path);
    if (report_path) printf("report   %s\n", report_path);
}

// ---- JSON ---------------------------------------------------------------------------------------------------------------

static json_t *figure_to_json(const struct vw_tradeoff_figure *figure) {
    uint32_t count = 0;
    const struct vw_tradeoff_column *all = vw_tradeoff_columns(&count);
    json_t *object = json_object();
    bool failed = !object;
    for (uint32_t i = 0; i < count && !failed; i++) {
        const void *value = (const char *)figure + all[i].offset;
        json_t *json = all[i].kind == VW_TRADEOFF_TEXT    ? json_string(*(const char *const *)value)
                       : all[i].kind == VW_TRADEOFF_WHOLE ? json_integer(*(const uint32_t *)value)
                                                          : vw_json_real(*(const double *)value);
        failed = json_object_set_new(object, all[i].name, json) != 0;
    }
    if (!failed) return object;
    json_decref(object);
    return NULL;
}

enum vw_status vw_tradeoff_print_json(const struct vw_tradeoff *tradeoff, const char *csv_path, const char *report_path) {
    json_t *figures = json_array();
    bool failed = !figures;
    for (uint32_t i = 0; i < tradeoff->figure_count && !failed; i++)
        failed = json_array_append_new(figures, figure_to_json(&tradeoff->figures[i])) != 0;
    if (!failed)
        return vw_json_print(json_pack("{s:s, s:I, s:I, s:s, s:s*, s:o}", "scene", tradeoff->options->operand, "points",
                                       (json_int_t)tradeoff->points.count, "seeds", (json_int_t)tradeoff->options->seeds, "table", csv_path,
                                       "report", report_path, "figures", figures));
    json_decref(figures);
    return vw_json_print(NULL);
}
