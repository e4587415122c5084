#include "cli/experiment_params.h"

#include "cli/interrupt.h"
#include "cli/params.h"

struct vw_experiment_params vw_params_of_experiment(const struct vw_options *options,
                                                    const struct vw_device_list *devices,
                                                    struct vw_progress *progress) {
    progress->quiet = options->quiet;
    return (struct vw_experiment_params){
        .scene = vw_params_of_scene(options),
        .config = &options->config,
        .devices = vw_device_list_choose(options, devices),
        .out = options->out,
        .seeds = options->seeds,
        .together = options->together,
        .report = options->report,
        .lasting = options->lasting,
        .interrupt = vw_interrupt_watch(),
        .progress = vw_progress_show,
        .context = progress,
    };
}
