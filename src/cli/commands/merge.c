#include "batch/merge.h"
#include "cli/commands/commands.h"
#include "cli/output/results.h"
#include "run/out_folder.h"

enum vw_status vw_command_merge(const struct vw_options *options) {
    struct vw_batch_rows rows = {0};
    struct vw_out_lock *lock = NULL;
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < options->operand_count; i++)
        status = vw_batch_rows_find(&rows, options->operands[i]);
    if (!status) status = vw_merge_check_out(options->out);
    if (!status) status = vw_out_lock_take(options->out, &lock);
    if (!status) status = vw_batch_rows_merge(options->out, &rows);
    vw_out_lock_release(&lock);
    if (!status) vw_batch_rows_report(options->out, &rows);
    if (!status) status = vw_batch_rows_print(&rows, options->out, options->json);
    vw_batch_rows_free(&rows);
    return status;
}
