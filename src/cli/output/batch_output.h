// What a batch tells while it runs, and its results.
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
// A vw_batch_progress whose context is a struct vw_batch_display: a line on stderr for every job that ends; on a
// terminal also one that is updated in place.
void vw_batch_show(void *context, const struct vw_batch *batch, const struct vw_job *ended);
void vw_batch_show_end(struct vw_batch_display *display);

// The table of jobs and the files that were written, as text or JSON; no files where `runs` is NULL. `rows` NULL is
// VW_ERROR_MEMORY.
enum vw_status vw_summary_print(const struct vw_summary_row *rows, uint32_t count, const struct vw_merged_runs *runs,
                                const char *out, bool json);

// What was submitted to Slurm, and where its logs are.
enum vw_status vw_submitted_print(const struct vw_batch *batch, const struct vw_slurm_numbers *numbers, const char *out,
                                  bool json);

#endif
