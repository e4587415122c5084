#include "experiment/seed_runs.h"

#include <inttypes.h>
#include <stdlib.h>

#include "cli/interrupt.h"
#include "cli/output/progress.h"
#include "cli/params.h"
#include "run/run.h"
#include "base/file.h"
#include "viewworth/log.h"
#include "base/memory.h"

static char *name_folder(const char *out, uint64_t seed) {
    char *name = vw_format_text("seed_%" PRIu64, seed);
    char *path = name ? vw_path_join(out, name) : NULL;
    free(name);
    return path;
}

static enum vw_status make_run(const struct vw_options *options, struct vw_session *session) {
    struct vw_progress progress = {.quiet = options->quiet};
    struct vw_run_params params;
    struct vw_run *run = NULL;
    enum vw_status status = vw_params_of_run(options, &params);
    params.progress = vw_progress_show;
    params.context = &progress;
    if (!status) status = vw_run_open_in_session(&params, session, &run);
    if (!status) progress.interrupt = vw_interrupt_watch();
    if (!status) status = vw_run_advance(run, UINT64_MAX);
    vw_progress_end(&progress);
    if (!status) status = vw_run_score(run);
    vw_run_close(&run);
    return status;
}

static enum vw_status make_seed(const struct vw_options *options, uint64_t seed, struct vw_session *session) {
    struct vw_options of_seed = *options;
    char *folder = name_folder(options->out, seed);
    of_seed.out = folder;
    of_seed.config.seed = seed;
    of_seed.resume = true;
    enum vw_status status = folder ? make_run(&of_seed, session) : VW_ERROR_MEMORY;
    free(folder);
    return status;
}

static enum vw_status check_folder(const char *out) {
    if (vw_file_exists(out)) return vw_fail(VW_ERROR_USAGE, "--out %s: is a file; name a folder", out);
    char *ledger_path = vw_path_join(out, "ledger.db");
    if (!ledger_path) return VW_ERROR_MEMORY;
    bool taken = vw_file_exists(ledger_path);
    free(ledger_path);
    if (taken)
        return vw_fail(VW_ERROR_USAGE, "--out %s: holds a single run; name another folder for the runs of all seeds",
                       out);
    return VW_OK;
}

enum vw_status vw_seed_runs_make(const struct vw_options *options, uint32_t first_seed_offset, uint32_t count) {
    uint64_t first = options->config.seed + first_seed_offset;
    if (count && first > (uint64_t)INT64_MAX - (count - 1))
        return vw_fail(VW_ERROR_USAGE,
                       "--seed %" PRIu64 ": the seeds counted from it pass %" PRId64
                       ", the largest; begin with a lower one",
                       options->config.seed, INT64_MAX);
    struct vw_session session = {0};
    enum vw_status status = check_folder(options->out);
    for (uint32_t i = 0; !status && i < count; i++) {
        vw_log_info("seed     %" PRIu64 " (%u of %u)", first + i, i + 1, count);
        status = make_seed(options, first + i, &session);
    }
    vw_session_close(&session);
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
    enum vw_status status = path ? vw_ledger_open(path, ledger) : VW_ERROR_MEMORY;
    free(path);
    return status;
}
