// summary.csv: one row per job.
#ifndef VIEWWORTH_BATCH_SUMMARY_H
#define VIEWWORTH_BATCH_SUMMARY_H

#include <stdint.h>

#include "batch/merge.h"
#include "viewworth/status.h"

// All is borrowed.
struct vw_summary_row {
    const char *job, *state;         // a job's "done", "failed", ...; a run's "finished", "running", ...
    int exit_code;                   // -1: none is known
    double seconds;                  // NaN: not known
    const struct vw_merged_run *run; // NULL: none
    const char *message;             // NULL: none
};

// Returns the rows of runs whose jobs are not known. Owned by the caller (free); NULL if memory is short.
struct vw_summary_row *vw_summary_of_runs(const struct vw_merged_runs *runs);

// Writes OUT/summary.csv: job,state,exit_code,seconds,photos,steps,epochs,first_psnr,val_psnr,report,message. `report`
// is the path from OUT of the run's own report, for runs that lie below OUT. What is not known is empty.
enum vw_status vw_summary_write(const char *out, const struct vw_summary_row *rows, uint32_t count);

#endif
