#include "cli/output/answer.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/csv.h"
#include "base/inside.h"
#include "base/memory.h"
#include "base/text.h"
#include "cli/output/print.h"
#include "experiment/prices.h"
#include "report/told.h"
#include "run/out_files.h"
#include "run/plan/accuracy_levels.h"
#include "value/halves.h"

enum { ADVICE_BYTES_MOST = 64 << 20, NAMES_SHOWN = 8 };
#define WORTH_MORE_TIME 1.5 // times as long: a finer training is named from here on

// A line of the answer, in this order.
static const struct line {
    enum vw_told_advice advice;
    const char *label;
    bool names; // names photos; a count says as much of the others
} lines[] = {{VW_TOLD_KEEP, "keep", true},
             {VW_TOLD_LOOK, "look at", true},
             {VW_TOLD_DROP, "leave out", true},
             {VW_TOLD_UNCLEAR, "cannot tell", false}};

// ---- advice.csv ----------------------------------------------------------------------------------------------------

// A photo with its advice; texts are those of the table.
struct advised {
    const char *name, *reason;
    enum vw_told_advice advice;
    double score; // NaN: none
};

struct advice_table {
    struct vw_csv csv;
    struct advised *photos; // owned
    size_t count, capacity;
    size_t folder_length; // length of what all names begin with
};

static enum vw_told_advice advice_of(const char *word) {
    enum vw_told_advice advice = VW_TOLD_KEEP;
    while (advice < VW_TOLD_ADVICE_COUNT && strcmp(vw_told_advice_name(advice), word) != 0) advice++;
    return advice < VW_TOLD_ADVICE_COUNT ? advice : VW_TOLD_NONE;
}

static enum vw_status add(struct advice_table *table) {
    char *const *fields = table->csv.fields;
    if (table->csv.field_count < 4 || !advice_of(fields[1])) return VW_OK; // the header
    enum vw_status status = vw_grow((void **)&table->photos, &table->capacity, table->count + 1, sizeof *table->photos);
    if (status) return status;
    table->photos[table->count++] = (struct advised){.name = fields[0],
                                                     .reason = fields[2],
                                                     .advice = advice_of(fields[1]),
                                                     .score = *fields[3] ? strtod(fields[3], NULL) : NAN};
    return VW_OK;
}

// Reads what the report and the table say, so that the terminal says the same.
static enum vw_status read_advice(const char *out, struct advice_table *table) {
    void *text = NULL;
    size_t size_bytes = 0;
    bool found = true;
    if (!vw_file_exists_inside(out, VW_ADVICE_FILE)) return VW_OK; // a run without scores
    enum vw_status status = vw_file_read_inside(out, VW_ADVICE_FILE, ADVICE_BYTES_MOST, &text, &size_bytes);
    if (!status) status = vw_csv_take(VW_ADVICE_FILE, text, size_bytes, &table->csv);
    while (!status && found) {
        status = vw_csv_next(&table->csv, &found);
        if (!status && found) status = add(table);
    }
    return status;
}

static void free_advice(struct advice_table *table) {
    vw_csv_close(&table->csv);
    free(table->photos);
}

// ---- Text ----------------------------------------------------------------------------------------------------------

// Compares by advice and reason; then the highest scores of photos to keep come first, of others the lowest, and photos
// without a score last.
static int compare(const void *left, const void *right) {
    const struct advised *a = left, *b = right;
    if (a->advice != b->advice) return a->advice < b->advice ? -1 : 1;
    int reasons = strcmp(a->reason, b->reason), scores = (a->score > b->score) - (a->score < b->score);
    if (reasons) return reasons;
    if (isnan(a->score) != isnan(b->score)) return isnan(a->score) ? 1 : -1;
    if (scores) return a->advice == VW_TOLD_KEEP ? -scores : scores;
    return strcmp(a->name, b->name);
}

static size_t shared_folder(const struct advice_table *table) {
    size_t length = table->count ? strlen(table->photos[0].name) : 0;
    for (size_t i = 0; i < table->count; i++)
        length = vw_text_shared_folder(table->photos[0].name, length, table->photos[i].name);
    return length;
}

// Prints the photos from `first` on that have its advice and reason; returns how many.
static size_t print_group(const struct advice_table *table, size_t first, bool names) {
    const struct advised *photos = table->photos;
    size_t end = first;
    while (end < table->count && photos[end].advice == photos[first].advice &&
           strcmp(photos[end].reason, photos[first].reason) == 0)
        end++;
    if (!names) vw_print("%zu %s", end - first, photos[first].reason);
    for (size_t i = first; names && i < end && i < first + NAMES_SHOWN; i++)
        vw_print("%s%s", i > first ? ", " : "", photos[i].name + table->folder_length);
    if (names && end - first > NAMES_SHOWN) vw_print(" and %zu more", end - first - NAMES_SHOWN);
    if (names) vw_print(" (%s)", photos[first].reason);
    return end - first;
}

static void print_line(const struct advice_table *table, const struct line *line) {
    size_t first = 0, count = 0;
    while (first < table->count && table->photos[first].advice != line->advice) first++;
    while (first + count < table->count && table->photos[first + count].advice == line->advice) count++;
    if (!count) return;
    vw_print("%-16s%zu: ", line->label, count);
    for (size_t i = first; i < first + count;) {
        if (i > first) vw_print("; ");
        i += print_group(table, i, line->names);
    }
    vw_print("\n");
}

// Prints whether the reconstruction is good enough to rank photos by.
static void print_reconstruction(const struct vw_reconstruction *seen) {
    char ssim[32] = "";
    if (isfinite(seen->ssim)) snprintf(ssim, sizeof ssim, " and SSIM %.2f", seen->ssim);
    vw_print("reconstruction  %s: %.1f dB%s in the middle of %u validation photo%s; their mean colour has %.1f dB, "
             "the nearest train photo %.1f\n",
             vw_verdict_word(vw_verdict_judge(seen)), seen->psnr_db, ssim, seen->view_count,
             vw_plural(seen->view_count), seen->mean_colour_db, seen->nearest_photo_db);
}

// Returns the trainings of a verified selection, at most; 0: it is not possible.
static uint32_t count_trainings(const struct vw_answer *answer) {
    uint32_t command = 0;
    if (answer->reconstruction.view_count < VW_HALVES) return 0;
    while (strcmp(vw_priced_commands[command].name, "select") != 0) command++;
    return vw_priced_commands[command].trainings;
}

static void print_cost(uint32_t trainings, double seconds) {
    char time[VW_DURATION_BYTES];
    vw_text_duration(seconds, time);
    vw_print("   (");
    if (trainings) vw_print("up to %u trainings%s", trainings, isfinite(seconds) ? ", " : "");
    if (isfinite(seconds)) vw_print("about %s", time);
    vw_print(")\n");
}

// Prints the command that helps most now, with its cost.
static void print_next(const struct vw_answer *answer, bool scored) {
    bool coarse = vw_verdict_judge(&answer->reconstruction) == VW_VERDICT_TOO_COARSE;
    bool finer = coarse && answer->times_at_most > WORTH_MORE_TIME && isfinite(answer->training_s);
    uint32_t trainings = coarse || !scored ? 0 : count_trainings(answer);
    if (finer) {
        vw_print("next            this command with --accuracy reference and another --out");
        print_cost(0, answer->times_at_most * answer->training_s);
    } else if (trainings) {
        vw_print("next            viewworth select");
        vw_print_shell_path(answer->out);
        vw_print(" --to LIST");
        print_cost(trainings, trainings * answer->training_s * answer->unvalidated_share);
    } else if (answer->has_report) {
        vw_print("next            open");
        vw_print_shell_path(answer->out);
        vw_print("/report.html in a browser\n");
    }
}

void vw_answer_begin(const struct vw_run *run, const char *out, struct vw_answer *answer) {
    const struct vw_run_results *results = vw_run_get_results(run);
    *answer = (struct vw_answer){.out = out,
                                 .reconstruction = results->outputs.reconstruction,
                                 .times_at_most = vw_accuracy_most_against(results->config),
                                 .unvalidated_share = vw_accuracy_unvalidated_share(results->config),
                                 .has_report = results->outputs.report_path != NULL,
                                 .training_s = NAN};
}

enum vw_status vw_answer_print(const struct vw_answer *answer) {
    struct advice_table table = {0};
    enum vw_status status = read_advice(answer->out, &table);
    if (!status && vw_verdict_judge(&answer->reconstruction) != VW_VERDICT_UNKNOWN)
        print_reconstruction(&answer->reconstruction);
    table.folder_length = shared_folder(&table);
    if (table.count) qsort(table.photos, table.count, sizeof *table.photos, compare);
    for (size_t i = 0; !status && i < VW_ARRAY_COUNT(lines); i++) print_line(&table, &lines[i]);
    if (!status) print_next(answer, table.count > 0);
    free_advice(&table);
    return status;
}

// ---- JSON ----------------------------------------------------------------------------------------------------------

json_t *vw_answer_advice_to_json(const char *out) {
    struct advice_table table = {0};
    uint32_t counts[VW_TOLD_ADVICE_COUNT] = {0};
    json_t *photos = read_advice(out, &table) ? NULL : json_array();
    json_t *of_words = json_object();
    for (size_t i = 0; i < table.count; i++) {
        const struct advised *photo = &table.photos[i];
        counts[photo->advice]++;
        vw_json_append(&photos, json_pack("{s:s, s:s, s:s}", "name", photo->name, "advice",
                                          vw_told_advice_name(photo->advice), "reason", photo->reason));
    }
    for (enum vw_told_advice word = VW_TOLD_KEEP; word < VW_TOLD_ADVICE_COUNT; word++)
        vw_json_set(&of_words, vw_told_advice_name(word), json_integer(counts[word]));
    free_advice(&table);
    return json_pack("{s:o, s:o}", "counts", of_words, "photos", photos);
}
