// JOBS.json: what a batch values. README.md describes the format.
#ifndef VIEWWORTH_BATCH_JOBS_H
#define VIEWWORTH_BATCH_JOBS_H

#include <jansson.h>
#include <stdint.h>

#include "viewworth/status.h"

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

#endif
