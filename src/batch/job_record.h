// The record of how a job ended: OUT/NAME.json next to its folder OUT/NAME. After a restart, a batch reads from it
// which jobs are done. {"words": [...], "exit_code": 0, "seconds": 41.2, "message": ""}
#ifndef VIEWWORTH_BATCH_JOB_RECORD_H
#define VIEWWORTH_BATCH_JOB_RECORD_H

#include <stdbool.h>

#include "batch/jobs.h"
#include "viewworth/status.h"

struct vw_job_record {
    int exit_code;  // exit code of its last process; 128 + N if signal N ended it; -1: none has ended yet
    double seconds; // that its processes took together
    char *message;  // owned: why it failed; NULL: it did not
};

// Returns whether the recorded job has the same words, ended with exit code 0, and its run still exists. The words
// contain the scene as JOBS.json names it.
bool vw_job_record_is_done(const char *out, const struct vw_job *job, const struct vw_job_record *record);
// Reads the record of a job with the same words; one with other words, none and a broken one are as if no process had
// ended. VW_ERROR_MEMORY.
enum vw_status vw_job_record_read(const char *out, const struct vw_job *job, struct vw_job_record *record);
enum vw_status vw_job_record_write(const char *out, const struct vw_job *job, const struct vw_job_record *record);

#endif
