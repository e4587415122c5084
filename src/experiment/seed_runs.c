#include "experiment/seed_runs.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/file.h"
#include "base/memory.h"
#include "experiment/run_group.h"

static void name_folder(uint64_t seed, char name[VW_PLANNED_RUN_BYTES]) {
    snprintf(name, VW_PLANNED_RUN_BYTES, "seed_%" PRIu64, seed);
}

static void plan(const struct vw_experiment_params *params, struct vw_session *session, struct vw_planned_run *runs) {
    for (uint32_t i = 0; i < params->seeds; i++) {
        uint64_t seed = params->config->seed + i;
        runs[i] = (struct vw_planned_run){.seed = seed, .scene = params->scene, .session = session};
        name_folder(seed, runs[i].folder);
        snprintf(runs[i].what, sizeof runs[i].what, "seed     %" PRIu64 " (%u of %u)", seed, i + 1, params->seeds);
    }
}

enum vw_status vw_seed_runs_make(const struct vw_experiment_params *params, struct vw_session *session) {
    struct vw_planned_run *runs = vw_allocate(params->seeds, sizeof *runs);
    if (!runs) return VW_ERROR_MEMORY;
    plan(params, session, runs);
    enum vw_status status = vw_run_group_check_out(params->out);
    if (!status) status = vw_experiment_open_session(params, session);
    for (uint32_t done = 0, made; !status && done < params->seeds; done += made)
        status = vw_run_group_make(params, runs + done, params->seeds - done, &made);
    free(runs);
    return status;
}

char *vw_seed_run_path(const char *out, uint64_t seed, const char *file) {
    char name[VW_PLANNED_RUN_BYTES];
    name_folder(seed, name);
    char *folder = vw_path_join(out, name);
    char *path = folder ? vw_path_join(folder, file) : NULL;
    free(folder);
    return path;
}

enum vw_status vw_seed_run_open(const char *out, uint64_t seed, struct vw_ledger **ledger) {
    char name[VW_PLANNED_RUN_BYTES];
    name_folder(seed, name);
    return vw_run_group_open_ledger(out, name, ledger);
}
