#include <inttypes.h>
#include <math.h>
#include <stdio.h>

#include "base/clock.h"
#include "cli/output/print.h"
#include "cli/output/progress.h"
#include "cli/output/results.h"
#include "viewworth/log.h"

// Shows the counts on one line: "3 of 12 done, 1 failed, 2 running  214 s"
static void show_counts(struct vw_batch_display *display, const struct vw_batch *batch) {
    char line[160];
    snprintf(line, sizeof line, "%" PRIu32 " of %" PRIu32 " done, %" PRIu32 " failed, %" PRIu32 " running  %.0f s",
             batch->done, batch->rows.count, batch->failed, batch->running, vw_now_s() - display->started_s);
    vw_progress_replace_line(&display->drawn_s, line);
}

void vw_batch_show(void *context, const struct vw_batch *batch, const struct vw_batch_row *ended) {
    struct vw_batch_display *display = context;
    if (!(display->started_s > 0)) display->started_s = vw_now_s();
    if (!ended && !display->quiet) show_counts(display, batch);
    if (!ended) return;
    if (ended->state == VW_JOB_DONE)
        vw_log_info("done %" PRIu32 " of %" PRIu32 ": %s, %.0f s", batch->done, batch->rows.count, ended->job,
                    ended->seconds);
    else if (ended->state == VW_JOB_STOPPED) vw_log_info("stopped: %s", ended->job);
    else vw_log_warning("failed: %s, exit code %d: %s", ended->job, ended->exit_code, ended->message);
}

void vw_batch_show_end(struct vw_batch_display *display) {
    if (!display->quiet) vw_progress_replace_line(&display->drawn_s, "");
}

static void print_row(const struct vw_batch_row *row) {
    char time[24] = "", psnr[64] = "";
    if (!isnan(row->seconds)) snprintf(time, sizeof time, "%.1f", row->seconds);
    if (row->scene && !isnan(row->val_psnr))
        snprintf(psnr, sizeof psnr, "%.2f -> %.2f", row->first_psnr, row->val_psnr);
    vw_print("%-7s %8s", vw_job_state_name(row->state), time);
    if (row->scene) vw_print(" %6" PRIu32 " %8" PRIu64 " %15s", row->photos, row->steps, psnr);
    else vw_print(" %6s %8s %15s", "", "", "");
    vw_print("  %s%s%s\n", row->job, row->message ? ": " : "", row->message ? row->message : "");
}

static json_t *row_to_json(const struct vw_batch_row *row) {
    json_t *object = json_pack("{s:o, s:s}", "job", vw_json_string(row->job), "state", vw_job_state_name(row->state));
    vw_json_set(&object, "exit_code", row->exit_code < 0 ? json_null() : json_integer(row->exit_code));
    vw_json_set(&object, "seconds", vw_json_real(row->seconds));
    vw_json_set(&object, "message", vw_json_string(row->message));
    if (!row->scene) return object;
    vw_json_set(&object, "scene", vw_json_string(row->scene));
    vw_json_set(&object, "seed", json_integer(row->seed));
    vw_json_set(&object, "photos", json_integer(row->photos));
    vw_json_set(&object, "steps", json_integer((json_int_t)row->steps));
    vw_json_set(&object, "epochs", json_integer(row->epochs));
    vw_json_set(&object, "first_psnr", vw_json_real(row->first_psnr));
    vw_json_set(&object, "val_psnr", vw_json_real(row->val_psnr));
    return object;
}

static enum vw_status print_json(const struct vw_batch_rows *rows, const char *out) {
    json_t *jobs = json_array();
    for (uint32_t i = 0; i < rows->count; i++) vw_json_append(&jobs, row_to_json(&rows->rows[i]));
    return vw_json_print(json_pack("{s:o, s:o}", "out", vw_json_string(out), "jobs", jobs));
}

enum vw_status vw_rows_print(const struct vw_batch_rows *rows, const char *out, bool json) {
    if (json) return print_json(rows, out);
    vw_print("%-7s %8s %6s %8s %15s  %s\n", "state", "seconds", "photos", "steps", "val PSNR, dB", "job");
    for (uint32_t i = 0; i < rows->count; i++) print_row(&rows->rows[i]);
    if (rows->merged)
        vw_print("summary  %s/summary.csv\nscores   %s/scores.csv\nledgers  %s/merged.db\n", out, out, out);
    if (rows->reported) vw_print("report   %s/report.html\n", out);
    if (rows->reported && rows->reported < rows->merged)
        vw_print("         of the first %" PRIu32 " runs; each has its own in its folder\n", rows->reported);
    return VW_OK;
}
