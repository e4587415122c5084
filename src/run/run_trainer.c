#include "run/run_private.h"

enum vw_status vw_run_create_trainer(struct vw_run *run) {
    struct vw_config config = run->config;
    config.epochs = vw_plan_epochs_most(&run->results.plan, &run->config);
    const struct vw_trainer_params params = {.gpu = run->gpu,
                                             .scene = run->scene,
                                             .config = &config,
                                             .effects = run->effects,
                                             .effect_count = run->effect_count,
                                             .validate = run->validate,
                                             .submissions = run->session->devices[run->device].submissions};
    return vw_trainer_create(&params, &run->trainer);
}
