#include <inttypes.h>
#include <math.h>
#include <stdio.h>

#include "base/clock.h"
#include "cli/output/print.h"
#include "cli/output/progress.h"
#include "cli/output/results.h"
#include "viewworth/log.h"

enum { LINE_BYTES = 160 };

// ---- While it runs ------------------------------------------------------------------------------------------------

// Shows the counts on one line: "3 of 12 done, 1 failed, 2 running (fox/seed-2, ...)  214 s"
static void show_counts(struct vw_batch_display *display, const struct vw_batch *batch) {
    char line[LINE_BYTES], failed[32] = "", running[80] = "";
    uint32_t first = 0, count = batch->jobs->count;
    while (first < count && batch->results[first].state != VW_JOB_RUNNING) first++;
    if (batch->failed) snprintf(failed, sizeof failed, ", %" PRIu32 " failed", batch->failed);
    if (first < count)
        snprintf(running, sizeof running, ", %" PRIu32 " running (%.40s%s)", batch->running,
                 batch->jobs->jobs[first].name, batch->running > 1 ? ", ..." : "");
    snprintf(line, sizeof line, "%" PRIu32 " of %" PRIu32 " done%s%s  %.0f s", batch->done, count, failed, running,
             vw_now_s() - display->started_s);
    vw_progress_replace_line(&display->drawn_s, line);
}

static void show_ended(const struct vw_batch *batch, const struct vw_job *job) {
    const struct vw_job_result *result = &batch->results[job - batch->jobs->jobs];
    uint32_t count = batch->jobs->count;
    if (result->state == VW_JOB_DONE)
        vw_log_info("done %" PRIu32 " of %" PRIu32 ": %s, %.0f s", batch->done, count, job->name, result->seconds);
    else if (result->state == VW_JOB_STOPPED) vw_log_info("stopped: %s", job->name);
    else vw_log_warning("failed: %s, exit code %d: %s", job->name, result->exit_code, result->message);
}

void vw_batch_show(void *context, const struct vw_batch *batch, const struct vw_job *ended) {
    struct vw_batch_display *display = context;
    if (!(display->started_s > 0)) display->started_s = vw_now_s();
    if (ended) show_ended(batch, ended);
    else if (!display->quiet) show_counts(display, batch);
}

void vw_batch_show_end(struct vw_batch_display *display) {
    if (!display->quiet) vw_progress_replace_line(&display->drawn_s, "");
}

// ---- Text ---------------------------------------------------------------------------------------------------------

static void print_row(const struct vw_summary_row *row) {
    const struct vw_merged_run *run = row->run;
    char time[24] = "", psnr[64] = "";
    if (!isnan(row->seconds)) snprintf(time, sizeof time, "%.1f", row->seconds);
    if (run && !isnan(run->val_psnr)) snprintf(psnr, sizeof psnr, "%.2f -> %.2f", run->first_psnr, run->val_psnr);
    vw_print("%-11s %8s", row->state, time);
    if (run) vw_print(" %6" PRIu32 " %8" PRIu64 " %15s", run->photos, run->steps, psnr);
    else vw_print(" %6s %8s %15s", "", "", "");
    vw_print("  %s%s%s\n", row->job, row->message ? ": " : "", row->message ? row->message : "");
}

static void print_files(const struct vw_merged_runs *runs, const char *out) {
    vw_print("summary  %s/summary.csv\n", out);
    if (runs->count) vw_print("scores   %s/scores.csv\nledgers  %s/merged.db\n", out, out);
    if (runs->reported) vw_print("report   %s/report.html\n", out);
    if (runs->reported && runs->reported < runs->count)
        vw_print("         of the first %" PRIu32 " runs; each has its own in its folder\n", runs->reported);
}

// ---- JSON ---------------------------------------------------------------------------------------------------------

static json_t *row_to_json(const struct vw_summary_row *row) {
    const struct vw_merged_run *run = row->run;
    json_t *object = json_pack("{s:o, s:s}", "job", vw_json_string(row->job), "state", row->state);
    vw_json_set(&object, "exit_code", row->exit_code < 0 ? json_null() : json_integer(row->exit_code));
    vw_json_set(&object, "seconds", vw_json_real(row->seconds));
    vw_json_set(&object, "message", vw_json_string(row->message));
    if (!run) return object;
    vw_json_set(&object, "scene", vw_json_string(run->scene));
    vw_json_set(&object, "seed", json_integer(run->seed));
    vw_json_set(&object, "photos", json_integer(run->photos));
    vw_json_set(&object, "steps", json_integer((json_int_t)run->steps));
    vw_json_set(&object, "epochs", json_integer(run->epochs));
    vw_json_set(&object, "first_psnr", vw_json_real(run->first_psnr));
    vw_json_set(&object, "val_psnr", vw_json_real(run->val_psnr));
    return object;
}

// ---- Both ---------------------------------------------------------------------------------------------------------

static enum vw_status print_json(const struct vw_summary_row *rows, uint32_t count, const char *out) {
    json_t *jobs = json_array();
    for (uint32_t i = 0; i < count; i++) vw_json_append(&jobs, row_to_json(&rows[i]));
    return vw_json_print(json_pack("{s:o, s:o}", "out", vw_json_string(out), "jobs", jobs));
}

enum vw_status vw_summary_print(const struct vw_summary_row *rows, uint32_t count, const struct vw_merged_runs *runs,
                                const char *out, bool json) {
    if (!rows) return VW_ERROR_MEMORY;
    if (json) return print_json(rows, count, out);
    vw_print("%-11s %8s %6s %8s %15s  %s\n", "state", "seconds", "photos", "steps", "val PSNR, dB", "job");
    for (uint32_t i = 0; i < count; i++) print_row(&rows[i]);
    if (runs) print_files(runs, out);
    return VW_OK;
}

enum vw_status vw_submitted_print(const struct vw_batch *batch, const struct vw_slurm_numbers *numbers, const char *out,
                                  bool json) {
    uint32_t count = batch->jobs->count - batch->done;
    if (json)
        return vw_json_print(json_pack("{s:o, s:i, s:s, s:s}", "out", vw_json_string(out), "submitted", (int)count,
                                       "array", numbers->array, "merge", numbers->merge));
    if (count) vw_print("array    %s: %" PRIu32 " of %" PRIu32 " jobs\n", numbers->array, count, batch->jobs->count);
    vw_print("merge    %s%s\nlogs     %s/slurm-*.log\n", numbers->merge, count ? ": when they have ended" : "", out);
    return VW_OK;
}
