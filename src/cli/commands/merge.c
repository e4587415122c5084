#include <stdlib.h>

#include "batch/merge.h"
#include "cli/commands/commands.h"
#include "cli/output/results.h"
#include "run/out_lock.h"

enum vw_status vw_command_merge(const struct vw_options *options) {
    struct vw_merged_runs runs = {0};
    struct vw_out_lock *lock = NULL;
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < options->operand_count; i++)
        status = vw_merged_runs_find(&runs, options->operands[i]);
    if (!status) status = vw_merge_check_out(options->out);
    if (!status) status = vw_out_lock_take(options->out, &lock);
    if (!status) status = vw_merge_write(options->out, &runs);
    struct vw_summary_row *rows = status ? NULL : vw_summary_of_runs(&runs);
    if (!status) status = rows ? vw_summary_write(options->out, rows, runs.count) : VW_ERROR_MEMORY;
    vw_out_lock_release(&lock);
    if (!status) vw_merge_report(options->out, &runs);
    if (!status) status = vw_summary_print(rows, runs.count, &runs, options->out, options->json);
    free(rows);
    vw_merged_runs_free(&runs);
    return status;
}
