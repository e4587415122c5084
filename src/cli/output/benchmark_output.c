#include "cli/output/benchmark_output.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "cli/output/json_output.h"
#include "base/csv.h"

static void print_csv(FILE *stream, const void *context) {
    const struct vw_benchmark_output *output = context;
    fputs("scene,metric,method,value,ci_low,ci_high,count\n", stream);
    for (size_t i = 0; i < output->metrics->count; i++) {
        const struct vw_metric *row = &output->metrics->rows[i];
        vw_csv_write_text(stream, output->scene);
        fputc(',', stream);
        vw_csv_write_text(stream, row->metric);
        fputc(',', stream);
        vw_csv_write_text(stream, row->method);
        const double values[] = {row->value, row->ci_low, row->ci_high};
        for (int v = 0; v < 3; v++) {
            fputc(',', stream);
            vw_csv_write_real(stream, values[v]);
        }
        fprintf(stream, ",%u\n", row->count);
    }
}

enum vw_status vw_benchmark_write_csv(const struct vw_benchmark_output *output) {
    return vw_csv_write_file(output->csv_path, print_csv, output);
}

// ---- The table
// ------------------------------------------------------------------------------------------------------------

// A column of the table: a metric, shown with its interval where there is one.
struct column {
    const char *title, *group, *name;
    int digits;
    bool interval;
};

static const struct column columns[] = {
    {"AUC all", "auc", "corrupted", 2, false},         {"AUC harmful", "auc", "harmful", 2, false},
    {"r seeds", "seed_pearson", "all", 2, false},      {"r clean", "seed_pearson", "clean", 2, false},
    {"LDS val (95 %)", "lds", "val_psnr", 2, true},    {"LDS test (95 %)", "lds", "test_psnr", 2, true},
    {"less dv_psnr", "lds_gain", "val_psnr", 2, true}, {"LOO rho", "leave_one_out", "spearman", 2, false},
    {"-20 % low, dB", "removal_low", "20", 2, false},  {"-20 % high", "removal_high", "20", 2, false},
};
enum { COLUMN_COUNT = sizeof columns / sizeof columns[0], CELL_BYTES = 40, NAME_WIDTH = 22 };

static bool is_used(const struct vw_metrics *metrics, const struct column *column) {
    char metric[VW_METRIC_BYTES];
    snprintf(metric, sizeof metric, "%s/%s", column->group, column->name);
    for (size_t i = 0; i < metrics->count; i++)
        if (!strcmp(metrics->rows[i].metric, metric) && isfinite(metrics->rows[i].value)) return true;
    return false;
}

static int width_of(const struct column *column) {
    int title = (int)strlen(column->title), cell = column->interval ? 19 : 6;
    return title > cell ? title : cell;
}

static void format_cell(const struct vw_metric *row, const struct column *column, char text[CELL_BYTES]) {
    snprintf(text, CELL_BYTES, "-");
    if (!row || !isfinite(row->value)) return;
    bool interval = column->interval && isfinite(row->ci_low);
    if (interval) snprintf(text, CELL_BYTES, "%.2f (%.2f to %.2f)", row->value, row->ci_low, row->ci_high);
    else snprintf(text, CELL_BYTES, "%.*f", column->digits, row->value);
}

static void print_header(const struct vw_benchmark_output *output) {
    printf("%-*s", NAME_WIDTH, "method");
    for (int c = 0; c < COLUMN_COUNT; c++)
        if (is_used(output->metrics, &columns[c])) printf("  %*s", width_of(&columns[c]), columns[c].title);
    printf("  trainings  CPU s\n");
}

static void print_method(const struct vw_benchmark_output *output, const char *method, int64_t trainings) {
    printf("%-*s", NAME_WIDTH, method);
    for (int c = 0; c < COLUMN_COUNT; c++) {
        char text[CELL_BYTES];
        if (!is_used(output->metrics, &columns[c])) continue;
        format_cell(vw_metrics_find(output->metrics, columns[c].group, columns[c].name, method), &columns[c], text);
        printf("  %*s", width_of(&columns[c]), text);
    }
    if (trainings < 0) putchar('\n');
    else
        printf("  %9lld %6.3g\n", (long long)trainings, trainings ? (double)trainings * output->training_seconds : 0.0);
}

// Rows that are about the scene, not about a method: "harm/blur  0.31 (0.12 to 0.50)".
static void print_scene_rows(const struct vw_metrics *metrics) {
    for (size_t i = 0; i < metrics->count; i++) {
        const struct vw_metric *row = &metrics->rows[i];
        if (!strncmp(row->metric, "harm/", 5))
            printf(
                "a photo with %s adds %.2f dB (%.2f to %.2f) less than a clean one, of validation PSNR (%u photos)\n",
                row->metric + 5, row->value, row->ci_low, row->ci_high, row->count);
        else if (!strncmp(row->metric, "agreement/", 10))
            printf("two trainings on the same photos agree in %s by rho = %.2f over %u subsets\n", row->metric + 10,
                   row->value, row->count);
    }
}

void vw_benchmark_print(const struct vw_benchmark_output *output) {
    const struct vw_scorers *scorers = output->scorers;
    printf("%s: %u photos, %u subsets of %u, each trained on twice\n", output->scene, scorers->evaluation.photo_count,
           output->subset_count, scorers->evaluation.photo_count / 2);
    print_scene_rows(output->metrics);
    putchar('\n');
    print_header(output);
    for (uint32_t i = 0; i < scorers->evaluation.scorer_count; i++)
        print_method(output, scorers->list[i].name, scorers->trainings[i]);
    print_method(output, "noise ceiling", -1);
    print_method(output, "chance", -1);
    printf("\ntable    %s\n", output->csv_path);
}

// ---- JSON
// -----------------------------------------------------------------------------------------------------------------

static json_t *metrics_to_json(const struct vw_metrics *metrics) {
    json_t *array = json_array();
    for (size_t i = 0; array && i < metrics->count; i++) {
        const struct vw_metric *row = &metrics->rows[i];
        json_t *entry = json_pack("{s:s, s:s, s:o, s:o, s:o, s:I}", "metric", row->metric, "method", row->method,
                                  "value", vw_json_real(row->value), "ci_low", vw_json_real(row->ci_low), "ci_high",
                                  vw_json_real(row->ci_high), "count", (json_int_t)row->count);
        if (!json_array_append_new(array, entry)) continue;
        json_decref(array);
        array = NULL;
    }
    return array;
}

static json_t *costs_to_json(const struct vw_benchmark_output *output) {
    json_t *object = json_object();
    for (uint32_t i = 0; object && i < output->scorers->evaluation.scorer_count; i++)
        if (json_object_set_new(object, output->scorers->list[i].name, json_integer(output->scorers->trainings[i]))) {
            json_decref(object);
            object = NULL;
        }
    return object;
}

enum vw_status vw_benchmark_print_json(const struct vw_benchmark_output *output) {
    const struct vw_evaluation *evaluation = &output->scorers->evaluation;
    return vw_json_print(json_pack("{s:s, s:I, s:I, s:s, s:o, s:o, s:o}", "scene", output->scene, "photos",
                                   (json_int_t)evaluation->photo_count, "subsets", (json_int_t)output->subset_count,
                                   "table", output->csv_path, "seconds_per_training",
                                   vw_json_real(output->training_seconds), "trainings", costs_to_json(output),
                                   "metrics", metrics_to_json(output->metrics)));
}
