// A batch as jobs of a Slurm cluster: an array of `viewworth batch --job K`, and one more that merges when all of it
// has ended. All nodes see the same files. Slurm: https://slurm.schedmd.com/sbatch.html.
#ifndef VIEWWORTH_BATCH_SLURM_H
#define VIEWWORTH_BATCH_SLURM_H

#include <stdint.h>

#include "batch/batch.h"
#include "viewworth/status.h"

enum { VW_SLURM_NUMBER_BYTES = 32 };

// All texts are borrowed.
struct vw_slurm_params {
    const struct vw_batch *batch; // result of vw_batch_look(): the jobs that are not done are submitted
    const char *jobs_path, *out, *program;
    const char *devices; // as --devices takes them; NULL: the preferred one of a node
};

// The numbers that sbatch gave; `array` is empty where all jobs are done.
struct vw_slurm_numbers {
    char array[VW_SLURM_NUMBER_BYTES], merge[VW_SLURM_NUMBER_BYTES];
};

// Writes OUT/slurm_job.sh and OUT/slurm_merge.sh and submits them. A job whose time limit is near saves what it has and
// queues itself again; one that was preempted, or whose node was lost, is queued again by Slurm; each then resumes.
// Partition, GPUs and time limit come from sbatch's environment variables. VW_ERROR_IO with sbatch's own message.
enum vw_status vw_slurm_submit(const struct vw_slurm_params *params, struct vw_slurm_numbers *numbers);

#endif
