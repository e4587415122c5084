#include "experiment/benchmark.h"

#include <string.h>

#include "cli/commands/commands.h"
#include "cli/experiment_params.h"
#include "cli/output/benchmark_output.h"

static enum vw_curves curves_of(const char *list) {
    if (!list) return VW_CURVES_DEFAULT;
    if (!strcmp(list, "none")) return VW_CURVES_NONE;
    return strcmp(list, "all") ? VW_CURVES_LISTED : VW_CURVES_ALL;
}

enum vw_status vw_command_benchmark(const struct vw_options *options) {
    struct vw_progress progress = {0};
    const struct vw_benchmark_params params = {.common = vw_params_of_experiment(options, &progress),
                                               .subsets = options->subsets,
                                               .leave_one_out = options->leave_one_out,
                                               .curves = curves_of(options->curves),
                                               .curve_scorers = options->curves};
    struct vw_benchmark benchmark;
    enum vw_status status = vw_benchmark_make(&params, &benchmark);
    vw_progress_end(&progress);
    if (!status) status = vw_benchmark_print(&benchmark, options->json);
    vw_benchmark_free(&benchmark);
    return status;
}
