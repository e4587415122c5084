#include "experiment/run_group.h"

#include <stdlib.h>

#include "base/file.h"
#include "base/inside.h"
#include "base/memory.h"
#include "gpu/compute.h"
#include "run/run.h"
#include "viewworth/log.h"

// Whoever sent OUT may have put a link in the place of the ledger or of its folder.
static enum vw_status check_ledger(const char *out, const char *folder) {
    char *name = vw_path_join(folder, "ledger.db");
    enum vw_status status = name ? vw_folder_check_inside(out, folder) : VW_ERROR_MEMORY;
    if (!status) status = vw_file_check_inside(out, name);
    free(name);
    return status;
}

struct group;

struct member {
    struct group *group;
    bool over;          // as it told by its progress
    struct vw_run *run; // NULL: not open
};

// The first failure is the one to report; the others go on.
struct group {
    const struct vw_experiment_params *params;
    struct member members[VW_SESSION_TRAININGS_MAX];
    uint32_t count, wanted;
    enum vw_status status;
    struct vw_saved_error why;
};

static void note(struct group *group, enum vw_status status) {
    if (group->status || !status) return;
    group->status = status;
    group->why = vw_error_save();
}

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

static enum vw_status open_run(struct group *group, const struct vw_planned_run *planned, uint32_t device) {
    const struct vw_experiment_params *params = group->params;
    struct member *opened = &group->members[group->count];
    *opened = (struct member){.group = group};
    struct vw_config config = *params->config;
    config.seed = planned->seed;
    char *folder = vw_path_join(params->out, planned->folder);
    if (!folder) return VW_ERROR_MEMORY;
    const struct vw_run_params run_params = {.scene = planned->scene,
                                             .config = &config,
                                             .out = folder,
                                             .resume = true,
                                             .lasting = params->lasting.wanted,
                                             .lasting_rays = params->lasting.rays,
                                             .no_gate = params->lasting.no_gate,
                                             .lasting_matrix = params->lasting.matrix,
                                             .progress = report_progress,
                                             .context = opened};
    enum vw_status status = check_ledger(params->out, planned->folder);
    if (!status) status = vw_run_open_in_session(&run_params, planned->session, device, &opened->run);
    group->count += !status;
    free(folder);
    return status;
}

// The first run shows how much of a device's memory one takes.
static void open_runs(struct group *group, const struct vw_planned_run *runs, uint32_t count, uint32_t *made) {
    const struct vw_experiment_params *params = group->params;
    const struct vw_session_device *devices = runs->session->devices;
    uint32_t device_count = runs->session->device_count;
    uint64_t before = vw_gpu_buffer_bytes(devices->gpu);
    group->wanted = 1;
    for (*made = 0; *made < count && *made < group->wanted; ++*made) {
        const struct vw_planned_run *planned = &runs[*made];
        vw_log_info("%s", planned->what);
        note(group, open_run(group, planned, *made % device_count));
        if (!*made && !group->status)
            group->wanted =
                vw_session_at_a_time(runs->session, params->together, vw_gpu_buffer_bytes(devices->gpu) - before);
    }
}

enum vw_status vw_run_group_make(const struct vw_experiment_params *params, const struct vw_planned_run *runs,
                                 uint32_t count, uint32_t *made) {
    struct group group = {.params = params};
    struct vw_run *opened[VW_SESSION_TRAININGS_MAX];
    enum vw_status statuses[VW_SESSION_TRAININGS_MAX];
    open_runs(&group, runs, count, made);
    for (uint32_t i = 0; i < group.count; i++) opened[i] = group.members[i].run;
    note(&group, vw_runs_advance(opened, group.count, statuses));
    for (uint32_t i = 0; i < group.count; i++)
        if (!statuses[i]) note(&group, vw_run_score(opened[i]));
    for (uint32_t i = 0; i < group.count; i++) vw_run_close(&opened[i]);
    if (group.status) vw_error_restore(&group.why);
    return group.status;
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
