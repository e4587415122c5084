#include <math.h>
#include <stdio.h>
#include <string.h>

#include "cli/output/print.h"
#include "lab/output/results.h"

// ---- The table ----

// A column of the table: a metric, shown with its interval where there is one.
struct column {
    const char *title, *group, *name;
    int digits;
    bool interval;
};

// Scores are shown against test photos, and against validation photos where there are no others.
static const struct column columns[2][7] = {{{"LDS halves (95 %)", "lds", "val_psnr", 2, true},
                                             {"LDS sizes (95 %)", "lds_sizes", "val_psnr", 2, true},
                                             {"LOO (95 %)", "leave_one_out", "val_psnr", 2, true},
                                             {"Shapley (95 %)", "exact_shapley", "val_psnr", 2, true},
                                             {"AUC (95 %)", "auc", "corrupted", 2, true},
                                             {"sign", "sign_accuracy", "val_psnr", 2, false},
                                             {"-20 % low, dB", "removal_low", "20", 2, true}},
                                            {{"LDS halves (95 %)", "lds", "test_psnr", 2, true},
                                             {"LDS sizes (95 %)", "lds_sizes", "test_psnr", 2, true},
                                             {"LOO (95 %)", "leave_one_out", "test_psnr", 2, true},
                                             {"Shapley (95 %)", "exact_shapley", "test_psnr", 2, true},
                                             {"AUC (95 %)", "auc", "corrupted", 2, true},
                                             {"sign", "sign_accuracy", "test_psnr", 2, false},
                                             {"-20 % low, dB", "removal_low", "20", 2, true}}};
enum { COLUMN_COUNT = 7, CELL_BYTES = 40, NAME_WIDTH = 18 };

static bool is_used(const struct vw_metrics *metrics, const struct column *column) {
    char metric[VW_METRIC_BYTES];
    snprintf(metric, sizeof metric, "%s/%s", column->group, column->name);
    for (size_t i = 0; i < metrics->count; i++)
        if (!strcmp(metrics->rows[i].metric, metric) && isfinite(metrics->rows[i].value)) return true;
    return false;
}

static int width_of(const struct column *column) {
    int title = (int)strlen(column->title), cell = column->interval ? 22 : 6;
    return title > cell ? title : cell;
}

static void format_cell(const struct vw_metric *row, const struct column *column, char text[CELL_BYTES]) {
    snprintf(text, CELL_BYTES, "-");
    if (!row || !isfinite(row->value)) return;
    bool interval = column->interval && isfinite(row->ci_low);
    if (interval) snprintf(text, CELL_BYTES, "%.2f (%.2f to %.2f)", row->value, row->ci_low, row->ci_high);
    else snprintf(text, CELL_BYTES, "%.*f", column->digits, row->value);
}

static void print_header(const struct vw_benchmark *benchmark) {
    const struct column *shown = columns[benchmark->has_tests];
    vw_print("%-*s", NAME_WIDTH, "method");
    for (int c = 0; c < COLUMN_COUNT; c++)
        if (is_used(&benchmark->metrics, &shown[c])) vw_print("  %*s", width_of(&shown[c]), shown[c].title);
    vw_print("  trainings  CPU s\n");
}

// Prints a row. `cost`: NULL if the row is not of a method.
static void print_method(const struct vw_benchmark *benchmark, const char *method,
                         const struct vw_benchmark_method *cost) {
    const struct column *shown = columns[benchmark->has_tests];
    vw_print("%-*s", NAME_WIDTH, method);
    for (int c = 0; c < COLUMN_COUNT; c++) {
        char text[CELL_BYTES];
        if (!is_used(&benchmark->metrics, &shown[c])) continue;
        format_cell(vw_metrics_find(&benchmark->metrics, shown[c].group, shown[c].name, method), &shown[c], text);
        vw_print("  %*s", width_of(&shown[c]), text);
    }
    if (cost) vw_print("  %9.4g %6.3g\n", cost->trainings, cost->seconds);
    else vw_print("\n");
}

// Prints the metrics of the scene, not of a method: "harm/blur  0.31 (0.12 to 0.50)".
static void print_scene_rows(const struct vw_metrics *metrics) {
    for (size_t i = 0; i < metrics->count; i++) {
        const struct vw_metric *row = &metrics->rows[i];
        if (!strncmp(row->metric, "harm/", 5))
            vw_print("a photo with %s is worth %.2f dB (%.2f to %.2f) less than a clean one (%u photos)\n",
                     row->metric + 5, row->value, row->ci_low, row->ci_high, row->count);
    }
}

static void print_truth(const struct vw_benchmark *benchmark) {
    const struct vw_benchmark_params *params = benchmark->params;
    vw_print("%s: %u photos, %u valued runs\n", params->common.scene.path, benchmark->photo_count,
             params->common.seeds);
    if (params->all_subsets) vw_print("truth: all %u subsets", benchmark->size_count);
    else
        vw_print("truth: %u random halves and %u subsets of %d to 100 %%", benchmark->half_count, benchmark->size_count,
                 VW_SUBSETS_LOWEST_PERCENT);
    vw_print(", %u trainings of each at equal %s, by %s PSNR,\n       mean over the ends of the last %u epochs\n",
             params->retraining_seeds, vw_equal_name(params->equal), benchmark->has_tests ? "test" : "validation",
             benchmark->truth_epochs);
}

static void print_text(const struct vw_benchmark *benchmark) {
    print_truth(benchmark);
    print_scene_rows(&benchmark->metrics);
    vw_print("\n");
    print_header(benchmark);
    for (uint32_t i = 0; i < benchmark->method_count; i++)
        print_method(benchmark, benchmark->methods[i].name, &benchmark->methods[i]);
    print_method(benchmark, "noise ceiling", NULL);
    print_method(benchmark, "chance", NULL);
    vw_print("\nNo score can exceed the noise ceiling; a score within the interval of chance shows nothing.\n");
    vw_print("table    %s\n", benchmark->csv_path);
}

// ---- JSON ----

static json_t *metrics_to_json(const struct vw_metrics *metrics) {
    json_t *array = json_array();
    for (size_t i = 0; i < metrics->count; i++) {
        const struct vw_metric *row = &metrics->rows[i];
        vw_json_append(&array, json_pack("{s:s, s:s, s:o, s:o, s:o, s:I}", "metric", row->metric, "method", row->method,
                                         "value", vw_json_real(row->value), "ci_low", vw_json_real(row->ci_low),
                                         "ci_high", vw_json_real(row->ci_high), "count", (json_int_t)row->count));
    }
    return array;
}

static json_t *costs_to_json(const struct vw_benchmark *benchmark) {
    json_t *object = json_object();
    for (uint32_t i = 0; i < benchmark->method_count; i++)
        vw_json_set(&object, benchmark->methods[i].name, vw_json_real(benchmark->methods[i].trainings));
    return object;
}

static json_t *seconds_to_json(const struct vw_benchmark *benchmark) {
    json_t *object = json_object();
    for (uint32_t i = 0; i < benchmark->method_count; i++)
        vw_json_set(&object, benchmark->methods[i].name, vw_json_real(benchmark->methods[i].seconds));
    return object;
}

enum vw_status vw_benchmark_print(const struct vw_benchmark *benchmark, bool json) {
    if (json)
        return vw_json_print(json_pack(
            "{s:s, s:I, s:I, s:I, s:I, s:I, s:s, s:I, s:s, s:o, s:o, s:o, s:o}", "scene",
            benchmark->params->common.scene.path, "photos", (json_int_t)benchmark->photo_count, "halves",
            (json_int_t)benchmark->half_count, "subsets_of_all_sizes", (json_int_t)benchmark->size_count,
            "valued_seeds", (json_int_t)benchmark->params->common.seeds, "retraining_seeds",
            (json_int_t)benchmark->params->retraining_seeds, "equal", vw_equal_name(benchmark->params->equal),
            "truth_epochs", (json_int_t)benchmark->truth_epochs, "table", benchmark->csv_path, "seconds_per_training",
            vw_json_real(benchmark->training_seconds), "trainings", costs_to_json(benchmark), "seconds",
            seconds_to_json(benchmark), "metrics", metrics_to_json(&benchmark->metrics)));
    print_text(benchmark);
    return VW_OK;
}
