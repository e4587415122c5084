#include "cli/commands/commands.h"
#include "cli/output/results.h"
#include "cli/params.h"
#include "experiment/comparison.h"

_Static_assert((int)VW_TEXTS_MOST == (int)VW_PHOTO_SETS_MAX, "--list may be given as often as lists can be compared");

enum vw_status vw_command_compare(const struct vw_options *options) {
    struct vw_progress progress = {0};
    struct vw_device_list devices;
    struct vw_config config;
    enum vw_status status = vw_device_list_read(options, &devices);
    if (!status) status = vw_params_take_accuracy(options, &config);
    struct vw_comparison_params params = {.common = vw_params_of_experiment(options, &devices, &progress),
                                          .sets = {.lists = options->lists.texts,
                                                   .list_count = options->lists.count,
                                                   .scores = options->scores,
                                                   .method = options->method,
                                                   .equal = options->equal}};
    struct vw_comparison comparison;
    if (status) return status;
    params.common.config = &config;
    status = vw_comparison_make(&params, &comparison);
    vw_progress_end(&progress);
    if (!status) status = vw_comparison_print(&comparison, options->json);
    vw_comparison_free(&comparison);
    return status;
}
