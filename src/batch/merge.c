#include "batch/merge.h"

#include <fts.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/csv.h"
#include "base/file.h"
#include "base/memory.h"
#include "base/text.h"
#include "base/text_stream.h"
#include "ledger/merge.h"
#include "report/tables.h"
#include "run/out_folder.h"
#include "viewworth/log.h"
#include "viewworth/report.h"

// ---- Which runs ---------------------------------------------------------------------------------------------------

enum { DEPTH_MAX = 4, RUNS_MAX = 1 << 14 }; // levels of folders below one; number of runs

enum vw_status vw_batch_rows_add(struct vw_batch_rows *rows, const char *job, const char *folder) {
    if (rows->count == RUNS_MAX) return vw_fail(VW_ERROR_USAGE, "%s: more than %d runs; merge fewer", folder, RUNS_MAX);
    if (!vw_text_is_clean(job))
        return vw_fail(VW_ERROR_INPUT, "%s: its name is not UTF-8 or has control characters; rename it", folder);
    enum vw_status status = vw_grow((void **)&rows->rows, &rows->capacity, (size_t)rows->count + 1, sizeof *rows->rows);
    if (status) return status;
    struct vw_batch_row *row = &rows->rows[rows->count++];
    *row = (struct vw_batch_row){
        .job = vw_copy_text(job), .folder = vw_copy_text(folder), .exit_code = -1, .seconds = NAN};
    return row->job && row->folder ? VW_OK : VW_ERROR_MEMORY;
}

static int by_name(const FTSENT **left, const FTSENT **right) { return strcmp((*left)->fts_name, (*right)->fts_name); }

// Adds the run of a folder, if it has one. Its job is `path` without `root`, or the last name of the root itself.
static enum vw_status add_found(struct vw_batch_rows *rows, const char *root, const char *path, bool *found) {
    char *ledger = vw_path_join(path, "ledger.db"), *resolved = realpath(path, NULL); // also for "." and "out/"
    const char *job = path + strlen(root);
    enum vw_status status = ledger && resolved ? VW_OK : VW_ERROR_MEMORY;
    *found = !status && vw_file_exists(ledger);
    if (*found) status = vw_batch_rows_add(rows, *job ? job + (*job == '/') : strrchr(resolved, '/') + 1, path);
    if (*found && !status) rows->rows[rows->count - 1].state = VW_JOB_DONE;
    free(ledger);
    free(resolved);
    return status;
}

enum vw_status vw_batch_rows_find(struct vw_batch_rows *rows, const char *folder) {
    uint32_t before = rows->count;
    enum vw_status status = VW_OK;
    FTS *tree = fts_open((char *const[]){(char *)folder, NULL}, FTS_PHYSICAL | FTS_COMFOLLOW | FTS_NOCHDIR, by_name);
    for (FTSENT *entry; tree && !status && (entry = fts_read(tree));) {
        bool found = false;
        if (entry->fts_info == FTS_DNR || entry->fts_info == FTS_NS)
            status = vw_fail(VW_ERROR_INPUT, "%s: cannot be read: %s; make it readable, or name the folders beside it",
                             entry->fts_path, strerror(entry->fts_errno));
        bool looks = entry->fts_level <= DEPTH_MAX && (!entry->fts_level || *entry->fts_name != '.');
        if (!status && entry->fts_info == FTS_D && looks) status = add_found(rows, folder, entry->fts_path, &found);
        if (found || !looks) fts_set(tree, entry, FTS_SKIP);
    }
    if (tree) fts_close(tree);
    if (status || rows->count > before) return status;
    return vw_fail(VW_ERROR_INPUT, "%s: no run lies in it; name a folder of viewworth value or batch", folder);
}

void vw_batch_rows_free(struct vw_batch_rows *rows) {
    for (uint32_t i = 0; i < rows->count; i++) {
        free(rows->rows[i].job);
        free(rows->rows[i].folder);
        free(rows->rows[i].message);
        if (rows->rows[i].run) free(rows->rows[i].run->scene), free(rows->rows[i].run->report);
        free(rows->rows[i].run);
    }
    free(rows->rows);
    *rows = (struct vw_batch_rows){0};
}

// ---- One run ------------------------------------------------------------------------------------------------------

static enum vw_status read_steps(struct vw_ledger *ledger, struct vw_merged_run *run) {
    struct vw_step_record *records = NULL;
    uint64_t count = 0;
    enum vw_status status = vw_ledger_get_steps(ledger, &records, &count);
    for (uint64_t i = 0; !status && i < count; i++) {
        if (isnan(run->first_psnr)) run->first_psnr = records[i].val_psnr;
        if (!isnan(records[i].val_psnr)) run->val_psnr = records[i].val_psnr;
        run->steps = records[i].step;
        if (records[i].step) run->epochs = records[i].epoch + 1;
    }
    free(records);
    return status;
}

// Returns the path of a run's report from OUT, owned by the caller; NULL for a run elsewhere.
static char *name_report(const char *out, const char *folder) {
    size_t length = strlen(out);
    while (length > 1 && out[length - 1] == '/') length--;
    if (strncmp(folder, out, length) != 0 || folder[length] != '/') return NULL;
    return vw_path_join(folder + length + strspn(folder + length, "/"), "report.html");
}

static enum vw_status describe(struct vw_ledger *ledger, const char *out, struct vw_batch_row *row) {
    struct vw_ledger_run run;
    const struct vw_ledger_image *images = NULL;
    uint32_t image_count = 0;
    enum vw_status status = vw_ledger_get_run(ledger, &run);
    if (!status) status = vw_ledger_get_images(ledger, &images, &image_count);
    if (status) return status;
    row->run = vw_allocate(1, sizeof *row->run);
    if (!row->run) return VW_ERROR_MEMORY;
    *row->run = (struct vw_merged_run){.scene = vw_copy_text(run.scene_path),
                                       .report = name_report(out, row->folder),
                                       .seed = (uint64_t)run.seed,
                                       .first_psnr = NAN,
                                       .val_psnr = NAN};
    for (uint32_t i = 0; i < image_count; i++) row->run->photos += !strcmp(images[i].split, "train");
    return row->run->scene ? read_steps(ledger, row->run) : VW_ERROR_MEMORY;
}

// Prints the fields that the scores of a run begin with. Owned by the caller.
static enum vw_status print_columns(const struct vw_batch_row *row, char **columns) {
    struct vw_text_stream text;
    size_t size_bytes = 0;
    const char *begin = strchr(row->job, '/'), *end = strrchr(row->job, '/'); // around the config, if it has one
    char *config = vw_format_text("%.*s", begin < end ? (int)(end - begin - 1) : 0, begin ? begin + 1 : "");
    FILE *stream = vw_text_stream_open(&text);
    if (stream) vw_csv_print(stream, "t,t,t,", row->job, config, row->run->scene);
    if (stream) fprintf(stream, "%" PRIu64 ",", row->run->seed);
    enum vw_status status = vw_text_stream_close(&text, row->job, columns, &size_bytes);
    if (!config) status = VW_ERROR_MEMORY;
    free(config);
    return status;
}

static enum vw_status print_scores(struct vw_ledger *ledger, const struct vw_batch_row *row, FILE *stream) {
    struct vw_ledger_score *scores = NULL;
    const struct vw_ledger_image *images = NULL;
    uint32_t score_count = 0, image_count = 0;
    char *columns = NULL;
    enum vw_status status = vw_ledger_get_scores(ledger, &scores, &score_count);
    if (!status) status = vw_ledger_get_images(ledger, &images, &image_count);
    if (!status) status = print_columns(row, &columns);
    if (!status)
        status = vw_report_print_csv_rows(stream, row->folder, columns, scores, score_count, images, image_count);
    free(columns);
    free(scores);
    return status;
}

static enum vw_status add_run(struct vw_merged_ledger *merged, const char *out, struct vw_batch_row *row,
                              FILE *stream) {
    struct vw_ledger *ledger = NULL;
    char *path = vw_path_join(row->folder, "ledger.db");
    enum vw_status status = path ? vw_ledger_open(path, &ledger) : VW_ERROR_MEMORY;
    if (!status) status = vw_merged_add(merged, row->job, ledger);
    if (!status) status = describe(ledger, out, row);
    if (!status) status = print_scores(ledger, row, stream);
    vw_ledger_close(&ledger);
    free(path);
    return status;
}

// ---- All of them --------------------------------------------------------------------------------------------------

static enum vw_status check_jobs(const struct vw_batch_rows *rows) {
    for (uint32_t i = 0; i < rows->count; i++)
        for (uint32_t k = 0; k < i; k++)
            if (!strcmp(rows->rows[i].job, rows->rows[k].job))
                return vw_fail(VW_ERROR_USAGE, "%s and %s: both are the job %s; name the folder above both",
                               rows->rows[k].folder, rows->rows[i].folder, rows->rows[i].job);
    return VW_OK;
}

struct vw_rows vw_batch_rows_table(struct vw_batch_rows *rows) {
#define OF_RUN(name, kind, member) VW_CELL_VIA(name, struct vw_batch_row, run, kind, struct vw_merged_run, member)
    static const struct vw_column columns[] = {
        {VW_CELL("job", struct vw_batch_row, TEXT, job), .title = "job"},
        {VW_CELL("state", struct vw_batch_row, TEXT, state_name), .title = "state"},
        {VW_CELL("seconds", struct vw_batch_row, REAL_OR_NULL, seconds), .title = "seconds", .digits = 1},
        {OF_RUN("photos", COUNT, photos), .title = "photos"},
        {OF_RUN("steps", COUNT64, steps), .title = "steps"},
        {OF_RUN("epochs", COUNT, epochs)},
        {OF_RUN("first_psnr", REAL_OR_NULL, first_psnr), .title = "first PSNR", .digits = 2},
        {OF_RUN("val_psnr", REAL_OR_NULL, val_psnr), .title = "PSNR, dB", .digits = 2},
        {OF_RUN("scene", TEXT, scene), .left_out = VW_NOT_IN_CSV},
        {OF_RUN("seed", COUNT64, seed), .left_out = VW_NOT_IN_CSV},
        {OF_RUN("report", TEXT_OR_NULL, report)},
        {VW_CELL("message", struct vw_batch_row, TEXT_OR_NULL, message), .title = "message"},
    };
    static const char *const names[] = {"waiting", "running", "done", "failed", "stopped"};
    for (uint32_t i = 0; i < rows->count; i++) rows->rows[i].state_name = names[rows->rows[i].state];
    return VW_ROWS(columns, rows->rows, rows->count);
}

static enum vw_status merge(const char *path, const char *out, struct vw_batch_rows *rows, FILE *scores) {
    struct vw_merged_ledger *merged = NULL;
    enum vw_status status = vw_merged_create(path, &merged);
    fputs("job,config,scene,seed,", scores);
    vw_report_print_csv_header(scores);
    for (uint32_t i = 0; !status && i < rows->count; i++) {
        if (rows->rows[i].state != VW_JOB_DONE) continue;
        status = add_run(merged, out, &rows->rows[i], scores);
        rows->merged++;
    }
    if (!status && rows->merged) status = vw_merged_finish(merged);
    vw_merged_close(&merged);
    return status;
}

enum vw_status vw_batch_rows_write(const char *out, struct vw_batch_rows *rows) {
    const struct vw_rows table = vw_batch_rows_table(rows);
    char *path = vw_path_join(out, "summary.csv");
    enum vw_status status = path ? vw_rows_write_csv(path, &table) : VW_ERROR_MEMORY;
    free(path);
    return status;
}

static enum vw_status write_all(const char *ledger, const char *scores, const char *out, struct vw_batch_rows *rows) {
    struct vw_text_stream text;
    char *csv = NULL;
    size_t size_bytes = 0;
    FILE *stream = vw_text_stream_open(&text);
    enum vw_status status = stream ? merge(ledger, out, rows, stream) : VW_ERROR_MEMORY;
    struct vw_saved_error why = vw_error_save();
    enum vw_status closed = vw_text_stream_close(&text, scores, &csv, &size_bytes);
    if (status) vw_error_restore(&why);
    else status = closed;
    if (!status && rows->merged) status = vw_file_write(scores, csv, size_bytes);
    if (!status) status = vw_batch_rows_write(out, rows);
    free(csv);
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

enum vw_status vw_batch_rows_merge(const char *out, struct vw_batch_rows *rows) {
    char *ledger = vw_path_join(out, "merged.db"), *scores = vw_path_join(out, "scores.csv");
    enum vw_status status = ledger && scores ? check_jobs(rows) : VW_ERROR_MEMORY;
    if (!status) status = write_all(ledger, scores, out, rows);
    free(ledger);
    free(scores);
    return status;
}

void vw_batch_rows_report(const char *out, struct vw_batch_rows *rows) {
    const char *folders[1 + VW_MERGE_REPORTED_MAX] = {out};
    uint32_t count = 0;
    char *path = vw_path_join(out, "report.html");
    for (uint32_t i = 0; i < rows->count && count < VW_MERGE_REPORTED_MAX; i++)
        if (rows->rows[i].run) folders[++count] = rows->rows[i].folder;
    const struct vw_report_params params = {.options.no_thumbnails = true};
    enum vw_status status = path ? vw_report_write(folders, count + 1, path, &params) : VW_ERROR_MEMORY;
    if (status) vw_log_warning("no report: %s", vw_error_message());
    else rows->reported = count;
    free(path);
}
