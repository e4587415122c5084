#include <stdlib.h>

#include "cli/commands/commands.h"
#include "run/outputs/report_folder.h"
#include "experiment/reproduction.h"
#include "experiment/seed_runs.h"
#include "base/file.h"

// What no run could mend, before any work is done.
static enum vw_status check(const struct vw_options *options) {
    const struct vw_config *config = &options->config;
    if (config->epochs <= config->burn_in_epochs)
        return vw_fail(VW_ERROR_USAGE,
                       "--epochs %u leaves no epoch after --burn-in %u, and no scores to compare; ask for more",
                       config->epochs, config->burn_in_epochs);
    return VW_OK;
}

static enum vw_status finish(const struct vw_options *options) {
    struct vw_reproduction reproduction;
    const struct vw_report_params report = {.device = options->device, .no_thumbnails = options->no_thumbnails};
    char *report_path = NULL;
    char *agreement_path = vw_path_join(options->out, "reproduce.csv"),
         *scatter_path = vw_path_join(options->out, "scatter.csv");
    enum vw_status status = vw_reproduction_make(options, &reproduction);
    if (!status && (!agreement_path || !scatter_path)) status = VW_ERROR_MEMORY;
    if (!status) status = vw_reproduction_write_agreement(&reproduction, agreement_path);
    if (!status) status = vw_reproduction_write_scatter(&reproduction, scatter_path);
    if (!status) report_path = vw_report_folder_finish(options->out, &report, NULL);
    if (!status && options->json)
        status = vw_reproduction_print_json(&reproduction, agreement_path, scatter_path, report_path);
    else if (!status) vw_reproduction_print_text(&reproduction, agreement_path, scatter_path, report_path);
    vw_reproduction_free(&reproduction);
    free(agreement_path);
    free(scatter_path);
    free(report_path);
    return status;
}

enum vw_status vw_command_reproduce(const struct vw_options *options) {
    struct vw_options varied = *options;
    if (options->config.vary != VW_VARY_ALL) varied.config.base_seed = options->config.seed;
    enum vw_status status = check(&varied);
    if (!status) status = vw_seed_runs_make(&varied, 0, varied.seeds);
    return status ? status : finish(&varied);
}
