// JOBS.json: what a batch values. README.md describes the format.
#ifndef VIEWWORTH_BATCH_JOBS_H
#define VIEWWORTH_BATCH_JOBS_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/status.h"

enum {
    VW_JOBS_FILE_BYTES_MAX = 1 << 20,
    VW_JOBS_MAX = 4096,
    VW_JOB_OPTIONS_MAX = 64,
    VW_JOB_OPTION_BYTES_MAX = 1024,
    VW_JOB_NAME_PART_MAX = 64, // characters of the name of a job or of a config
};

// A valuation: one scene, seed and config.
struct vw_job {
    char *name;   // owned: "fox/seed-1", or with configs "fox/draft/seed-1"; also its folder in OUT
    char **words; // owned, and its texts: "value", SCENE, "--seed=1", "--epochs=16", ... and NULL at its end
    uint32_t word_count;
    char *scene;   // owned: as the file names it
    uint64_t seed; // as its words say
    bool single;   // the caller sets it: what it asks for needs a process of its own
};

struct vw_jobs {
    struct vw_job *jobs; // owned; in the order of the file: by scene, config and seed
    uint32_t count;
};

// Reads a file, which may come from a stranger. Scenes are relative to the folder of the file. VW_ERROR_INPUT names
// file and field. What the options of a job mean is not checked here: words are for the command line. Free the jobs
// also after a failure.
enum vw_status vw_jobs_load(const char *path, struct vw_jobs *jobs);
// Returns whether one process can run both together: they differ only by their seed, and so do their names.
bool vw_jobs_fit(const struct vw_job *a, const struct vw_job *b);
void vw_jobs_free(struct vw_jobs *jobs);

// The record of how a job ended: OUT/NAME.json next to its folder OUT/NAME. After a restart, a batch reads from it
// which jobs are done. {"words": [...], "exit_code": 0, "seconds": 41.2, "message": ""}
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
