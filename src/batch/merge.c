#include "batch/merge.h"

#include <dirent.h>
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/csv.h"
#include "base/file.h"
#include "base/inside.h"
#include "base/memory.h"
#include "base/text.h"
#include "base/text_stream.h"
#include "ledger/merge.h"
#include "report/page.h"
#include "run/out_folder.h"
#include "viewworth/ledger.h"
#include "viewworth/log.h"
#include "viewworth/report.h"

// ---- Which runs ---------------------------------------------------------------------------------------------------

enum { DEPTH_MAX = 4, RUNS_MAX = 1 << 16 }; // levels of folders below one; number of runs

enum vw_status vw_merged_runs_add(struct vw_merged_runs *runs, const char *job, const char *folder) {
    if (runs->count == RUNS_MAX) return vw_fail(VW_ERROR_USAGE, "%s: more than %d runs; merge fewer", folder, RUNS_MAX);
    if (!vw_text_is_clean(job))
        return vw_fail(VW_ERROR_INPUT, "%s: its name is not UTF-8 or has control characters; rename it", folder);
    enum vw_status status = vw_grow((void **)&runs->runs, &runs->capacity, (size_t)runs->count + 1, sizeof *runs->runs);
    if (status) return status;
    struct vw_merged_run *run = &runs->runs[runs->count++];
    *run = (struct vw_merged_run){.job = vw_copy_text(job), .folder = vw_copy_text(folder)};
    return run->job && run->folder ? VW_OK : VW_ERROR_MEMORY;
}

static int is_visible(const struct dirent *entry) { return entry->d_name[0] != '.'; }

static int by_name(const struct dirent **left, const struct dirent **right) {
    return strcmp((*left)->d_name, (*right)->d_name);
}

// Adds the runs below a folder. `job` is the path from the folder that was named; "" for that folder.
static enum vw_status find_runs(struct vw_merged_runs *runs, const char *folder, const char *job, int depth) {
    struct dirent **entries = NULL;
    if (*job && vw_file_exists_inside(folder, "ledger.db")) return vw_merged_runs_add(runs, job, folder);
    int count = depth < DEPTH_MAX ? scandir(folder, &entries, is_visible, by_name) : 0;
    enum vw_status status = VW_OK;
    if (count < 0)
        return vw_fail(VW_ERROR_INPUT, "%s: cannot be read: %s; make it readable, or name the folders beside it",
                       folder, strerror(errno));
    for (int i = 0; i < count; i++) {
        const char *name = entries[i]->d_name;
        char *below = vw_path_join(folder, name), *longer = vw_format_text("%s%s%s", job, *job ? "/" : "", name);
        if (!below || !longer) status = VW_ERROR_MEMORY;
        if (!status && vw_folder_exists(below) && !vw_folder_check_inside(folder, name))
            status = find_runs(runs, below, longer, depth + 1);
        free(below);
        free(longer);
        free(entries[i]);
    }
    free(entries);
    return status;
}

enum vw_status vw_merged_runs_find(struct vw_merged_runs *runs, const char *folder) {
    uint32_t before = runs->count;
    char *resolved = realpath(folder, NULL); // its last part is a name, also for "." and "out/"
    const char *slash = resolved ? strrchr(resolved, '/') : NULL;
    enum vw_status status = VW_OK;
    if (slash && vw_file_exists_inside(folder, "ledger.db")) status = vw_merged_runs_add(runs, slash + 1, folder);
    else status = find_runs(runs, folder, "", 0);
    free(resolved);
    if (!status && runs->count == before)
        status = vw_fail(VW_ERROR_INPUT, "%s: no run lies in it; name a folder of viewworth value or batch", folder);
    return status;
}

void vw_merged_runs_free(struct vw_merged_runs *runs) {
    for (uint32_t i = 0; i < runs->count; i++) {
        free(runs->runs[i].job);
        free(runs->runs[i].folder);
        free(runs->runs[i].scene);
    }
    free(runs->runs);
    *runs = (struct vw_merged_runs){0};
}

static int compare_jobs(const void *left, const void *right) {
    const struct vw_merged_run *const *a = left, *const *b = right;
    return strcmp((*a)->job, (*b)->job);
}

static enum vw_status check_jobs(const struct vw_merged_runs *runs) {
    const struct vw_merged_run **sorted = vw_allocate(runs->count, sizeof *sorted);
    enum vw_status status = sorted ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t i = 0; sorted && i < runs->count; i++) sorted[i] = &runs->runs[i];
    if (sorted) qsort(sorted, runs->count, sizeof(struct vw_merged_run *), compare_jobs);
    for (uint32_t i = 1; !status && i < runs->count; i++)
        if (!strcmp(sorted[i - 1]->job, sorted[i]->job))
            status = vw_fail(VW_ERROR_USAGE, "%s and %s: both are the job %s; name the folder above both",
                             sorted[i - 1]->folder, sorted[i]->folder, sorted[i]->job);
    free(sorted);
    return status;
}

// ---- One run ------------------------------------------------------------------------------------------------------

static enum vw_status read_steps(struct vw_ledger *ledger, struct vw_merged_run *run) {
    struct vw_step_record *records = NULL;
    uint64_t count = 0;
    enum vw_status status = vw_ledger_get_steps(ledger, &records, &count);
    run->first_psnr = run->val_psnr = NAN;
    for (uint64_t i = 0; !status && i < count; i++) {
        if (isnan(run->first_psnr)) run->first_psnr = records[i].val_psnr;
        if (!isnan(records[i].val_psnr)) run->val_psnr = records[i].val_psnr;
        run->steps = records[i].step;
        if (records[i].step) run->epochs = records[i].epoch + 1;
    }
    free(records);
    return status;
}

// Prints the fields that the rows of a run begin with. Owned by the caller.
static enum vw_status print_columns(const struct vw_merged_run *run, char **columns) {
    struct vw_text_stream text;
    size_t size_bytes = 0;
    const char *begin = strchr(run->job, '/'), *end = strrchr(run->job, '/'); // around the config, if it has one
    char *config = vw_format_text("%.*s", begin < end ? (int)(end - begin - 1) : 0, begin ? begin + 1 : "");
    FILE *stream = vw_text_stream_open(&text);
    if (stream) vw_csv_print(stream, "t,t,t,", run->job, config, run->scene);
    if (stream) fprintf(stream, "%" PRId64 ",", run->seed);
    enum vw_status status = vw_text_stream_close(&text, run->job, columns, &size_bytes);
    if (!status && !config) status = VW_ERROR_MEMORY;
    free(config);
    return status;
}

static enum vw_status print_scores(struct vw_ledger *ledger, const struct vw_merged_run *run, FILE *stream) {
    struct vw_ledger_score *scores = NULL;
    const struct vw_ledger_image *images = NULL;
    uint32_t score_count = 0, image_count = 0;
    char *columns = NULL;
    enum vw_status status = vw_ledger_get_scores(ledger, &scores, &score_count);
    if (!status) status = vw_ledger_get_images(ledger, &images, &image_count);
    if (!status) status = print_columns(run, &columns);
    if (!status)
        status = vw_report_print_csv_rows(stream, run->folder, columns, scores, score_count, images, image_count);
    free(columns);
    free(scores);
    return status;
}

static enum vw_status describe(struct vw_ledger *ledger, struct vw_merged_run *run) {
    struct vw_ledger_run row;
    const struct vw_ledger_image *images = NULL;
    uint32_t image_count = 0;
    enum vw_status status = vw_ledger_get_run(ledger, &row);
    if (!status) status = vw_ledger_get_images(ledger, &images, &image_count);
    if (status) return status;
    run->photos = 0;
    for (uint32_t i = 0; i < image_count; i++) run->photos += !strcmp(images[i].split, "train");
    run->seed = row.seed;
    run->scene = vw_copy_text(row.scene_path);
    snprintf(run->status, sizeof run->status, "%s", row.status);
    return run->scene ? read_steps(ledger, run) : VW_ERROR_MEMORY;
}

static enum vw_status add_run(struct vw_merged_ledger *merged, struct vw_merged_run *run, FILE *stream) {
    struct vw_ledger *ledger = NULL;
    char *path = vw_path_join(run->folder, "ledger.db");
    enum vw_status status = path ? vw_file_check_inside(run->folder, "ledger.db") : VW_ERROR_MEMORY;
    if (!status) status = vw_ledger_open(path, &ledger);
    if (!status) status = vw_merged_add(merged, run->job, ledger);
    if (!status) status = describe(ledger, run);
    if (!status) status = print_scores(ledger, run, stream);
    vw_ledger_close(&ledger);
    free(path);
    return status;
}

// ---- All of them --------------------------------------------------------------------------------------------------

static enum vw_status merge(const char *merged_path, const char *scores_path, struct vw_merged_runs *runs) {
    struct vw_merged_ledger *merged = NULL;
    struct vw_text_stream text;
    char *scores = NULL;
    size_t size_bytes = 0;
    FILE *stream = vw_text_stream_open(&text);
    if (stream) fprintf(stream, "job,config,scene,seed,%s", vw_report_csv_header);
    enum vw_status status = stream ? vw_merged_create(merged_path, &merged) : VW_ERROR_MEMORY;
    for (uint32_t i = 0; !status && i < runs->count; i++) status = add_run(merged, &runs->runs[i], stream);
    struct vw_saved_error why = vw_error_save();
    enum vw_status closed = vw_text_stream_close(&text, scores_path, &scores, &size_bytes);
    if (status) vw_error_restore(&why);
    else status = closed;
    if (!status) status = vw_merged_finish(merged);
    if (!status) status = vw_file_write(scores_path, scores, size_bytes);
    vw_merged_close(&merged);
    free(scores);
    return status;
}

enum vw_status vw_merge_check_out(const char *out) {
    char *ledger = vw_path_join(out, "ledger.db");
    enum vw_status status = ledger ? vw_out_check(out) : VW_ERROR_MEMORY;
    if (!status && vw_file_exists(ledger))
        status =
            vw_fail(VW_ERROR_USAGE, "--out %s: already contains a run; name another folder for results of many", out);
    free(ledger);
    return status;
}

enum vw_status vw_merge_write(const char *out, struct vw_merged_runs *runs) {
    char *merged_path = vw_path_join(out, "merged.db"), *scores_path = vw_path_join(out, "scores.csv");
    enum vw_status status = merged_path && scores_path ? check_jobs(runs) : VW_ERROR_MEMORY;
    if (!status) status = merge(merged_path, scores_path, runs);
    free(merged_path);
    free(scores_path);
    return status;
}

void vw_merge_report(const char *out, struct vw_merged_runs *runs) {
    uint32_t count = runs->count < VW_MERGE_REPORTED_MAX ? runs->count : VW_MERGE_REPORTED_MAX;
    const char **folders = vw_allocate((size_t)count + 1, sizeof *folders);
    char *path = vw_path_join(out, "report.html");
    if (folders) folders[0] = out;
    for (uint32_t i = 0; folders && i < count; i++) folders[i + 1] = runs->runs[i].folder;
    enum vw_status status = folders && path ? VW_OK : VW_ERROR_MEMORY;
    if (!status)
        status = vw_report_write(folders, count + 1, path, &(struct vw_report_params){.options.no_thumbnails = true});
    if (status) vw_log_warning("no report: %s", vw_error_message());
    else runs->reported = count;
    free(folders);
    free(path);
}

// ---- summary.csv --------------------------------------------------------------------------------------------------

struct vw_summary_row *vw_summary_of_runs(const struct vw_merged_runs *runs) {
    struct vw_summary_row *rows = vw_allocate(runs->count, sizeof *rows);
    for (uint32_t i = 0; rows && i < runs->count; i++)
        rows[i] = (struct vw_summary_row){.job = runs->runs[i].job,
                                          .state = runs->runs[i].status,
                                          .exit_code = -1,
                                          .seconds = NAN,
                                          .run = &runs->runs[i]};
    return rows;
}

struct table {
    const char *out;
    const struct vw_summary_row *rows;
    uint32_t count;
};

// Prints the path of a run's report from OUT; nothing for a run elsewhere.
static void print_report(FILE *stream, const char *out, const char *folder) {
    size_t length = strlen(out);
    while (length > 1 && out[length - 1] == '/') length--;
    if (strncmp(folder, out, length) != 0 || folder[length] != '/') return;
    vw_csv_write_text(stream, folder + length + strspn(folder + length, "/"));
    fputs("/report.html", stream);
}

static void print_run(FILE *stream, const char *out, const struct vw_merged_run *run) {
    if (!run) {
        fputs(",,,,,,", stream);
        return;
    }
    fprintf(stream, "%" PRIu32 ",%" PRIu64 ",%" PRIu32, run->photos, run->steps, run->epochs);
    vw_csv_print(stream, ",r,r,", run->first_psnr, run->val_psnr);
    print_report(stream, out, run->folder);
    fputc(',', stream);
}

static void print_table(FILE *stream, const void *context) {
    const struct table *table = context;
    fputs("job,state,exit_code,seconds,photos,steps,epochs,first_psnr,val_psnr,report,message\n", stream);
    for (uint32_t i = 0; i < table->count; i++) {
        const struct vw_summary_row *row = &table->rows[i];
        vw_csv_print(stream, "t,t,", row->job, row->state);
        if (row->exit_code >= 0) fprintf(stream, "%d", row->exit_code);
        fputc(',', stream);
        if (!isnan(row->seconds)) fprintf(stream, "%.1f", row->seconds);
        fputc(',', stream);
        print_run(stream, table->out, row->run);
        vw_csv_print(stream, "t\n", row->message);
    }
}

enum vw_status vw_summary_write(const char *out, const struct vw_summary_row *rows, uint32_t count) {
    char *path = vw_path_join(out, "summary.csv");
    enum vw_status status =
        path ? vw_csv_write_file(path, print_table, &(struct table){out, rows, count}) : VW_ERROR_MEMORY;
    free(path);
    return status;
}
