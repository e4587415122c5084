// Many valuations from one file: each a process of its own, some at a time on every device, then their results side by
// side.
#ifndef VIEWWORTH_BATCH_BATCH_H
#define VIEWWORTH_BATCH_BATCH_H

#include <stdbool.h>
#include <stdint.h>

#include "base/interrupt.h"
#include "batch/jobs.h"
#include "batch/merge.h"
#include "viewworth/status.h"

struct vw_batch {
    const struct vw_jobs *jobs;    // borrowed
    struct vw_job_result *results; // owned; by job
    uint32_t done, failed, running;
    struct vw_merged_runs merged; // the jobs that are done; empty until all others have ended
};

// Called as often as something can have changed. `ended` is the job that has just ended; NULL: none.
typedef void vw_batch_progress(void *context, const struct vw_batch *batch, const struct vw_job *ended);

struct vw_batch_params {
    const struct vw_jobs *jobs;
    const char *out;
    const char *program;        // the file of viewworth
    const char *const *devices; // indices or names; job i takes device i modulo their number
    uint32_t device_count;      // 0: the preferred device
    uint32_t per_device;        // processes at a time on each; 0: 1
    uint32_t together;          // jobs that one process may take, if they fit (jobs.h), up to VW_CHILD_JOBS_MAX; 0: 1
    bool together_given;        // else a process takes as many of its jobs at a time as its device suggests
    uint32_t only;              // the only job to run, counted from 1, beside other processes that run others; 0: all
    bool merge_only;            // runs no job, and merges those that are done
    struct vw_interrupt interrupt;
    vw_batch_progress *progress; // NULL: none
    void *context;
};

// Runs the jobs that are not done. If a process runs several and one of them fails, each is run once more
// alone, so that none fails with another. Each leaves OUT/NAME/ (as value does), OUT/NAME.log and OUT/NAME.json
// (struct vw_job_result). Writes batch.json, {"jobs": [{"name", "state", "exit_code", "seconds", "message"}, ...]} with
// null for missing values, and at the end summary.csv, what vw_merge_write() writes, and report.html. With `only`,
// writes none of these, and takes no lock of OUT. VW_ERROR_IO names the number of jobs that failed, after the others
// have ended. After VW_ERROR_INTERRUPTED, and after a kill, the same call resumes. Free it also after a failure.
enum vw_status vw_batch_make(const struct vw_batch_params *params, struct vw_batch *batch);
// Finds which jobs are done in OUT, which failed at last (with `message`), and which wait. Free it also after a
// failure.
enum vw_status vw_batch_look(const struct vw_jobs *jobs, const char *out, struct vw_batch *batch);
void vw_batch_free(struct vw_batch *batch);

// Returns a row per job, owned by the caller (free); NULL if memory is short.
struct vw_summary_row *vw_summary_of_batch(const struct vw_batch *batch);

#endif
