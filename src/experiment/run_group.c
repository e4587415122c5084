#include "experiment/run_group.h"

#include <stdlib.h>

#include "base/file.h"
#include "base/inside.h"
#include "base/memory.h"
#include "run/run.h"
#include "run/together.h"
#include "viewworth/log.h"

// Refuses links: whoever sent OUT may have put one in the place of the ledger or of its folder.
static enum vw_status check_ledger(const char *out, const char *folder) {
    char *name = vw_path_join(folder, "ledger.db");
    enum vw_status status = name ? vw_folder_check_inside(out, folder) : VW_ERROR_MEMORY;
    if (!status) status = vw_file_check_inside(out, name);
    free(name);
    return status;
}

struct member {
    struct group *group;
    bool over; // as it told by its progress
};

struct group {
    const struct vw_experiment_params *params;
    const struct vw_planned_run *runs;
    struct member members[VW_SESSION_TRAININGS_MAX];
};

// Shows the first run that is not over. Every run asks for the interrupt.
static bool report_progress(void *context, const struct vw_run_state *state) {
    struct member *reporting = context;
    const struct vw_experiment_params *params = reporting->group->params;
    bool shown = params->progress != NULL;
    for (const struct member *member = reporting->group->members; member < reporting; member++) shown &= member->over;
    reporting->over = state->finished;
    bool wanted = !shown || params->progress(params->context, state);
    return wanted && !vw_interrupt_requested(&params->interrupt);
}

static enum vw_status open_run(void *context, uint32_t place, uint32_t device, struct vw_run **run) {
    struct group *group = context;
    const struct vw_experiment_params *params = group->params;
    const struct vw_planned_run *planned = &group->runs[place];
    struct vw_config config = *params->config;
    config.seed = planned->seed;
    char *folder = vw_path_join(params->out, planned->folder);
    if (!folder) return VW_ERROR_MEMORY;
    group->members[place] = (struct member){.group = group, .over = true}; // unless it opens
    const struct vw_run_params run_params = {.scene = planned->scene,
                                             .config = &config,
                                             .out = folder,
                                             .resume = true,
                                             .lasting = params->lasting,
                                             .progress = report_progress,
                                             .context = &group->members[place]};
    vw_log_info("%s", planned->what);
    enum vw_status status = check_ledger(params->out, planned->folder);
    if (!status) status = vw_run_open_in_session(&run_params, planned->session, device, run);
    group->members[place].over = status;
    free(folder);
    return status;
}

static enum vw_status score_run(void *context, uint32_t place, enum vw_status stepped, struct vw_run *run) {
    (void)context, (void)place;
    return stepped ? VW_OK : vw_run_score(run);
}

enum vw_status vw_run_group_make(const struct vw_experiment_params *params, const struct vw_planned_run *runs,
                                 uint32_t count, uint32_t *made) {
    struct group group = {.params = params, .runs = runs};
    const struct vw_together_params together = {runs->session, params->together, open_run, score_run, &group};
    return vw_together_make(&together, count, made);
}

enum vw_status vw_run_group_check_out(const char *out) {
    char *ledger_path = vw_path_join(out, "ledger.db");
    if (!ledger_path) return VW_ERROR_MEMORY;
    bool taken = vw_file_exists(ledger_path);
    free(ledger_path);
    if (!taken) return VW_OK;
    return vw_fail(VW_ERROR_USAGE, "--out %s: holds a single run; name another folder for several runs", out);
}

enum vw_status vw_run_group_open_ledger(const char *out, const char *folder, struct vw_ledger **ledger) {
    char *path = vw_path_join(out, folder), *ledger_path = path ? vw_path_join(path, "ledger.db") : NULL;
    enum vw_status status = ledger_path ? check_ledger(out, folder) : VW_ERROR_MEMORY;
    if (!status) status = vw_ledger_open(ledger_path, ledger);
    free(ledger_path);
    free(path);
    return status;
}
