// Progress and results of a batch, for people and as JSON.
#ifndef VIEWWORTH_CLI_OUTPUT_BATCH_OUTPUT_H
#define VIEWWORTH_CLI_OUTPUT_BATCH_OUTPUT_H

#include <stdbool.h>

#include "batch/batch.h"
#include "batch/slurm.h"

// All zero but for the first.
struct vw_batch_display {
    bool quiet;
    double drawn_s, started_s; // private
};
// Shows a line on stderr for every job that ends; on a terminal also one that is updated in place. A vw_batch_progress
// whose context is a struct vw_batch_display.
void vw_batch_show(void *context, const struct vw_batch *batch, const struct vw_job *ended);
void vw_batch_show_end(struct vw_batch_display *display);

// Prints the table of jobs and the files that were written, as text or JSON; no files if `runs` is NULL. Returns
// VW_ERROR_MEMORY if `rows` is NULL.
enum vw_status vw_summary_print(const struct vw_summary_row *rows, uint32_t count, const struct vw_merged_runs *runs,
                                const char *out, bool json);

// Prints the jobs that were submitted to Slurm, and the place of their logs.
enum vw_status vw_submitted_print(const struct vw_batch *batch, const struct vw_slurm_numbers *numbers, const char *out,
                                  bool json);

#endif
