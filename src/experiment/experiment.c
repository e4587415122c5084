#include "experiment/experiment.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/file.h"
#include "base/inside.h"
#include "base/memory.h"
#include "run/lasting/lasting.h"
#include "run/lasting/lasting_summary.h"
#include "run/out_folder.h"
#include "run/plan/accuracy_levels.h"
#include "run/plan/plan.h"
#include "run/run.h"
#include "run/scoring.h"
#include "viewworth/log.h"

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

// ---- Runs by seed ----

enum { FOLDER_BYTES = 64 };

static void name_folder(uint64_t seed, char name[FOLDER_BYTES]) { snprintf(name, FOLDER_BYTES, "seed_%" PRIu64, seed); }

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
    struct vw_run *run;
    bool over; // as it told by its progress
};

struct group {
    const struct vw_experiment_params *params;
    struct vw_session *session;
    struct member *members; // owned; by run
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

static enum vw_status open_run(struct group *group, uint32_t place, uint32_t device, struct vw_run **run) {
    const struct vw_experiment_params *params = group->params;
    struct vw_config config = *params->config;
    char name[FOLDER_BYTES];
    config.seed += place;
    name_folder(config.seed, name);
    vw_config_settle_decay(&config); // for all runs alike, whether they are new or extended
    char *folder = vw_path_join(params->out, name);
    if (!folder) return VW_ERROR_MEMORY;
    const struct vw_run_params run_params = {.scene = params->scene,
                                             .config = &config,
                                             .out = folder,
                                             .resume = true,
                                             .lasting = params->lasting,
                                             .progress = report_progress,
                                             .context = &group->members[place]};
    vw_log_info("seed     %" PRIu64 " (%u of %u)", config.seed, place + 1, params->seeds);
    enum vw_status status = check_ledger(params->out, name);
    if (!status) status = vw_run_open_in_session(&run_params, group->session, device, run);
    free(folder);
    return status;
}

static enum vw_status end_run(void *context, const struct vw_pool_seat *seat, enum vw_status status) {
    struct member *member = &((struct group *)context)->members[seat->place];
    if (!status) status = vw_run_score(member->run);
    vw_run_close(&member->run);
    member->over = true;
    return status;
}

static enum vw_status begin_run(void *context, const struct vw_pool_seat *seat, enum vw_pool_answer *answer) {
    struct group *group = context;
    struct member *member = &group->members[seat->place];
    member->group = group;
    enum vw_status status = open_run(group, seat->place, seat->device, &member->run);
    if (!status) status = vw_run_begin(member->run, UINT64_MAX);
    (void)answer;
    return status ? end_run(group, seat, status) : VW_OK;
}

static enum vw_status advance_run(void *context, const struct vw_pool_seat *seat, bool *ended) {
    struct group *group = context;
    return vw_run_step(group->members[seat->place].run, ended);
}

static enum vw_status check_out(const char *out) {
    char *ledger_path = vw_path_join(out, "ledger.db");
    if (!ledger_path) return VW_ERROR_MEMORY;
    bool taken = vw_file_exists(ledger_path);
    free(ledger_path);
    if (!taken) return VW_OK;
    return vw_fail(VW_ERROR_USAGE, "--out %s: holds a single run; name another folder for several runs", out);
}

enum vw_status vw_seed_runs_make(const struct vw_experiment_params *params, struct vw_session *session) {
    enum vw_status status = check_out(params->out);
    if (!status) status = vw_experiment_open_session(params, session);
    if (status) return status;
    struct group group = {
        .params = params, .session = session, .members = vw_allocate(params->seeds, sizeof *group.members)};
    const struct vw_training_pool pool = {.devices = session->devices,
                                          .device_count = session->device_count,
                                          .together = params->together,
                                          .begin = begin_run,
                                          .advance = advance_run,
                                          .end = end_run,
                                          .context = &group};
    status = group.members ? vw_training_pool_run(&pool, params->seeds) : VW_ERROR_MEMORY;
    free(group.members);
    return status;
}

char *vw_seed_run_path(const char *out, uint64_t seed, const char *file) {
    char name[FOLDER_BYTES];
    name_folder(seed, name);
    char *folder = vw_path_join(out, name);
    char *path = folder ? vw_path_join(folder, file) : NULL;
    free(folder);
    return path;
}

enum vw_status vw_seed_run_open(const char *out, uint64_t seed, struct vw_ledger **ledger) {
    char name[FOLDER_BYTES];
    name_folder(seed, name);
    char *path = vw_seed_run_path(out, seed, "ledger.db");
    enum vw_status status = path ? check_ledger(out, name) : VW_ERROR_MEMORY;
    if (!status) status = vw_ledger_open(path, ledger);
    free(path);
    return status;
}

// ---- Prices ---------------------------------------------------------------------------------------------------------

enum { VALUE, LASTING, COMPARE, SELECT, WORTH };
const struct vw_priced_command vw_priced_commands[VW_PRICED_COMMANDS] = {
    [VALUE] = {"value", "value", 1},
    [LASTING] = {"lasting", "lasting", 7}, // the backward pass repeats the run; the others are the gate's
    [COMPARE] = {"compare", "compare --list A --list B", 6},
    [SELECT] = {"select", "select", 34}, // two seeds of 5 lists without scores, and of 6 by the scores of either half
    [WORTH] = {"worth", "worth --retrainings 64", 64},
};

// Measures steps with scoring, and without, as those of retrainings are.
static enum vw_status price_level(struct vw_trainer_params params, struct vw_level_prices *prices) {
    struct vw_estimate scored = {.seconds_per_step = NAN}, plain = scored;
    enum vw_status status = vw_estimate_take_steps(&params, &scored);
    params.validate = false;
    if (!status) status = vw_estimate_take_steps(&params, &plain);
    if (status == VW_ERROR_MEMORY) return status;
    if (status) scored = plain = (struct vw_estimate){.seconds_per_step = NAN};
    double run_s = scored.seconds_per_step * (double)scored.steps,
           training_s = plain.seconds_per_step * (double)plain.steps;
    prices->steps = scored.steps;
    for (uint32_t c = 0; c < VW_PRICED_COMMANDS; c++) prices->seconds[c] = vw_priced_commands[c].trainings * training_s;
    prices->seconds[VALUE] = run_s;
    prices->seconds[LASTING] =
        params.config->field == VW_FIELD_SPLATS
            ? NAN
            : vw_lasting_seconds(params.config, vw_lasting_has_gate(params.config), run_s, training_s);
    return VW_OK;
}

enum vw_status vw_prices_estimate(const struct vw_config *config, uint64_t explicit_fields,
                                  const struct vw_scene *scene, struct vw_gpu *gpu,
                                  const struct vw_effect_decision *effects, uint32_t effect_count,
                                  struct vw_level_prices prices[VW_PRICED_LEVELS]) {
    enum vw_status status = VW_OK;
    for (uint32_t level = 0; !status && level < VW_PRICED_LEVELS; level++) {
        struct vw_config at_level = *config;
        vw_accuracy_apply(level, explicit_fields, &at_level);
        prices[level].level = vw_accuracy_level_about(level)->name;
        status = price_level((struct vw_trainer_params){.gpu = gpu,
                                                        .scene = scene,
                                                        .config = &at_level,
                                                        .effects = effects,
                                                        .effect_count = effect_count,
                                                        .validate = true},
                             &prices[level]);
    }
    return status;
}
