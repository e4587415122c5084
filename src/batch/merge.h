// The results of many runs side by side, made again from their ledgers.
#ifndef VIEWWORTH_BATCH_MERGE_H
#define VIEWWORTH_BATCH_MERGE_H

#include <stddef.h>
#include <stdint.h>

#include "viewworth/status.h"

// A run, and what it reached.
struct vw_merged_run {
    char *job;    // owned: "fox/draft/seed-1", its key
    char *folder; // owned
    // Filled by vw_merge_write():
    char *scene;     // owned: where the scene lies, as the run was told
    char status[16]; // status of the run: "finished", ...
    int64_t seed;
    uint64_t steps;
    uint32_t epochs, photos;     // epochs that were begun; train photos
    double first_psnr, val_psnr; // dB, before the first and after the last validated step; NaN: none
};

struct vw_merged_runs {
    struct vw_merged_run *runs; // owned
    uint32_t count;
    uint32_t reported; // runs that report.html shows: the first ones; 0: there is none
    size_t capacity;   // private
};

// Adds a run by its folder.
enum vw_status vw_merged_runs_add(struct vw_merged_runs *runs, const char *job, const char *folder);
// Adds every run that lies in a folder or below it, in the order of the names; a run's job is its path from the folder,
// and the folder's own name for a run in itself. Links are not followed. VW_ERROR_INPUT where there is none.
enum vw_status vw_merged_runs_find(struct vw_merged_runs *runs, const char *folder);
void vw_merged_runs_free(struct vw_merged_runs *runs);

// Checks that OUT can be written in, and contains no run, whose scores.csv and report.html would be lost.
// VW_ERROR_USAGE.
enum vw_status vw_merge_check_out(const char *out);

// Verifies every ledger and writes to OUT, whose lock the caller holds: merged.db (ledger/merge.h), and scores.csv with
// the columns job, config (the part of the job's name before its seed, if there is one), scene and seed before those of
// a run. VW_ERROR_MISMATCH, which names it, for a ledger that was edited, and VW_ERROR_USAGE for two runs of one job;
// then nothing is written.
enum vw_status vw_merge_write(const char *out, struct vw_merged_runs *runs);

// Writes OUT/report.html of the first runs, as many as VW_MERGE_REPORTED_MAX, and of the tables of OUT. Takes the lock
// of OUT itself. A failure is a warning.
enum { VW_MERGE_REPORTED_MAX = 24 };
void vw_merge_report(const char *out, struct vw_merged_runs *runs);

// A row of summary.csv, for a job. All is borrowed.
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
