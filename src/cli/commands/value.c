#include <math.h>
#include <stdlib.h>

#include "base/clock.h"
#include "base/memory.h"
#include "cli/commands/commands.h"
#include "cli/interrupt.h"
#include "cli/output/answer.h"
#include "cli/output/progress.h"
#include "cli/output/results.h"
#include "cli/params.h"
#include "cli/parse_options.h"
#include "experiment/kfold.h"

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
    if (!status && !steps_before) answer.training_s = took_s;
    vw_run_close(&run);
    if (!status && options->retrainings) status = vw_worth_of_run(options, options->out, options->retrainings, &answer);
    if (!status && !train_only && !options->json) vw_answer_print(&answer);
    vw_answer_free(&answer);
    return status;
}

static enum vw_status check_kfold(const struct vw_options *options) {
    static const char *const single[] = {"budget", "until-stable", "payout", "profile", "lasting", "retrainings"};
    for (size_t i = 0; i < VW_ARRAY_COUNT(single); i++)
        if (vw_options_have(options, single[i]))
            return vw_fail(VW_ERROR_USAGE, "--%s is for a single training; leave it out with --kfold", single[i]);
    return VW_OK;
}

static enum vw_status make_folds(const struct vw_options *options) {
    struct vw_device_list devices;
    struct vw_config config;
    enum vw_status status = check_kfold(options);
    if (!status) status = vw_device_list_read(options, &devices);
    if (!status) status = vw_params_take_accuracy(options, &config);
    if (status) return status;
    struct vw_progress progress = {0};
    struct vw_kfold_params params = {.common = vw_params_of_experiment(options, &devices, &progress),
                                     .folds = options->kfold};
    params.common.config = &config;
    struct vw_kfold kfold;
    status = vw_kfold_make(&params, &kfold);
    vw_progress_end(&progress);
    if (!status) status = vw_kfold_print(&kfold, options->json);
    vw_kfold_free(&kfold);
    return status;
}

enum vw_status vw_command_value(const struct vw_options *options) {
    vw_interrupt_follow_batch();
    if (options->kfold) return make_folds(options);
    if (options->devices)
        return vw_fail(
            VW_ERROR_USAGE,
            "--devices is for several trainings; give it with --kfold K, or to viewworth worth after the run");
    if (options->together && !options->retrainings)
        return vw_fail(
            VW_ERROR_USAGE,
            "--together is for several trainings; give it with --kfold K or --retrainings M, or leave it out");
    enum vw_status status = options->retrainings ? vw_worth_check_options(options) : VW_OK;
    return status ? status : make_run(options, false);
}

enum vw_status vw_command_train(const struct vw_options *options) { return make_run(options, true); }
