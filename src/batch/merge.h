// The results of many runs side by side, made from their ledgers.
#ifndef VIEWWORTH_BATCH_MERGE_H
#define VIEWWORTH_BATCH_MERGE_H

#include "base/rows.h"

enum vw_job_state {
    VW_JOB_WAITING, // its name is "waiting"; the others in the same way
    VW_JOB_RUNNING,
    VW_JOB_DONE,
    VW_JOB_FAILED,
    VW_JOB_STOPPED // by an interrupt; the same command resumes it
};

// A run that is merged. Texts are owned.
struct vw_merged_run {
    char *scene;  // where the scene lies, as the run was told
    char *report; // the path of its report from OUT; NULL: it does not lie below OUT
    uint64_t seed, steps;
    uint32_t epochs, photos;     // epochs that were begun; train photos
    double first_psnr, val_psnr; // dB, before the first and after the last validated step; NaN: none
};

// A job, and the run that it made. All is owned; NULL: not known.
struct vw_batch_row {
    char *job;    // "fox/draft/seed-1", its key
    char *folder; // the run's
    enum vw_job_state state;
    const char *state_name; // its text in tables
    int exit_code;          // exit code of its last process; 128 + N if signal N ended it; -1: none has ended
    double seconds;         // that its processes took together; NaN: not known
    char *message;          // why it failed
    struct vw_merged_run *run;
};

struct vw_batch_rows {
    struct vw_batch_row *rows; // owned
    uint32_t count;
    uint32_t merged, reported; // rows that are merged, and that report.html shows
    size_t capacity;           // private
};

// Adds a run that waits, by its folder.
enum vw_status vw_batch_rows_add(struct vw_batch_rows *rows, const char *job, const char *folder);
// Adds every run that lies in a folder or below it as done, in the order of the names; its job is its path from the
// folder, and the folder's own name for a run in itself. Links are not followed. VW_ERROR_INPUT where there is none.
enum vw_status vw_batch_rows_find(struct vw_batch_rows *rows, const char *folder);
void vw_batch_rows_free(struct vw_batch_rows *rows);

// Checks that OUT can be written in, and contains no run, whose scores.csv and report.html would be lost.
// VW_ERROR_USAGE.
enum vw_status vw_merge_check_out(const char *out);

// Verifies the ledgers of all rows that are done and writes to OUT, whose lock the caller holds: merged.db
// (ledger/merge.h); scores.csv, with the columns job, config (the part of the job's name before its seed, if there is
// one), scene and seed before those of a run; and summary.csv, the table of all rows. VW_ERROR_MISMATCH, which names
// it, for a ledger that was edited, and VW_ERROR_USAGE for two runs of one job; then nothing is written.
enum vw_status vw_batch_rows_merge(const char *out, struct vw_batch_rows *rows);
// Writes summary.csv alone: the state of every row.
enum vw_status vw_batch_rows_write(const char *out, struct vw_batch_rows *rows);
struct vw_rows vw_batch_rows_table(struct vw_batch_rows *rows);

// Writes OUT/report.html of the first merged runs, as many as VW_MERGE_REPORTED_MAX, and of the tables of OUT. Takes
// the lock of OUT itself. A failure is a warning.
enum { VW_MERGE_REPORTED_MAX = 24 };
void vw_batch_rows_report(const char *out, struct vw_batch_rows *rows);

#endif
