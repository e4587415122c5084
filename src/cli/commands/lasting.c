#include <string.h>

#include "cli/commands/commands.h"
#include "cli/output/print.h"
#include "cli/output/progress.h"
#include "cli/output/results.h"
#include "cli/program.h"
#include "run/lasting/lasting.h"
#include "run/recorded/recorded_run.h"

static json_t *to_json(const struct vw_recorded_run *run, const char *head, const struct vw_lasting_summary *summary) {
    return json_pack("{s:s, s:s, s:s, s:o}", "run_id", run->row.run_id, "ledger", run->ledger_path, "head", head,
                     "lasting", vw_lasting_to_json(summary));
}

static enum vw_status print(const char *out, bool json) {
    struct vw_recorded_run run = {0};
    struct vw_lasting_summary summary = {0};
    char head[VW_HASH_HEX_BYTES];
    enum vw_status status = vw_recorded_open(out, &run);
    if (!status) status = vw_lasting_summary_make(run.ledger, &summary);
    if (!status) vw_ledger_chain_head(run.ledger, head);
    if (!status && json) status = vw_json_print(to_json(&run, head, &summary));
    else if (!status) {
        vw_lasting_print(&summary);
        vw_print("ledger   %s\nhead     %s\n", run.ledger_path, head);
    }
    vw_lasting_summary_free(&summary);
    vw_recorded_close(&run);
    return status;
}

enum vw_status vw_command_lasting(const struct vw_options *options) {
    struct vw_progress progress = {.quiet = options->quiet, .interrupt = vw_interrupt_watch()};
    struct vw_run_params params = {.out = options->operand,
                                   .device = options->device,
                                   .lasting = options->lasting,
                                   .report = options->report,
                                   .progress = vw_progress_show,
                                   .context = &progress};
    params.lasting.wanted = true;
    enum vw_status status = vw_lasting_of_folder(&params);
    vw_progress_end(&progress);
    return status ? status : print(options->operand, options->json);
}
