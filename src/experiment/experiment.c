#include "experiment/experiment.h"

#include "run/checks.h"
#include "run/out_folder.h"

enum vw_status vw_experiment_check(const struct vw_experiment_params *params, uint32_t seed_count, bool scores) {
    const struct vw_config *config = params->config;
    enum vw_status status = scores ? vw_check_scored_epochs(config->epochs, config->burn_in_epochs) : VW_OK;
    if (!status) status = vw_check_seeds(config->seed, seed_count);
    return status ? status : vw_out_check(params->out);
}

enum vw_status vw_experiment_open_session(const struct vw_experiment_params *params, struct vw_session *session) {
    return vw_session_open(&(struct vw_session_params){.scene = params->scene, .devices = params->devices}, session);
}
