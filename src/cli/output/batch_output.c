#include <inttypes.h>
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

enum vw_status vw_batch_rows_print(struct vw_batch_rows *rows, const char *out, bool json) {
    const struct vw_rows table = vw_batch_rows_table(rows);
    if (json)
        return vw_json_print(json_pack("{s:o, s:o}", "out", vw_json_string(out), "jobs", vw_rows_to_json(&table)));
    vw_print_rows(&table);
    if (rows->merged)
        vw_print("summary  %s/summary.csv\nscores   %s/scores.csv\nledgers  %s/merged.db\n", out, out, out);
    if (rows->reported) vw_print("report   %s/report.html\n", out);
    if (rows->reported && rows->reported < rows->merged)
        vw_print("         of the first %" PRIu32 " runs; each has its own in its folder\n", rows->reported);
    return VW_OK;
}
