#include "experiment/seed_runs.h"

#include <inttypes.h>
#include <stdlib.h>

#include "base/file.h"
#include "base/inside.h"
#include "base/memory.h"
#include "gpu/compute.h"
#include "run/run.h"
#include "train/submissions.h"
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

// ---- Runs together ----

struct group;

struct seed_run {
    struct group *group;
    uint64_t seed;
    bool over;          // as it told by its progress
    struct vw_run *run; // NULL: not open
};

// Runs that take their steps together. The first failure is the one to report; the others go on.
struct group {
    const struct vw_experiment_params *params;
    struct vw_session *session;
    struct seed_run runs[VW_TRAINERS_TOGETHER_MAX];
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
    struct seed_run *reporting = context;
    const struct vw_experiment_params *params = reporting->group->params;
    bool shown = params->progress != NULL;
    for (const struct seed_run *run = reporting->group->runs; run < reporting; run++) shown &= run->over;
    reporting->over = state->finished;
    bool wanted = !shown || params->progress(params->context, state);
    return wanted && !vw_interrupt_requested(&params->interrupt);
}

static enum vw_status open_run(struct group *group, uint64_t seed) {
    const struct vw_experiment_params *params = group->params;
    struct seed_run *opened = &group->runs[group->count];
    *opened = (struct seed_run){.group = group, .seed = seed};
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
                                             .context = opened};
    enum vw_status status = check_ledger(params->out, seed);
    if (!status) status = vw_run_open_in_session(&run_params, group->session, &opened->run);
    group->count += !status;
    free(folder);
    return status;
}

static uint64_t device_bytes(const struct vw_session *session) {
    return session->gpu ? vw_gpu_buffer_bytes(session->gpu) : 0;
}

// The first run shows how much of the device's memory one takes.
static void open_runs(struct group *group, uint32_t first, uint32_t *next) {
    const struct vw_experiment_params *params = group->params;
    uint64_t before = device_bytes(group->session);
    group->wanted = 1;
    for (*next = first; *next < params->seeds && *next - first < group->wanted; ++*next) {
        uint64_t seed = params->config->seed + *next;
        vw_log_info("seed     %" PRIu64 " (%u of %u)", seed, *next + 1, params->seeds);
        note(group, open_run(group, seed));
        if (*next == first && !group->status)
            group->wanted = vw_experiment_together(params, group->session, device_bytes(group->session) - before);
    }
}

static enum vw_status make_group(const struct vw_experiment_params *params, struct vw_session *session, uint32_t first,
                                 uint32_t *next) {
    struct group group = {.params = params, .session = session};
    struct vw_run *runs[VW_TRAINERS_TOGETHER_MAX];
    enum vw_status statuses[VW_TRAINERS_TOGETHER_MAX];
    open_runs(&group, first, next);
    for (uint32_t i = 0; i < group.count; i++) runs[i] = group.runs[i].run;
    note(&group, vw_runs_advance(runs, group.count, statuses));
    for (uint32_t i = 0; i < group.count; i++)
        if (!statuses[i]) note(&group, vw_run_score(runs[i]));
    for (uint32_t i = 0; i < group.count; i++) vw_run_close(&runs[i]);
    if (group.status) vw_error_restore(&group.why);
    return group.status;
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
    enum vw_status status = check_folder(params->out);
    for (uint32_t next = 0; !status && next < params->seeds;) status = make_group(params, session, next, &next);
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
