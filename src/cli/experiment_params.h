// From the command line to what all experiments are given. Texts are borrowed from the options, the config is theirs.
#ifndef VIEWWORTH_CLI_EXPERIMENT_PARAMS_H
#define VIEWWORTH_CLI_EXPERIMENT_PARAMS_H

#include "cli/device_list.h"
#include "cli/options.h"
#include "cli/output/progress.h"
#include "experiment/experiment.h"

// Returns the params of the experiment. After this call SIGINT and SIGTERM interrupt the experiment. `devices`: as read
// from the options. `progress` shows the runs; it begins all zero, and vw_progress_end() ends it.
struct vw_experiment_params vw_params_of_experiment(const struct vw_options *options,
                                                    const struct vw_device_list *devices, struct vw_progress *progress);

#endif
