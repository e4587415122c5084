#include "cli/commands/commands.h"
#include "cli/output/results.h"
#include "cli/params.h"
#include "experiment/comparison.h"

_Static_assert((int)VW_TEXTS_MOST == (int)VW_PHOTO_SETS_MAX, "--list may be given as often as lists can be compared");

enum vw_status vw_command_compare(const struct vw_options *options) {
    struct vw_experiment_request request = {0};
    enum vw_status status = vw_params_of_experiment(options, &request);
    struct vw_comparison_params params = {.common = request.params,
                                          .sets = {.lists = options->lists.texts,
                                                   .list_count = options->lists.count,
                                                   .scores = options->scores,
                                                   .method = options->method,
                                                   .equal = options->equal}};
    struct vw_comparison comparison;
    if (status) return status;
    status = vw_comparison_make(&params, &comparison);
    vw_progress_end(&request.progress);
    if (!status) status = vw_comparison_print(&comparison, options->json);
    vw_comparison_free(&comparison);
    return status;
}
