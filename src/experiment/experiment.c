#include "experiment/experiment.h"

#include <inttypes.h>

#include "run/out_folder.h"
#include "run/scoring.h"

static enum vw_status check_seeds(uint64_t first, uint64_t count) {
    if (!count || first <= (uint64_t)INT64_MAX - (count - 1)) return VW_OK;
    return vw_fail(VW_ERROR_USAGE,
                   "--seed %" PRIu64 ": the %" PRIu64 " seeds from it on pass %" PRId64
                   ", the largest; take a lower one",
                   first, count, INT64_MAX);
}

enum vw_status vw_experiment_check(const struct vw_experiment_params *params, uint32_t seed_count, bool scores) {
    const struct vw_config *config = params->config;
    enum vw_status status = scores ? vw_check_scored_epochs(config->epochs, config->burn_in_epochs) : VW_OK;
    if (!status) status = check_seeds(config->seed, seed_count);
    return status ? status : vw_out_check(params->out);
}

enum vw_status vw_experiment_open_session(const struct vw_experiment_params *params, struct vw_session *session) {
    return vw_session_open(&(struct vw_session_params){.scene = params->scene, .devices = params->devices}, session);
}
