// JOBS.json: what a batch values. README.md describes the format.
#ifndef VIEWWORTH_BATCH_JOBS_H
#define VIEWWORTH_BATCH_JOBS_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/status.h"
#include "viewworth/types.h"

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

enum vw_job_state {
    VW_JOB_WAITING, // its name is "waiting"; the others in the same way
    VW_JOB_RUNNING,
    VW_JOB_DONE,
    VW_JOB_FAILED,
    VW_JOB_STOPPED // by an interrupt; the same command resumes it
};

// The end of a job. Its record is OUT/NAME.json next to its folder OUT/NAME: {"words": [...], "exit_code": 0,
// "seconds": 41.2, "message": "", "run": "HASH"}. After a restart, a batch reads from it which jobs are done.
struct vw_job_result {
    enum vw_job_state state;
    int exit_code;               // exit code of its last process; 128 + N if signal N ended it; -1: none has ended
    double seconds;              // that its processes took together
    char *message;               // owned: the last line of its log, where it failed; else NULL
    char run[VW_HASH_HEX_BYTES]; // hash of the run_id and config of a job that is done; else ""
};

// Reads the record of a job with the same words, which contain the scene as JOBS.json names it: done if the last
// process ended with exit code 0 and its run is still there, failed if another run is, or if there is a message,
// otherwise waiting. A record of other words, none and a broken one are as if no process had ended. VW_ERROR_MEMORY.
enum vw_status vw_job_result_read(const char *out, const struct vw_job *job, struct vw_job_result *result);
// Fails a job that is done unless its folder has the run that it left, with the seed that JOBS.json names.
enum vw_status vw_job_result_check(const char *out, const struct vw_job *job, struct vw_job_result *result);
// Notes which run a job left that has ended with exit code 0, and is done; fails it where that has another seed.
enum vw_status vw_job_result_note_run(const char *out, const struct vw_job *job, struct vw_job_result *result);
enum vw_status vw_job_result_write(const char *out, const struct vw_job *job, const struct vw_job_result *result);

#endif
