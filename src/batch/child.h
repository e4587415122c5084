// A job as a process of its own, so that one that crashes ends no other.
#ifndef VIEWWORTH_BATCH_CHILD_H
#define VIEWWORTH_BATCH_CHILD_H

#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

#include "viewworth/status.h"

// The variable by which a child learns which process started it. The program asks the kernel to be ended with that
// process (cli/interrupt.h), so that a batch that is killed leaves none behind.
#define VW_CHILD_PARENT_VARIABLE "VIEWWORTH_BATCH_PROCESS"

// The variable by which a child learns the seeds of the jobs that it values, "0,1,2"; empty: it is the job that its
// words say. The log of job i of several is its open file VW_CHILD_LOG + i (cli/commands/value_jobs.c).
#define VW_CHILD_SEEDS_VARIABLE "VIEWWORTH_BATCH_SEEDS"
enum { VW_CHILD_LOG = 3, VW_CHILD_JOBS_MAX = 16 };

struct vw_child_params {
    const char *program;
    char *const *words;           // the first is its name; NULL ends them
    const char *seeds;            // seeds of the jobs; "" for one job
    const char *const *log_paths; // one per job; stdout and stderr are added to the first. None may be a link.
    uint32_t job_count;           // up to VW_CHILD_JOBS_MAX
};

// Starts a process in a process group of its own: Ctrl-C does not reach it.
enum vw_status vw_child_start(const struct vw_child_params *params, pid_t *process);

// Runs the program of the PATH that the first word names to its end. `text` gets what it prints on stdout and stderr,
// up to size - 1 bytes. VW_ERROR_IO where it cannot be started.
enum vw_status vw_child_read(char *const *words, char *text, size_t size, int *exit_code);

#endif
