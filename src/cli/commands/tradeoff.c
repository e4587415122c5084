#include "cli/commands/commands.h"

#include "cli/output/results.h"
#include "cli/params.h"

enum vw_status vw_tradeoff_make(const struct vw_options *options, const struct vw_sweep_follower *follower) {
    struct vw_experiment_request request = {0};
    if (options->seeds < 2)
        return vw_fail(VW_ERROR_USAGE, "tradeoff: agreement between seeds needs two --seeds or more");
    enum vw_status status = vw_params_of_experiment(options, &request);
    struct vw_sweep_params params = {.common = request.params, .follower = follower};
    if (!status) status = vw_sweep_parameters_parse(options->parameters, &params.parameters);
    if (status) return status;
    struct vw_sweep sweep;
    status = vw_sweep_make(&params, &sweep);
    vw_progress_end(&request.progress);
    if (!status) status = vw_sweep_print(&sweep, options->json);
    vw_sweep_free(&sweep);
    return status;
}

enum vw_status vw_command_tradeoff(const struct vw_options *options) { return vw_tradeoff_make(options, NULL); }
