#include <inttypes.h>
#include <stdio.h>

#include "cli/commands/commands.h"
#include "cli/output/json_output.h"
#include "run/training_run.h"

static enum vw_status print_result(const struct vw_training_run *run) {
    if (run->options->json) return vw_json_print(vw_training_to_json(run));
    printf("%" PRIu64 " steps taken\nledger   %s\nfield    %s\n", run->statistics.steps, run->ledger_path,
           run->field_path);
    vw_profile_print(&run->profile);
    return VW_OK;
}

enum vw_status vw_command_train(const struct vw_options *options) {
    struct vw_session session = {0};
    struct vw_training_run run;
    enum vw_status status = vw_training_open(options, false, &session, &run);
    if (!status) status = vw_training_take_steps(&run);
    if (!status) status = vw_training_finish(&run, NULL, 0, NULL, 0);
    if (!status) status = print_result(&run);
    vw_training_close(&run);
    vw_session_close(&session);
    return status;
}
