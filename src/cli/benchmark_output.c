#include "cli/benchmark_output.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "cli/json_output.h"
#include "viewworth/csv.h"

static void print_csv(FILE *stream, const void *context) {
    const struct vw_benchmark_output *output = context;
    fputs("scene,judgement,method,value,low,high,count\n", stream);
    for (size_t i = 0; i < output->judgements->count; i++) {
        const struct vw_judgement *row = &output->judgements->rows[i];
        vw_csv_write_text(stream, output->scene);
        fputc(',', stream);
        vw_csv_write_text(stream, row->judgement);
        fputc(',', stream);
        vw_csv_write_text(stream, row->method);
        const double values[] = {row->value, row->low, row->high};
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

// ---- The table ------------------------------------------------------------------------------------------------------------

// A column of the table: a judgement, shown with its interval where there is one.
struct column {
    const char *title, *group, *name;
    int digits;
    bool interval;
};

static const struct column columns[] = {
    {"AUC all", "auc", "spoiled", 2, false},           {"AUC harmful", "auc", "harmful", 2, false},
    {"r seeds", "seed_pearson", "all", 2, false},      {"r clean", "seed_pearson", "clean", 2, false},
    {"LDS val (95 %)", "lds", "val_psnr", 2, true},    {"LDS test (95 %)", "lds", "test_psnr", 2, true},
    {"less dv_psnr", "lds_gain", "val_psnr", 2, true}, {"LOO rho", "leave_one_out", "spearman", 2, false},
    {"-20 % low, dB", "removal_low", "20", 2, false},  {"-20 % high", "removal_high", "20", 2, false},
};
enum { COLUMN_COUNT = sizeof columns / sizeof columns[0], CELL_BYTES = 40, NAME_WIDTH = 22 };

static bool is_used(const struct vw_judgements *judgements, const struct column *column) {
    char judgement[VW_JUDGEMENT_BYTES];
    snprintf(judgement, sizeof judgement, "%s/%s", column->group, column->name);
    for (size_t i = 0; i < judgements->count; i++)
        if (!strcmp(judgements->rows[i].judgement, judgement) && isfinite(judgements->rows[i].value)) return true;
    return false;
}

static int width_of(const struct column *column) {
    int title = (int)strlen(column->title), cell = column->interval ? 19 : 6;
    return title > cell ? title : cell;
}

static void format_cell(const struct vw_judgement *row, const struct column *column, char text[CELL_BYTES]) {
    snprintf(text, CELL_BYTES, "-");
    if (!row || !isfinite(row->value)) return;
    bool interval = column->interval && isfinite(row->low);
    if (interval) snprintf(text, CELL_BYTES, "%.2f (%.2f to %.2f)", row->value, row->low, row->high);
    else snprintf(text, CELL_BYTES, "%.*f", column->digits, row->value);
}

static void print_header(const struct vw_benchmark_output *output) {
    printf("%-*s", NAME_WIDTH, "method");
    for (int c = 0; c < COLUMN_COUNT; c++)
        if (is_used(output->judgements, &columns[c])) printf("  %*s", width_of(&columns[c]), columns[c].title);
    printf("  trainings  CPU s\n");
}

static void print_method(const struct vw_benchmark_output *output, const char *method, int64_t trainings) {
    printf("%-*s", NAME_WIDTH, method);
    for (int c = 0; c < COLUMN_COUNT; c++) {
        char text[CELL_BYTES];
        if (!is_used(output->judgements, &columns[c])) continue;
        format_cell(vw_judgements_find(output->judgements, columns[c].group, columns[c].name, method), &columns[c], text);
        printf("  %*s", width_of(&columns[c]), text);
    }
    if (trainings < 0) putchar('\n');
    else printf("  %9lld %6.3g\n", (long long)trainings, trainings ? (double)trainings * output->training_seconds : 0.0);
}

// Rows that are about the scene, not about a method: "harm/blur  0.31 (0.12 to 0.50)".
static void print_scene_rows(const struct vw_judgements *judgements) {
    for (size_t i = 0; i < judgements->count; i++) {
        const struct vw_judgement *row = &judgements->rows[i];
        if (!strncmp(row->judgement, "harm/", 5))
            printf("a photo with %s adds %.2f dB (%.2f to %.2f) less than a clean one, of validation PSNR (%u photos)\n",
                   row->judgement + 5, row->value, row->low, row->high, row->count);
        else if (!strncmp(row->judgement, "agreement/", 10))
            printf("two trainings on the same photos agree in %s by rho = %.2f over %u subsets\n", row->judgement + 10, row->value,
                   row->count);
    }
}

void vw_benchmark_print(const struct vw_benchmark_output *output) {
    const struct vw_contestants *contestants = output->contestants;
    printf("%s: %u photos, %u subsets of %u, each trained on twice\n", output->scene, contestants->contest.photo_count,
           output->subset_count, contestants->contest.photo_count / 2);
    print_scene_rows(output->judgements);
    putchar('\n');
    print_header(output);
    for (uint32_t i = 0; i < contestants->contest.contestant_count; i++)
        print_method(output, contestants->list[i].name, contestants->trainings[i]);
    print_method(output, "noise ceiling", -1);
    print_method(output, "chance", -1);
    printf("\ntable    %s\n", output->csv_path);
}

// ---- JSON -----------------------------------------------------------------------------------------------------------------

static json_t *judgements_to_json(const struct vw_judgements *judgements) {
    json_t *array = json_array();
    for (size_t i = 0; array && i < judgements->count; i++) {
        const struct vw_judgement *row = &judgements->rows[i];
        json_t *entry = json_pack("{s:s, s:s, s:o, s:o, s:o, s:I}", "judgement", row->judgement, "method", row->method, "value",
                                  vw_json_real(row->value), "low", vw_json_real(row->low), "high", vw_json_real(row->high), "count",
                                  (json_int_t)row->count);
        if (!json_array_append_new(array, entry)) continue;
        json_decref(array);
        array = NULL;
    }
    return array;
}

static json_t *costs_to_json(const struct vw_benchmark_output *output) {
    json_t *object = json_object();
    for (uint32_t i = 0; object && i < output->contestants->contest.contestant_count; i++)
        if (json_object_set_new(object, output->contestants->list[i].name, json_integer(output->contestants->trainings[i]))) {
            json_decref(object);
            object = NULL;
        }
    return object;
}

enum vw_status vw_benchmark_print_json(const struct vw_benchmark_output *output) {
    const struct vw_contest *contest = &output->contestants->contest;
    return vw_json_print(json_pack("{s:s, s:I, s:I, s:s, s:o, s:o, s:o}", "scene", output->scene, "photos",
                                   (json_int_t)contest->photo_count, "subsets", (json_int_t)output->subset_count, "table", output->csv_path,
                                   "seconds_per_training", vw_json_real(output->training_seconds), "trainings", costs_to_json(output),
                                   "judgements", judgements_to_json(output->judgements)));
}
