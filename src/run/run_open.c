#include "run/run.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/clock.h"
#include "base/file.h"
#include "base/memory.h"
#include "check/table.h"
#include "detect/effects_text.h"
#include "run/out_folder.h"
#include "run/outputs/run_outputs.h"
#include "run/plan/accuracy_levels.h"
#include "run/plan/plan.h"
#include "run/run_private.h"
#include "run/run_row.h"
#include "run/scoring.h"
#include "run/session.h"
#include "train/adjoint/lasting.h"
#include "train/renderers/splats/splat_file.h"
#include "viewworth/log.h"
#include "viewworth/value.h"

// ---- What is asked for ---------------------------------------------------------------------------------------------

static enum vw_status check_params(const struct vw_run_params *params) {
    if (!params || !params->scene.path || !*params->scene.path)
        return vw_fail(VW_ERROR_USAGE, "vw_run_params.scene.path is missing: name the scene's folder or file");
    if (!params->out || !*params->out)
        return vw_fail(VW_ERROR_USAGE, "vw_run_params.out is missing: name the folder for the results");
    enum vw_status status = params->config ? vw_config_check(params->config) : VW_OK;
    uint32_t level;
    if (!status && params->accuracy) status = vw_accuracy_find(params->accuracy, &level);
    if (!status && params->budget_s != 0) status = vw_budget_check(params->budget_s);
    if (!status && params->train_only &&
        (params->accuracy || params->budget_s > 0 || params->payout || params->lasting.wanted))
        status = vw_fail(VW_ERROR_USAGE, "vw_run_params.train_only excludes accuracy, budget_s, payout and "
                                         "lasting, which need validation: leave them out");
    return status;
}

static enum vw_status copy_params(const struct vw_run_params *params, struct vw_run *run) {
    run->config = params->config ? *params->config : vw_config_default;
    run->out = vw_copy_text(params->out);
    run->resume = params->resume;
    run->validate = !params->train_only;
    run->report = params->report;
    run->lasting = params->lasting;
    run->progress = params->progress;
    run->context = params->context;
    run->results.statistics = vw_step_statistics_begin();
    return run->out ? VW_OK : VW_ERROR_MEMORY;
}

// Refuses to begin from the file that the run replaces.
static enum vw_status check_initial(const struct vw_run *run) {
    struct stat initial, own;
    if (!run->config.initial[0] || stat(run->config.initial, &initial) || stat(run->results.splats_path, &own) ||
        initial.st_dev != own.st_dev || initial.st_ino != own.st_ino)
        return VW_OK;
    return vw_fail(VW_ERROR_USAGE, "--initial %s: is in --out, which replaces it; copy it elsewhere first",
                   run->config.initial);
}

// Refuses a folder with masks of somebody else, some of which this run might replace.
static enum vw_status check_masks(const struct vw_run *run) {
    char *masks = vw_path_join(run->out, VW_OUT_MASKS);
    enum vw_status status = masks ? VW_OK : VW_ERROR_MEMORY;
    if (masks && vw_folder_exists(masks) && !vw_file_exists(run->results.ledger_path))
        status = vw_fail(VW_ERROR_USAGE, "--out %s: has a folder %s but no run; name another folder", run->out,
                         VW_OUT_MASKS);
    free(masks);
    return status;
}

static enum vw_status name_outputs(struct vw_run *run) {
    run->results.ledger_path = vw_path_join(run->out, "ledger.db");
    run->results.scores_path = vw_path_join(run->out, "scores.csv");
    run->results.field_path = vw_path_join(run->out, VW_FIELD_FILE);
    run->results.splats_path = vw_path_join(run->out, VW_SPLATS_FILE);
    if (!run->results.ledger_path || !run->results.scores_path || !run->results.field_path || !run->results.splats_path)
        return VW_ERROR_MEMORY;
    enum vw_status status = vw_out_check(run->out);
    if (!status) status = check_initial(run);
    if (!status) status = check_masks(run);
    if (!status) status = vw_out_lock_take(run->out, &run->lock);
    if (!status && vw_file_exists(run->results.ledger_path) && !run->resume)
        status =
            vw_fail(VW_ERROR_USAGE,
                    "--out %s: already contains a run; continue it with --resume, or name another folder", run->out);
    if (!status && vw_file_exists(run->results.ledger_path))
        status = vw_ledger_open_to_append(run->results.ledger_path, &run->ledger);
    return status ? status : vw_checkpoints_open(run->out, &run->checkpoints);
}

// ---- Field and size -------------------------------------------------------------------------------------------------

// Takes what the run in OUT has where the request leaves it open. Returns whether there is such a run.
static bool take_recorded_choice(struct vw_run *run, struct vw_run_params *params) {
    struct vw_ledger_run row;
    struct vw_config recorded;
    struct vw_scene_params options;
    json_t *texts = NULL;
    if (!run->ledger || vw_ledger_get_run(run->ledger, &row) || vw_config_from_json(row.config_json, &recorded) ||
        vw_scene_options_from_json(row.scene_options_json, &texts, &options))
        return false; // an imported one is refused later
    if (run->config.field == VW_FIELD_AUTO) vw_config_take_field(recorded.field, params->explicit_fields, &run->config);
    if (!params->scene.downscale) params->scene.downscale = options.downscale;
    json_decref(texts);
    return true;
}

// Chooses field and size where the request leaves them open; what depends on them is read afterwards. Runs that share a
// session have both.
static enum vw_status choose(struct vw_run *run, struct vw_run_params *params) {
    const struct vw_session_params session = {.devices.first = params->device, .timers = params->profile};
    bool open = run->config.field == VW_FIELD_AUTO || !params->scene.downscale;
    enum vw_status status = VW_OK;
    if (open && run->session == &run->own && !take_recorded_choice(run, params)) {
        status = vw_session_open_devices(&session, run->session);
        if (status) return status;
        const struct vw_training_choice_params choice = {.gpu = run->session->devices[0].gpu,
                                                         .accuracy = params->accuracy,
                                                         .explicit_fields = params->explicit_fields,
                                                         .lasting = params->lasting.wanted};
        status = vw_training_choose(&choice, &params->scene, &run->config, &run->choice);
    }
    if (!status && run->config.initial[0]) status = vw_splats_begin_from(run->config.initial, &run->config);
    if (!status) status = vw_attribution_read_payout(params->payout, &run->config, &run->payout_cents);
    if (!status && run->lasting.wanted) status = vw_lasting_check_config(&run->config);
    params->config = &run->config;
    run->results.downscale = params->scene.downscale;
    run->scene_options_json = status ? NULL : vw_scene_options_to_json(&params->scene);
    return status || run->scene_options_json ? status : VW_ERROR_MEMORY;
}

// ---- Effects -------------------------------------------------------------------------------------------------------

static void log_effects(const struct vw_run *run) {
    char line[VW_EFFECT_LINE_BYTES];
    vw_effects_to_line(run->effects, run->effect_count, line);
    vw_log_info("effects  %s", line);
}

// Reads the effects that were on when the run began, even if this device or version would find others, and applies the
// config's effects to them.
static enum vw_status take_recorded_effects(struct vw_run *run) {
    struct vw_ledger_run recorded;
    enum vw_status status = vw_ledger_get_run(run->ledger, &recorded);
    if (!status) status = vw_effects_from_json(recorded.effects_json, run->effects, &run->effect_count);
    if (!status) status = vw_effects_choose(run->config.effects, run->effects, run->effect_count);
    return status ? status : vw_effects_follow_field(&run->config, run->effects, run->effect_count);
}

static enum vw_status decide_effects(struct vw_run *run) {
    if (run->ledger) return take_recorded_effects(run);
    enum vw_status status = vw_session_decide_effects(&run->config, run->session);
    if (status) return status;
    run->effect_count = run->session->effect_count;
    memcpy(run->effects, run->session->effects, sizeof run->effects);
    return vw_effects_follow_field(&run->config, run->effects, run->effect_count);
}

// ---- Resuming ------------------------------------------------------------------------------------------------------

static enum vw_status read_steps(struct vw_run *run) {
    struct vw_step_record *records = NULL;
    uint64_t count = 0;
    enum vw_status status = vw_ledger_get_steps(run->ledger, &records, &count);
    for (uint64_t i = 0; !status && i < count; i++) vw_step_statistics_add(&run->results.statistics, &records[i]);
    free(records);
    return status;
}

static enum vw_status load_checkpoint(struct vw_run *run) {
    uint64_t recorded = vw_ledger_next_step(run->ledger), last_step = recorded - 1;
    bool found = false;
    enum vw_status status = VW_OK;
    if (recorded > 1) // at least one step is taken again, to see that device and checkpoint still do as they did
        status = vw_checkpoints_load(&run->checkpoints, run->trainer, last_step - 1, &found, &run->started_after);
    run->trainer_step = run->started_after;
    if (!status && recorded > 0)
        vw_log_info("resume   %s step %" PRIu64 "; steps up to %" PRIu64 " are recorded and will be compared",
                    found ? "from the checkpoint of" : "without a checkpoint, from", run->started_after, last_step);
    return status;
}

// Compares the steps that are recorded with those that are asked for.
static enum vw_status compare_extent(struct vw_run *run, const struct vw_ledger_run *recorded) {
    uint64_t end = vw_ledger_next_step(run->ledger), wanted = vw_trainer_total_steps(run->trainer) + 1;
    bool finished = strcmp(recorded->status, "finished") == 0;
    run->complete = finished && (end >= wanted || vw_plan_keeps_time(&run->results.plan));
    if (run->complete)
        vw_log_info("resume   %s is finished after step %" PRIu64 ": no step is left to take", run->out, end - 1);
    else if (end > wanted)
        return vw_fail(VW_ERROR_USAGE,
                       "--resume: %s holds %" PRIu64 " steps already, more than --epochs %u takes; ask for more",
                       run->out, end - 1, vw_plan_epochs_most(&run->results.plan, &run->config));
    return VW_OK;
}

// Opens the recorded run at its end and loads the newest usable checkpoint into run->trainer (decision 11), or sets
// run->complete when no step is left. VW_ERROR_USAGE, naming what differs, when the ledger is of another run or has
// more steps than are asked for; VW_ERROR_MISMATCH when it was edited.
static enum vw_status resume(struct vw_run *run) {
    struct vw_ledger_run recorded;
    struct vw_run_row ours = {0};
    enum vw_status status = vw_ledger_get_run(run->ledger, &recorded);
    if (!status) status = vw_run_row_make(run->trainer, run->gpu, run->scene, &run->config, &ours);
    if (!status) status = vw_run_row_check_same(&ours, &recorded, run->out);
    if (!status) status = read_steps(run);
    if (!status) status = compare_extent(run, &recorded);
    if (!status && !run->complete) status = vw_ledger_extend(run->ledger, ours.row.config_json);
    if (!status && !run->complete) status = load_checkpoint(run);
    vw_run_row_free(&ours);
    return status;
}

// ---- Opening -------------------------------------------------------------------------------------------------------

static void log_field(const struct vw_run *run) {
    struct vw_trainer_stats stats;
    vw_trainer_get_stats(run->trainer, &stats);
    vw_log_info("field    %" PRIu64 " params, %.1f MiB on the device; %s%" PRIu64 " steps", stats.param_count,
                (double)stats.device_bytes / 0x1p20, vw_plan_keeps_time(&run->results.plan) ? "about " : "",
                vw_run_expected_steps(run));
}

static void log_line(const char *line) { vw_log_info("%s", line); }

// Checks the photos of a run that has steps to take, and logs those with defects: it may train for long.
static enum vw_status look_at_photos(struct vw_run *run) {
    enum vw_status status = vw_run_check_photos(run->scene, run->scene_options_json, run->gpu, &run->findings);
    if (!status) vw_photo_findings_tell(run->scene, run->findings, log_line);
    return status;
}

static enum vw_status open_on_session(struct vw_run *run, const struct vw_session_params *params) {
    enum vw_status status = vw_session_open(params, run->session);
    if (status) return status;
    run->gpu = run->session->devices[run->device].gpu;
    run->scene = run->session->scene;
    run->results.device = vw_gpu_get_info(run->gpu);
    run->results.scene = run->scene;
    status = vw_scene_options_note(run->scene, &run->scene_options_json);
    if (status) return status;
    if (run->payout_cents) status = vw_attribution_check_scene(run->scene);
    if (!status) status = decide_effects(run);
    if (status) return status;
    log_effects(run);
    run->results.effects = run->effects;
    run->results.effect_count = run->effect_count;
    status = vw_run_create_trainer(run);
    if (!status && run->lasting.wanted) status = vw_lasting_check_trainer(run->trainer);
    if (status) return status;
    log_field(run);
    if (run->ledger) status = resume(run);
    bool looks = run->validate && !run->complete && run->session == &run->own; // many runs share a session
    return !status && looks ? look_at_photos(run) : status;
}

// Settles over how many epochs the rate falls: those of a resumed run stay, so that more epochs extend it.
static enum vw_status settle_decay(struct vw_run *run) {
    struct vw_ledger_run row;
    struct vw_config recorded = {0};
    struct vw_config *config = &run->config;
    bool settled = vw_config_rate_is_constant(config) || config->decay_epochs;
    enum vw_status status = run->ledger && !settled ? vw_ledger_get_run(run->ledger, &row) : VW_OK;
    if (status) return status;
    bool read = run->ledger && !settled && !vw_config_from_json(row.config_json, &recorded); // an imported one is not
    if (read) config->decay_epochs = recorded.decay_epochs;
    vw_config_settle_decay(config);
    return VW_OK;
}

// Locks OUT first; then the plan chooses the config of the trainer.
static enum vw_status open_run(const struct vw_run_params *asked, struct vw_run *run) {
    struct vw_run_params params = *asked;
    enum vw_status status = copy_params(&params, run);
    if (!status) status = name_outputs(run);
    if (!status) status = choose(run, &params);
    const struct vw_session_params session = {
        .scene = params.scene, .devices.first = params.device, .timers = params.profile};
    if (!status && run->session == &run->own && run->validate)
        status = vw_plan_make(&params, run->ledger, run->session, &run->config, &run->results.plan);
    if (!status && !run->ledger) status = vw_plan_note_choice(&run->choice, &run->results.plan);
    if (!status) status = settle_decay(run);
    if (status) return status;
    uint32_t epochs = vw_plan_epochs_most(&run->results.plan, &run->config);
    if (run->validate && epochs <= run->config.burn_in_epochs)
        vw_log_warning("--epochs %u leaves no epoch after --burn-in %u: steps are recorded, but no scores", epochs,
                       run->config.burn_in_epochs);
    return open_on_session(run, &session);
}

static enum vw_status make_run(const struct vw_run_params *params, struct vw_session *session, uint32_t device,
                               struct vw_run **run) {
    enum vw_status status = run ? check_params(params) : vw_fail(VW_ERROR_USAGE, "vw_run_open: run is NULL");
    struct vw_run *made = status ? NULL : vw_allocate(1, sizeof *made);
    if (!made) return status ? status : VW_ERROR_MEMORY;
    made->results.plan.started_s = vw_now_s();
    made->results.config = &made->config;
    made->session = session ? session : &made->own;
    made->device = device;
    status = open_run(params, made);
    if (status) vw_run_close(&made);
    else *run = made;
    return status;
}

enum vw_status vw_run_open(const struct vw_run_params *params, struct vw_run **run) {
    return make_run(params, NULL, 0, run);
}

enum vw_status vw_run_open_in_session(const struct vw_run_params *params, struct vw_session *session, uint32_t device,
                                      struct vw_run **run) {
    if (params && (params->accuracy || params->budget_s > 0))
        return vw_fail(VW_ERROR_USAGE,
                       "runs that share a session take neither an accuracy level nor a budget: set their config");
    return make_run(params, session, device, run);
}

static void free_results(struct vw_run *run) {
    vw_run_outputs_free(&run->results.outputs);
    vw_scoring_free(&run->results.scoring);
    vw_lasting_summary_free(&run->results.lasting);
    free(run->ranked);
}

void vw_run_close(struct vw_run **run) {
    struct vw_run *closed = *run;
    if (!closed) return;
    struct vw_saved_error why = vw_error_save(); // closing may follow a failure
    vw_run_leave(closed);
    free_results(closed);
    vw_ledger_writer_destroy(&closed->writer);
    vw_ledger_close(&closed->ledger);
    vw_checkpoints_close(&closed->checkpoints);
    vw_trainer_destroy(&closed->trainer);
    vw_session_close(&closed->own);
    vw_plan_free(&closed->results.plan);
    vw_out_lock_release(&closed->lock);
    free(closed->results.ledger_path);
    free(closed->results.scores_path);
    free(closed->results.field_path);
    free(closed->results.splats_path);
    free(closed->scene_options_json);
    free(closed->findings);
    free(closed->out);
    free(closed);
    *run = NULL;
    vw_error_restore(&why);
}
