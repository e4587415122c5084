#include "cli/params.h"
#include "cli/program.h"
#include "lab/commands/commands.h"
#include "lab/output/results.h"
#include "lab/reproduction.h"

enum vw_status vw_lab_reproduce(const struct vw_options *options) {
    struct vw_progress progress = {0};
    struct vw_device_list devices;
    enum vw_status status = vw_device_list_read(options, &devices);
    struct vw_experiment_params params = vw_params_of_experiment(options, &devices, &progress);
    struct vw_reproduction reproduction;
    if (status) return status;
    status = vw_reproduction_make(&params, &vw_lab_options(options)->evaluated, &reproduction);
    vw_progress_end(&progress);
    if (!status) status = vw_reproduction_print(&reproduction, options->json);
    vw_reproduction_free(&reproduction);
    return status;
}
