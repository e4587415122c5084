#include "experiment/seed_runs.h"

#include <inttypes.h>
#include <stdlib.h>

#include "base/file.h"
#include "base/inside.h"
#include "base/memory.h"
#include "run/run.h"
#include "viewworth/log.h"

static char *name_folder(const char *out, uint64_t seed) {
    char *name = vw_format_text("seed_%" PRIu64, seed);
    char *path = name ? vw_path_join(out, name) : NULL;
    free(name);
    return path;
}

// Whoever sent OUT may have put a link in the place of the ledger or of its folder.
static enum vw_status check_ledger(const char *out, uint64_t seed) {
    char *folder = vw_format_text("seed_%" PRIu64, seed), *name = folder ? vw_path_join(folder, "ledger.db") : NULL;
    enum vw_status status = name ? vw_folder_check_inside(out, folder) : VW_ERROR_MEMORY;
    if (!status) status = vw_file_check_inside(out, name);
    free(folder);
    free(name);
    return status;
}

static bool report_progress(void *context, const struct vw_run_state *state) {
    const struct vw_experiment_params *params = context;
    bool wanted = !params->progress || params->progress(params->context, state);
    return wanted && !vw_interrupt_requested(&params->interrupt);
}

static enum vw_status make_run(const struct vw_experiment_params *params, uint64_t seed, struct vw_session *session) {
    struct vw_config config = *params->config;
    config.seed = seed;
    char *folder = name_folder(params->out, seed);
    if (!folder) return VW_ERROR_MEMORY;
    const struct vw_run_params run_params = {.scene = params->scene,
                                             .config = &config,
                                             .device = params->device,
                                             .out = folder,
                                             .resume = true,
                                             .progress = report_progress,
                                             .context = (void *)params};
    struct vw_run *run = NULL;
    enum vw_status status = check_ledger(params->out, seed);
    if (!status) status = vw_run_open_in_session(&run_params, session, &run);
    if (!status) status = vw_run_advance(run, UINT64_MAX);
    if (!status) status = vw_run_score(run);
    vw_run_close(&run);
    free(folder);
    return status;
}

static enum vw_status check_folder(const char *out) {
    char *ledger_path = vw_path_join(out, "ledger.db");
    if (!ledger_path) return VW_ERROR_MEMORY;
    bool taken = vw_file_exists(ledger_path);
    free(ledger_path);
    if (!taken) return VW_OK;
    return vw_fail(VW_ERROR_USAGE, "--out %s: holds a single run; name another folder for the runs of all seeds", out);
}

enum vw_status vw_seed_runs_make(const struct vw_experiment_params *params, struct vw_session *session) {
    uint64_t first = params->config->seed;
    enum vw_status status = check_folder(params->out);
    for (uint32_t i = 0; !status && i < params->seeds; i++) {
        vw_log_info("seed     %" PRIu64 " (%u of %u)", first + i, i + 1, params->seeds);
        status = make_run(params, first + i, session);
    }
    return status;
}

char *vw_seed_run_path(const char *out, uint64_t seed, const char *file) {
    char *folder = name_folder(out, seed);
    char *path = folder ? vw_path_join(folder, file) : NULL;
    free(folder);
    return path;
}

enum vw_status vw_seed_run_open(const char *out, uint64_t seed, struct vw_ledger **ledger) {
    char *path = vw_seed_run_path(out, seed, "ledger.db");
    enum vw_status status = path ? check_ledger(out, seed) : VW_ERROR_MEMORY;
    if (!status) status = vw_ledger_open(path, ledger);
    free(path);
    return status;
}
