#include <math.h>
#include <stdlib.h>

#include "base/clock.h"
#include "base/memory.h"
#include "cli/commands/commands.h"
#include "cli/output/progress.h"
#include "cli/output/results.h"
#include "cli/params.h"
#include "cli/program.h"

// Makes the run of `value`, or that of `train`, which has neither validation nor scores.
static enum vw_status make_run(const struct vw_options *options, bool train_only) {
    struct vw_progress progress = {.quiet = options->quiet};
    struct vw_run_params params;
    struct vw_run *run = NULL;
    struct vw_answer answer = {0};
    enum vw_status status = vw_params_of_run(options, &params);
    params.train_only = train_only;
    if (options->retrainings) params.payout = NULL; // it follows worth
    params.progress = vw_progress_show;
    params.context = &progress;
    if (!status) status = vw_run_open(&params, &run);
    uint64_t steps_before = status ? 0 : vw_run_get_results(run)->statistics.steps;
    double began_s = vw_now_s(), took_s = NAN;
    if (!status) {
        progress.interrupt = vw_interrupt_watch(); // opening leaves an empty OUT at most, and may be ended at once
        status = vw_run_advance(run, UINT64_MAX);
        took_s = vw_now_s() - began_s;
    }
    vw_progress_end(&progress);
    if (!status) status = vw_run_finish(run);
    if (!status && !(options->retrainings && options->json)) status = vw_run_print(run, train_only, options->json);
    if (!status) status = vw_answer_begin(run, options->out, &answer);
    answer.scene = options->scene.path;
    if (!status && !steps_before) answer.training_s = took_s;
    vw_run_close(&run);
    if (!status && options->retrainings) status = vw_worth_of_run(options, options->out, options->retrainings, &answer);
    if (!status && !train_only && !options->json) vw_answer_print(&answer);
    vw_answer_free(&answer);
    return status;
}

enum vw_status vw_command_value(const struct vw_options *options) {
    vw_interrupt_follow_batch();
    if (options->together && !options->retrainings)
        return vw_fail(VW_ERROR_USAGE, "--together is for several trainings; give it with --retrainings M");
    enum vw_status status = options->retrainings ? vw_worth_check_options(options) : VW_OK;
    return status ? status : make_run(options, false);
}

enum vw_status vw_command_train(const struct vw_options *options) { return make_run(options, true); }
