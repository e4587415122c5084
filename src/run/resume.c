#include "run/run_private.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "run/run_row.h"
#include "run/stop_rules.h"
#include "viewworth/log.h"

static enum vw_status read_steps(struct vw_run *run) {
    struct vw_step_record *records = NULL;
    uint64_t count = 0;
    enum vw_status status = vw_ledger_get_steps(run->ledger, &records, &count);
    for (uint64_t i = 0; !status && i < count; i++) status = vw_run_count_step(run, &records[i]);
    free(records);
    return status;
}

static enum vw_status load_checkpoint(struct vw_run *run) {
    uint64_t recorded = vw_ledger_next_step(run->ledger), last_step = recorded - 1;
    bool found = false;
    enum vw_status status = VW_OK;
    if (recorded > 1) // at least one step is taken again, to see that device and checkpoint still do as they did
        status = vw_checkpoints_load(&run->checkpoints, run->trainer, last_step - 1, &found, &run->started_after);
    run->trainer_step = run->started_after;
    if (!status && recorded > 0)
        vw_log_info("resume   %s step %" PRIu64 "; steps up to %" PRIu64 " are recorded and will be compared",
                    found ? "from the checkpoint of" : "without a checkpoint, from", run->started_after, last_step);
    return status;
}

// Compares the steps that are recorded with those that are asked for.
static enum vw_status compare_extent(struct vw_run *run, const struct vw_ledger_run *recorded) {
    uint64_t end = vw_ledger_next_step(run->ledger), wanted = vw_trainer_total_steps(run->trainer) + 1;
    bool finished = strcmp(recorded->status, "finished") == 0, stable = false;
    enum vw_status status = finished ? vw_stop_rules_measure_stability(run, &stable) : VW_OK;
    if (status) return status;
    run->complete = finished && (end >= wanted || stable || vw_plan_keeps_time(&run->results.plan));
    if (run->complete)
        vw_log_info("resume   %s is finished after step %" PRIu64 ": no step is left to take", run->out, end - 1);
    else if (end > wanted)
        return vw_fail(VW_ERROR_USAGE,
                       "--resume: %s holds %" PRIu64 " steps already, more than --epochs %u takes; ask for more",
                       run->out, end - 1, vw_plan_epochs_most(&run->results.plan, &run->config));
    return VW_OK;
}

enum vw_status vw_run_resume(struct vw_run *run) {
    struct vw_ledger_run recorded;
    struct vw_run_row ours = {0};
    enum vw_status status = vw_ledger_get_run(run->ledger, &recorded);
    if (!status) status = vw_run_row_make(run->trainer, run->gpu, run->scene, &run->config, &ours);
    if (!status) status = vw_run_row_check_same(&ours, &recorded, run->out);
    if (!status) status = read_steps(run);
    if (!status) status = compare_extent(run, &recorded);
    if (!status && !run->complete) status = vw_ledger_extend(run->ledger, ours.row.config_json);
    if (!status && !run->complete) status = load_checkpoint(run);
    vw_run_row_free(&ours);
    return status;
}
