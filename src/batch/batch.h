// Many valuations from one file: each a process of its own, some at a time on every device, then their results side by
// side.
#ifndef VIEWWORTH_BATCH_BATCH_H
#define VIEWWORTH_BATCH_BATCH_H

#include <jansson.h>
#include <stdint.h>

#include "base/interrupt.h"
#include "batch/merge.h"

// ---- JOBS.json: what a batch values. README.md describes the format -------------------------------------------------

enum {
    VW_JOBS_FILE_BYTES_MAX = 1 << 20,
    VW_JOBS_MAX = 4096,
    VW_JOB_OPTIONS_MAX = 64,
    VW_JOB_OPTION_BYTES_MAX = 1024,
    VW_JOB_NAME_PART_MAX = 64, // characters of the name of a job or of a config
};

// A valuation: one scene, seed and config. All is owned.
struct vw_job {
    char *name;    // "fox/seed-1", or with configs "fox/draft/seed-1"; also its folder in OUT
    char *scene;   // its path; the words have it as the file names it
    json_t *words; // ["value", SCENE, "--seed=1", "--epochs=16", ...]
};

struct vw_jobs {
    struct vw_job *jobs; // owned; in the order of the file: by scene, config and seed
    uint32_t count;
};

// Reads a file, which may come from a stranger. Scenes are relative to the folder of the file. VW_ERROR_INPUT names
// file and field. What the options of a job mean is not checked here: words are for the command line. Free the jobs
// also after a failure.
enum vw_status vw_jobs_load(const char *path, struct vw_jobs *jobs);
void vw_jobs_free(struct vw_jobs *jobs);

// Returns "viewworth", the words of a job with the path of its scene, those of `more` (NULL ends them), and NULL. The
// array is owned by the caller, its texts are borrowed. NULL if memory is short.
char **vw_job_list_words(const struct vw_job *job, char *const *more);

// ---- The batch ------------------------------------------------------------------------------------------------------

// The variable by which a job learns which process started it. The program asks the kernel to be ended with that
// process (cli/interrupt.c), so that a batch that is killed leaves none running.
#define VW_BATCH_PROCESS_VARIABLE "VIEWWORTH_BATCH_PROCESS"

struct vw_batch {
    const struct vw_jobs *jobs; // borrowed
    struct vw_batch_rows rows;  // owned; a row per job
    uint32_t done, failed, running;
};

// Called as often as something can have changed. `ended` is the job that has just ended; NULL: none.
typedef void vw_batch_progress(void *context, const struct vw_batch *batch, const struct vw_batch_row *ended);

struct vw_batch_params {
    const struct vw_jobs *jobs;
    const char *out;
    const char *const *devices; // indices or names; job i takes device i modulo their number
    uint32_t device_count;      // 0: the preferred device
    uint32_t per_device;        // processes at a time on each
    uint32_t only;              // the only job to run, counted from 1, beside other processes that run others; 0: all
    struct vw_interrupt interrupt;
    vw_batch_progress *progress;
    void *context;
};

// Runs the jobs that are not done. Each leaves OUT/NAME/ (as value does), OUT/NAME.log, and its record OUT/NAME.json:
// {"words", "exit_code", "seconds", "message"}. A job is done if the record has its words and exit code 0, and its
// folder a ledger. Writes summary.csv after each job, and at the end what vw_batch_rows_merge() and
// vw_batch_rows_report() write. With `only`, writes these at the end where all jobs are done and no other process does.
// VW_ERROR_IO names the number of jobs that failed, after the others have ended. After VW_ERROR_INTERRUPTED, and after
// a kill, the same call resumes. Free it also after a failure.
enum vw_status vw_batch_make(const struct vw_batch_params *params, struct vw_batch *batch);

// Finds which jobs are done in OUT; all others wait. Free it also after a failure.
enum vw_status vw_batch_look(const struct vw_jobs *jobs, const char *out, struct vw_batch *batch);
// Submits those that wait to a Slurm cluster, as an array of `words` --job K; NULL ends the words, the first of which
// is the program. sbatch prints the number of the array, and says itself what is wrong. A job whose time limit is near
// saves what it has and queues itself again; one that was preempted, or whose node was lost, is queued again by Slurm;
// each then resumes. Partition, GPUs and time limit come from sbatch's environment variables.
enum vw_status vw_batch_submit(const struct vw_batch *batch, const char *out, const char *const *words);
void vw_batch_free(struct vw_batch *batch);

#endif
