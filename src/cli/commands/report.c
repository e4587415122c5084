#include <stdlib.h>

#include "base/file.h"
#include "base/memory.h"
#include "cli/commands/commands.h"
#include "cli/output/print.h"
#include "run/outputs/report_folder.h"

enum vw_status vw_report_make(const struct vw_options *options, const struct vw_report_extra *extra) {
    const struct vw_report_params report = {.device = options->device, .options = options->report, .extra = extra};
    char *path = options->to ? vw_copy_text(options->to) : vw_path_join(options->operand, "report.html");
    if (!path) return VW_ERROR_MEMORY;
    enum vw_status status = vw_report_write(options->operands, options->operand_count, path, &report);
    if (!status && options->json)
        status = vw_json_print(json_pack("{s:s, s:I}", "report", path, "folders", (json_int_t)options->operand_count));
    else if (!status) vw_print("report   %s\n", path);
    free(path);
    return status;
}

enum vw_status vw_command_report(const struct vw_options *options) { return vw_report_make(options, NULL); }
