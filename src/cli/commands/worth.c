#include "cli/commands/commands.h"

#include "cli/output/results.h"
#include "cli/params.h"
#include "cli/program.h"
#include "experiment/worth.h"

static struct vw_worth_run_params params_of(const struct vw_options *options, const char *out, uint32_t retrainings) {
    return (struct vw_worth_run_params){.out = out,
                                        .retrainings = retrainings,
                                        .until_confidence = options->until_confidence,
                                        .together = options->together,
                                        .report = options->report,
                                        .payout = options->payout};
}

enum { RETRAININGS_MOST = 100000 };

// Refuses a number that only verify takes.
static enum vw_status check_number(const struct vw_options *options) {
    if (options->retrainings <= RETRAININGS_MOST) return VW_OK;
    return vw_fail(VW_ERROR_USAGE, "--retrainings takes a whole number, 0 to %d", RETRAININGS_MOST);
}

enum vw_status vw_worth_check_options(const struct vw_options *options) {
    const struct vw_worth_run_params params = params_of(options, options->out, options->retrainings);
    enum vw_status status = check_number(options);
    return status ? status : vw_worth_run_check(&params);
}

enum vw_status vw_worth_of_run(const struct vw_options *options, const char *out, uint32_t retrainings,
                               struct vw_answer *answer) {
    struct vw_worth_run_params params = params_of(options, out, retrainings);
    struct vw_device_list devices;
    struct vw_worth_run result;
    enum vw_status status = vw_device_list_read(options, &devices);
    if (status) return status;
    params.devices = vw_device_list_choose(options, &devices);
    params.interrupt = vw_interrupt_watch();
    status = vw_worth_run_make(&params, &result);
    if (!status) status = vw_worth_print(&result, options->until_confidence, options->json);
    const struct vw_results *results = &result.outputs.results;
    if (!status && answer && results->advice.photos) status = vw_answer_take(answer, results);
    vw_worth_run_free(&result);
    return status;
}

enum vw_status vw_command_worth(const struct vw_options *options) {
    enum vw_status status = check_number(options);
    return status ? status : vw_worth_of_run(options, options->operand, options->retrainings, NULL);
}
