#include "cli/params.h"
#include "cli/program.h"
#include "lab/commands/commands.h"
#include "lab/output/results.h"
#include "lab/reproduction.h"

enum vw_status vw_lab_reproduce(const struct vw_options *options) {
    struct vw_experiment_request request = {0};
    struct vw_reproduction reproduction;
    enum vw_status status = vw_params_of_experiment(options, &request);
    if (status) return status;
    status = vw_reproduction_make(&request.params, &vw_lab_options(options)->evaluated, &reproduction);
    vw_progress_end(&request.progress);
    if (!status) status = vw_reproduction_print(&reproduction, options->json);
    vw_reproduction_free(&reproduction);
    return status;
}
