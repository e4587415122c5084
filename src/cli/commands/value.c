#include "cli/commands/commands.h"
#include "cli/interrupt.h"
#include "cli/output/progress.h"
#include "cli/output/run_output.h"
#include "cli/params.h"

// `train` is `value` without validation and scores.
static enum vw_status make_run(const struct vw_options *options, bool train_only) {
    struct vw_progress progress = {.quiet = options->quiet};
    struct vw_run_params params;
    struct vw_run *run = NULL;
    enum vw_status status = vw_params_of_run(options, &params);
    params.train_only = train_only;
    params.progress = vw_progress_show;
    params.context = &progress;
    if (!status) status = vw_run_open(&params, &run);
    if (!status) {
        progress.interrupt = vw_interrupt_watch(); // opening leaves an empty OUT at most, and may be ended at once
        status = vw_run_advance(run, UINT64_MAX);
    }
    vw_progress_end(&progress);
    if (!status) status = vw_run_finish(run);
    if (!status) status = vw_run_print(run, train_only, options->json);
    vw_run_close(&run);
    return status;
}

enum vw_status vw_command_value(const struct vw_options *options) { return make_run(options, false); }

enum vw_status vw_command_train(const struct vw_options *options) { return make_run(options, true); }
