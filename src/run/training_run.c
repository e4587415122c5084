#include "run/training_run.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cli/params.h"
#include "run/plan/plan.h"
#include "cli/output/effects_output.h"
#include "run/stop_rules.h"
#include "cli/interrupt.h"
#include "cli/output/json_output.h"
#include "run/open.h"
#include "run/out_folder.h"
#include "run/resume.h"
#include "run/identity.h"
#include "run/scoring.h"
#include "base/utc.h"
#include "base/file.h"
#include "viewworth/log.h"
#include "base/memory.h"
#include "train/trainer.h"
#include "base/hash.h"
#include "report/report.h"

// ---- Opening
// ----------------------------------------------------------------------------------------------------------

static enum vw_status name_outputs(struct vw_training_run *run) {
    const char *out = run->options->out;
    run->ledger_path = vw_path_join(out, "ledger.db");
    run->scores_path = vw_path_join(out, "scores.csv");
    run->field_path = vw_path_join(out, "field.vwf");
    if (!run->ledger_path || !run->scores_path || !run->field_path) return VW_ERROR_MEMORY;
    if (vw_file_exists(out)) return vw_fail(VW_ERROR_USAGE, "--out %s: is a file; name a folder", out);
    if (vw_file_exists(run->ledger_path) && !run->options->resume)
        return vw_fail(VW_ERROR_USAGE,
                       "--out %s: holds a run already; go on with it by --resume, or name another folder", out);
    enum vw_status status = vw_checkpoints_open(out, &run->checkpoints);
    return status ? status : vw_out_check(out);
}

static void say_effects(const struct vw_training_run *run) {
    vw_log_info("%s", vw_effects_heading);
    for (uint32_t i = 0; i < run->effect_count; i++) {
        char line[VW_EFFECT_LINE_BYTES];
        vw_effect_to_line(&run->effects[i], line);
        vw_log_info("%s", line);
    }
}

// What a run goes on with is what was called for when it began, though this device or version might see it otherwise;
// --effects is heard.
static enum vw_status take_recorded_effects(struct vw_training_run *run) {
    struct vw_ledger *ledger = NULL;
    struct vw_ledger_run recorded;
    enum vw_status status = vw_ledger_open(run->ledger_path, &ledger);
    if (!status) status = vw_ledger_get_run(ledger, &recorded);
    if (!status) status = vw_effects_from_json(recorded.effects_json, run->effects, &run->effect_count);
    if (!status) status = vw_effects_choose(run->options->config.effects, run->effects, run->effect_count);
    vw_ledger_close(&ledger);
    return status;
}

static enum vw_status decide_effects(struct vw_training_run *run, struct vw_session *session) {
    if (vw_file_exists(run->ledger_path)) return take_recorded_effects(run);
    enum vw_status status = vw_session_decide_effects(run->options->config.effects, session);
    if (status) return status;
    run->effect_count = session->effect_count;
    memcpy(run->effects, session->effects, sizeof run->effects);
    return VW_OK;
}

static void say_field(const struct vw_training_run *run) {
    struct vw_trainer_stats stats;
    vw_trainer_get_stats(run->trainer, &stats);
    vw_log_info("field    %" PRIu64 " params, %.1f MiB on the device; %s%" PRIu64 " steps", stats.param_count,
                (double)stats.device_bytes / 0x1p20, vw_plan_clock(run->options) ? "about " : "",
                vw_stop_rules_expected_steps(run));
}

enum vw_status vw_training_open(const struct vw_options *options, bool validate, struct vw_session *session,
                                struct vw_training_run *run) {
    *run = (struct vw_training_run){
        .options = options, .opened_s = vw_now_s(), .validate = validate, .statistics = vw_step_statistics_begin()};
    const struct vw_session_params session_params = vw_params_of_session(options);
    enum vw_status status = name_outputs(run);
    if (!status) status = vw_session_open(&session_params, session);
    if (status) return status;
    run->gpu = session->gpu;
    run->scene = session->scene;
    status = decide_effects(run, session);
    if (status) return status;
    say_effects(run);
    struct vw_config config = options->config;
    config.epochs = vw_plan_epochs_most(options);
    const struct vw_trainer_params params = {.gpu = run->gpu,
                                             .scene = run->scene,
                                             .config = &config,
                                             .effects = run->effects,
                                             .effect_count = run->effect_count,
                                             .validate = validate};
    status = vw_trainer_create(&params, &run->trainer);
    if (status) return status;
    say_field(run);
    return vw_file_exists(run->ledger_path) ? vw_training_resume(run) : VW_OK;
}

void vw_training_close(struct vw_training_run *run) {
    vw_ledger_close(&run->ledger);
    vw_checkpoints_close(&run->checkpoints);
    vw_trainer_destroy(&run->trainer);
    free(run->ledger_path);
    free(run->scores_path);
    free(run->field_path);
}

// ---- The ledger
// -------------------------------------------------------------------------------------------------------

static enum vw_status list_images(const struct vw_scene *scene, struct vw_ledger_image **images,
                                  char (**hashes)[VW_HASH_HEX_BYTES]) {
    *images = vw_allocate(scene->view_count, sizeof **images);
    *hashes = vw_allocate(scene->view_count, sizeof **hashes);
    if (!*images || !*hashes) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < scene->view_count; i++) {
        const struct vw_view *view = &scene->views[i];
        vw_hash_to_hex(view->sha256, (*hashes)[i]);
        (*images)[i] = (struct vw_ledger_image){
            .image_id = i,
            .name = view->name,
            .split = vw_split_name(view->split),
            .provider = view->provider,
            .sha256 = (*hashes)[i],
            .ground_truth = view->ground_truth,
        };
    }
    return VW_OK;
}

static enum vw_status write_first_rows(struct vw_training_run *run, const struct vw_ledger_image *images) {
    struct vw_run_row first;
    char started_utc[VW_UTC_BYTES];
    const struct vw_scene_params scene = vw_params_of_scene(run->options);
    char *scene_options_json = vw_scene_options_to_json(&scene);
    enum vw_status status = vw_run_row_make(run->trainer, run->gpu, run->scene, &run->options->config, &first);
    if (!status && !scene_options_json) status = VW_ERROR_MEMORY;
    vw_utc_now(started_utc);
    first.row.started_utc = started_utc;
    first.row.scene_options_json = scene_options_json;
    first.row.plan_json = run->options->plan ? run->options->plan->json : NULL;
    if (!status) status = vw_ledger_create(run->ledger_path, &first.row, images, run->scene->view_count, &run->ledger);
    vw_run_row_free(&first);
    free(scene_options_json);
    return status;
}

static enum vw_status create_ledger(struct vw_training_run *run) {
    struct vw_ledger_image *images = NULL;
    char(*hashes)[VW_HASH_HEX_BYTES] = NULL;
    bool existed = vw_folder_exists(run->options->out);
    enum vw_status status = list_images(run->scene, &images, &hashes);
    if (!status) status = vw_folder_create(run->options->out);
    if (!status) status = write_first_rows(run, images);
    if (status && !existed) rmdir(run->options->out); // leaves it when something else came to be in it
    free(images);
    free(hashes);
    return status;
}

// Closes the books on a run that stops early; the message of what stopped it stays. A run that had ended before and to
// which nothing was added is left as it was.
static void finish_early(struct vw_training_run *run, enum vw_status status) {
    struct vw_ledger_run row;
    struct vw_saved_error why = vw_error_save();
    if (!vw_ledger_get_run(run->ledger, &row) && strcmp(row.status, "running") == 0 && status != VW_ERROR_MISMATCH) {
        char finished_utc[VW_UTC_BYTES];
        vw_utc_now(finished_utc);
        const char *outcome = status == VW_ERROR_INTERRUPTED ? "interrupted" : "failed";
        struct vw_scoring scoring; // the scores so far, or none
        (void)vw_scoring_make(run->ledger, &run->options->config, &scoring);
        if (vw_ledger_finish(run->ledger, outcome, finished_utc, scoring.scores, scoring.score_count) &&
            vw_ledger_finish(run->ledger, outcome, finished_utc, NULL, 0)) // a full disk may have no room for scores
            vw_log_warning("%s", vw_error_message());
        vw_scoring_free(&scoring);
    }
    vw_error_restore(&why);
}

// ---- The steps
// --------------------------------------------------------------------------------------------------------

static enum vw_status check_nonfinite(const struct vw_training_run *run) {
    if (!vw_step_statistics_should_abort(&run->statistics)) return VW_OK;
    return vw_fail(VW_ERROR_DEVICE,
                   "stopped at step %" PRIu64 ": %" PRIu64
                   " steps were not finite, more than %.0f %%; %s keeps them; try a lower --lr",
                   run->statistics.steps, run->statistics.nonfinite, 100 * vw_step_statistics_nonfinite_max,
                   run->ledger_path);
}

// Compares the steps that the ledger knows and appends the others, up to the one with which too many are not finite.
static enum vw_status record(struct vw_training_run *run, const struct vw_step_record *records, uint32_t count) {
    uint32_t validation_count = 0, known = 0, added = 0;
    const uint32_t *validation_views = vw_trainer_validation_views(run->trainer, &validation_count);
    uint64_t next_step = vw_ledger_next_step(run->ledger);
    while (known < count && records[known].step < next_step) known++;
    enum vw_status status = known ? vw_ledger_compare(run->ledger, records, known, validation_views) : VW_OK;
    while (!status && known + added < count && !vw_step_statistics_should_abort(&run->statistics))
        vw_step_statistics_add(&run->statistics, &records[known + added++]);
    if (!status && added) status = vw_ledger_append(run->ledger, records + known, added, validation_views);
    return status ? status : check_nonfinite(run);
}

static void show(const struct vw_training_run *run, const struct vw_step_record *last, struct vw_progress *progress) {
    if (progress->done_steps == run->started_after)
        vw_log_info("start    first steps after %.2f s", vw_now_s() - run->opened_s);
    progress->done_steps = last->step;
    progress->epoch = last->epoch;
    progress->val_psnr_db = run->statistics.last_val_psnr_db;
    vw_progress_update(progress);
}

static enum vw_status check_interrupt(const struct vw_training_run *run) {
    if (!vw_interrupt_requested()) return VW_OK;
    return vw_fail(VW_ERROR_INTERRUPTED,
                   "interrupted; %s keeps the %" PRIu64 " steps recorded so far; go on by --resume", run->ledger_path,
                   run->statistics.steps);
}

// Batch after batch, and epoch after epoch where the run is held at their ends. For a checkpoint, and to stop, what is
// in flight is collected first. The end is not saved twice: an older checkpoint is worth more than a second one of the
// same step.
static enum vw_status take_batches(struct vw_training_run *run, struct vw_progress *progress) {
    const struct vw_step_record *records = NULL;
    uint32_t count = 0;
    bool moved = true; // since the last checkpoint
    for (enum vw_status status = VW_OK;;) {
        bool settle = run->ledger && (vw_interrupt_requested() || vw_checkpoints_due(&run->checkpoints));
        status = settle ? vw_trainer_collect(run->trainer, &records, &count)
                        : vw_trainer_advance(run->trainer, &records, &count);
        if (!status && count > 0 && !run->ledger) status = create_ledger(run);
        if (!status && count > 0) status = record(run, records, count);
        if (!status && count > 0) show(run, &records[count - 1], progress);
        moved |= count > 0;
        bool goes_on = false; // with the next epoch
        if (!status && count == 0 && !settle) status = vw_stop_rules_pass(run, &goes_on);
        if (goes_on) {
            progress->total_steps = vw_stop_rules_expected_steps(run);
            progress->epochs = (uint32_t)(progress->total_steps / vw_trainer_epoch_end(run->trainer, 1));
            continue;
        }
        if (!status && count == 0 && (settle || moved)) {
            vw_checkpoints_save(&run->checkpoints, run->trainer); // which also says when the next is due
            moved = false;
        }
        if (!status && count == 0 && settle) status = check_interrupt(run);
        if (status || (count == 0 && !settle)) return status;
    }
}

enum vw_status vw_training_take_steps(struct vw_training_run *run) {
    if (run->complete) return VW_OK;
    struct vw_progress progress = {
        .total_steps = vw_stop_rules_expected_steps(run),
        .done_steps = run->started_after,
        .epochs = (uint32_t)(vw_stop_rules_expected_steps(run) / vw_trainer_epoch_end(run->trainer, 1)),
        .val_psnr_db = NAN,
    };
    vw_interrupt_watch();
    enum vw_status status = check_nonfinite(run);
    if (!status) status = vw_stop_rules_begin(run);
    if (status) return status;
    vw_progress_begin(&progress);
    vw_checkpoints_begin(&run->checkpoints);
    status = take_batches(run, &progress);
    if (run->ledger) vw_progress_end(&progress);
    if (!status && run->options->profile && vw_profile_make(run->trainer, run->gpu, &run->profile))
        vw_log_warning("--profile: %s", vw_error_message()); // no reason to fail the run
    if (status && run->ledger) finish_early(run, status);
    return status;
}

static void say_oddities(const struct vw_step_statistics *statistics) {
    if (statistics->nonfinite > 0)
        vw_log_warning(
            "%" PRIu64
            " steps were not finite and carry no value (step.nonfinite in the ledger); a lower --lr may help",
            statistics->nonfinite);
    if (statistics->floored > 0)
        vw_log_info(
            "%" PRIu64
            " steps have validation photos matched beyond 100 dB, where PSNR is cut (step.floored in the ledger)",
            statistics->floored);
    if (statistics->clamped > 0)
        vw_log_info("%" PRIu64
                    " gradient contributions were clamped to the fixed-point range (step.clamped in the ledger)",
                    statistics->clamped);
}

// The tables of what the run was before these steps. Who wants them again makes them afterwards.
static enum vw_status remove_outdated(const char *out) {
    static const char *const names[] = {"report.html", "matrix.csv", "providers.csv", "payout.csv", "duplicates.csv"};
    for (size_t i = 0; i < VW_ARRAY_COUNT(names); i++) {
        char *path = vw_path_join(out, names[i]);
        if (!path) return VW_ERROR_MEMORY;
        enum vw_status status = VW_OK;
        if (unlink(path) && errno != ENOENT)
            status =
                vw_fail(VW_ERROR_IO, "%s: cannot remove what new steps made out of date: %s; remove it, and --resume",
                        path, strerror(errno));
        free(path);
        if (status) return status;
    }
    return VW_OK;
}

// The outputs come first: a run that the ledger calls finished has them, and none of an earlier end.
enum vw_status vw_training_finish(struct vw_training_run *run, const struct vw_ledger_score *scores,
                                  uint32_t score_count, const struct vw_ledger_image *images, uint32_t image_count) {
    if (run->complete) return VW_OK;
    char finished_utc[VW_UTC_BYTES];
    vw_utc_now(finished_utc);
    enum vw_status status = remove_outdated(run->options->out);
    if (!status) status = vw_trainer_save_field(run->trainer, run->field_path);
    if (!status && images) status = vw_report_write_csv(run->scores_path, scores, score_count, images, image_count);
    if (!status) status = vw_ledger_finish(run->ledger, "finished", finished_utc, scores, score_count);
    if (status) finish_early(run, status);
    else say_oddities(&run->statistics);
    return status;
}

enum vw_status vw_training_score_and_finish(struct vw_training_run *run, struct vw_scoring *scoring) {
    enum vw_status status = vw_scoring_make(run->ledger, &run->options->config, scoring);
    if (status) return status;
    return vw_training_finish(run, scoring->scores, scoring->score_count, scoring->input.images,
                              scoring->input.image_count);
}

json_t *vw_training_to_json(const struct vw_training_run *run) {
    uint8_t run_id[32];
    char run_id_hex[VW_HASH_HEX_BYTES], head[VW_HASH_HEX_BYTES];
    if (vw_trainer_run_id(run->trainer, run_id)) return NULL; // short of memory
    vw_hash_to_hex(run_id, run_id_hex);
    const struct vw_gpu_info *device = vw_gpu_get_info(run->gpu);
    vw_ledger_chain_head(run->ledger, head);
    json_t *profile = run->profile.row_count ? vw_profile_to_json(&run->profile) : NULL;
    return json_pack("{s:s, s:s, s:s, s:s, s:I, s:o, s:s, s:s, s:s, s:o*}", "run_id", run_id_hex, "scene",
                     run->scene->path, "device", device->name, "driver", device->driver, "steps",
                     (json_int_t)run->statistics.steps, "effects", vw_effects_to_json(run->effects, run->effect_count),
                     "ledger", run->ledger_path, "field", run->field_path, "head", head, "profile", profile);
}
