#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/hash.h"
#include "base/memory.h"
#include "run/out_folder.h"
#include "run/plan/plan.h"
#include "run/run_private.h"
#include "run/run_row.h"
#include "viewworth/log.h"

enum vw_status vw_run_create_trainer(struct vw_run *run) {
    struct vw_config config = run->config;
    config.epochs = vw_plan_epochs_most(&run->results.plan, &run->config);
    const struct vw_trainer_params params = {.gpu = run->gpu,
                                             .scene = run->scene,
                                             .config = &config,
                                             .effects = run->effects,
                                             .effect_count = run->effect_count,
                                             .validate = run->validate,
                                             .submissions = run->session->devices[run->device].submissions};
    return vw_trainer_create(&params, &run->trainer);
}

// ---- A budget ------------------------------------------------------------------------------------------------------

// It ends a run at the end of an epoch, which changes no bit of its steps. It looks at ends of epochs that come closer
// as the time runs out. The config, and the ledger's, has the epochs up to the next look.

static uint64_t photos_of(const struct vw_run *run) { return vw_trainer_epoch_end(run->trainer, 1); }

static enum vw_status stop_next_at(struct vw_run *run, uint64_t step) {
    run->segment.first_step = run->results.statistics.steps;
    run->segment.started_s = vw_now_s();
    run->stop_step = step;
    run->config.epochs = (uint32_t)(step / photos_of(run));
    char *config_json = vw_config_to_json(&run->config, false);
    if (!config_json) return VW_ERROR_MEMORY;
    enum vw_status status = run->ledger ? vw_ledger_extend(run->ledger, config_json) : VW_OK;
    free(config_json);
    return status;
}

// Sets run->stop_step to the end of the epoch that is recorded last, or of the first; without a budget to the last.
static enum vw_status begin_budget(struct vw_run *run) {
    run->stop_step = vw_trainer_total_steps(run->trainer);
    if (!vw_plan_keeps_time(&run->results.plan)) return VW_OK;
    vw_plan_estimate_finish(run->scene, run->report.no_thumbnails, &run->results.plan); // a resumed one has none
    return stop_next_at(run, vw_trainer_epoch_end(run->trainer, run->results.statistics.steps));
}

// Returns the seconds of an epoch at the pace of the last segment, unless it was shorter than an epoch: the first steps
// are slow.
static double epoch_seconds(const struct vw_run *run) {
    uint64_t steps = run->results.statistics.steps - run->segment.first_step, photos = photos_of(run);
    if (steps < photos) return (double)photos * run->results.plan.step_s;
    return (vw_now_s() - run->segment.started_s) * (double)photos / (double)steps;
}

// Returns the epochs to take before the next look; 0: the run ends.
static uint32_t next_segment(struct vw_run *run) {
    struct vw_plan *plan = &run->results.plan;
    uint64_t photos = photos_of(run), taken = run->results.statistics.steps / photos;
    uint32_t most = (uint32_t)(vw_trainer_total_steps(run->trainer) / photos - taken),
             least = run->config.burn_in_epochs + 1;
    double epoch_s = epoch_seconds(run) + plan->finish_step_s * (double)photos,
           left_s = vw_plan_left_s(plan, run->results.statistics.steps);
    plan->epochs_planned = (uint32_t)taken + vw_budget_epochs_that_fit(left_s, epoch_s, most);
    uint32_t segment = vw_budget_segment(left_s, epoch_s, most);
    return segment == 0 && taken < least && most > 0 ? 1 : segment; // without which there are no scores at all
}

// Tells at run->stop_step whether the run continues, and sets the next one.
static enum vw_status spend_budget(struct vw_run *run, bool *continues) {
    uint32_t epochs = vw_plan_keeps_time(&run->results.plan) ? next_segment(run) : 0;
    *continues = epochs > 0;
    return *continues ? stop_next_at(run, run->results.statistics.steps + epochs * photos_of(run)) : VW_OK;
}

uint64_t vw_run_expected_steps(const struct vw_run *run) {
    if (!vw_plan_keeps_time(&run->results.plan)) return vw_trainer_total_steps(run->trainer);
    uint64_t planned = run->results.plan.epochs_planned * photos_of(run), decided = run->config.epochs * photos_of(run);
    return planned > decided ? planned : decided;
}

// ---- The first rows ------------------------------------------------------------------------------------------------

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

static enum vw_status write_first_rows(struct vw_run *run, const struct vw_ledger_image *images) {
    struct vw_run_row first;
    char started_utc[VW_UTC_BYTES];
    enum vw_status status = vw_run_row_make(run->trainer, run->gpu, run->scene, &run->config, &first);
    vw_utc_now(started_utc);
    first.row.started_utc = started_utc;
    first.row.scene_options_json = run->scene_options_json;
    first.row.plan_json = run->results.plan.json;
    if (!status)
        status = vw_ledger_create(run->results.ledger_path, &first.row, images, run->scene->view_count, &run->ledger);
    vw_run_row_free(&first);
    return status;
}

static enum vw_status create_ledger(struct vw_run *run) {
    struct vw_ledger_image *images = NULL;
    char(*hashes)[VW_HASH_HEX_BYTES] = NULL;
    enum vw_status status = list_images(run->scene, &images, &hashes);
    if (!status) status = write_first_rows(run, images);
    free(images);
    free(hashes);
    return status;
}

// ---- Recording -----------------------------------------------------------------------------------------------------

const char *vw_run_remedy(const struct vw_run *run) {
    return run->config.field == VW_FIELD_SPLATS ? "a lower --lr or fewer --splats" : "a lower --lr";
}

static enum vw_status check_nonfinite(const struct vw_run *run) {
    if (!vw_step_statistics_should_abort(&run->results.statistics)) return VW_OK;
    return vw_fail(VW_ERROR_DEVICE,
                   "stopped at step %" PRIu64 ": %" PRIu64
                   " steps were not finite, more than %.0f %%; %s keeps them; try %s",
                   run->results.statistics.steps, run->results.statistics.nonfinite,
                   100 * vw_step_statistics_nonfinite_max, run->results.ledger_path, vw_run_remedy(run));
}

static enum vw_status start_writer(struct vw_run *run) {
    uint32_t validation_count = 0;
    const uint32_t *validation_views = vw_trainer_validation_views(run->trainer, &validation_count);
    enum vw_status status = run->ledger ? VW_OK : create_ledger(run);
    if (status || run->writer) return status;
    return vw_ledger_writer_create(run->ledger, validation_views, &run->results.statistics, &run->writer);
}

// Waits until all steps that were handed to the writer are on disk. After a failure the run has those that are. Reports
// an earlier failure first.
static enum vw_status drain(struct vw_run *run, enum vw_status status) {
    if (!run->writer) return status;
    struct vw_saved_error why = vw_error_save();
    enum vw_status written = vw_ledger_writer_drain(run->writer);
    if (status || written) run->results.statistics = vw_ledger_writer_recorded(run->writer);
    if (status) vw_error_restore(&why);
    return status ? status : written;
}

// Compares the steps that the ledger has and hands the others to the writer, up to the one with which too many are not
// finite. What is compared comes before anything is handed over.
static enum vw_status record(struct vw_run *run, const struct vw_step_record *records, uint32_t count) {
    uint32_t validation_count = 0, known = 0, added = 0;
    const uint32_t *validation_views = vw_trainer_validation_views(run->trainer, &validation_count);
    enum vw_status status = start_writer(run);
    if (status) return status;
    uint64_t next_step = vw_ledger_writer_next_step(run->writer);
    while (known < count && records[known].step < next_step) known++;
    if (known) status = vw_ledger_compare(run->ledger, records, known, validation_views);
    while (!status && known + added < count && !vw_step_statistics_should_abort(&run->results.statistics))
        vw_step_statistics_add(&run->results.statistics, &records[known + added++]);
    if (!status && added && !run->cleared) { // the files there show fewer steps than the ledger has
        status = vw_run_remove_outdated(run->out, run->payout_cents > 0);
        run->cleared = !status;
    }
    if (!status && added) status = vw_ledger_writer_add(run->writer, records + known, added, &run->results.statistics);
    if (!status && vw_step_statistics_should_abort(&run->results.statistics)) status = drain(run, VW_OK);
    return status ? status : check_nonfinite(run);
}

// ---- Progress ------------------------------------------------------------------------------------------------------

// Returns the statistics of the steps on disk, the only ones that progress shows.
static struct vw_step_statistics recorded(const struct vw_run *run) {
    return run->writer ? vw_ledger_writer_recorded(run->writer) : run->results.statistics;
}

static void report_progress(struct vw_run *run, uint64_t step) {
    const struct vw_step_statistics on_disk = recorded(run);
    if (step > on_disk.steps) step = on_disk.steps;
    run->shown_step = step;
    if (!run->progress) return;
    uint64_t total = run->over ? run->results.statistics.steps : vw_run_expected_steps(run);
    uint64_t photos = vw_trainer_epoch_end(run->trainer, 1); // steps of an epoch
    const struct vw_run_state state = {
        .step = step,
        .total_steps = total,
        .epoch = step ? (uint32_t)((step - 1) / photos) : 0,
        .epochs = (uint32_t)(total / photos),
        .val_psnr_db = on_disk.last_val_psnr_db,
        .finished = run->over,
    };
    if (!run->progress(run->context, &state)) run->stopping = true;
}

static enum vw_status take_records(struct vw_run *run, const struct vw_step_record *records, uint32_t count) {
    enum vw_status status = record(run, records, count);
    if (status) return status;
    if (!run->stepped) vw_log_info("start    first steps after %.2f s", vw_now_s() - run->results.plan.started_s);
    run->stepped = run->moved = true;
    run->trainer_step = records[count - 1].step;
    report_progress(run, run->trainer_step);
    return VW_OK;
}

// Waits until every step is on disk; call before reading the ledger or saving a checkpoint. Shows the last steps.
static enum vw_status settle_ledger(struct vw_run *run) {
    enum vw_status status = drain(run, VW_OK);
    if (!status && run->shown_step < run->trainer_step) report_progress(run, run->trainer_step);
    return status;
}

// ---- Steps ---------------------------------------------------------------------------------------------------------

// Saves a checkpoint, and sets when the next one is due.
static void save_checkpoint(struct vw_run *run) {
    vw_checkpoints_save(&run->checkpoints, run->trainer);
    run->moved = false;
}

void vw_run_save_checkpoint(struct vw_run *run) {
    if (run->moved) save_checkpoint(run);
}

static enum vw_status stop(struct vw_run *run) {
    run->stopping = false;
    return vw_fail(VW_ERROR_INTERRUPTED,
                   "interrupted; %s keeps the %" PRIu64 " steps recorded so far; continue by --resume",
                   run->results.ledger_path, run->results.statistics.steps);
}

// Lets the trainer go to where a budget looks next, or to `last_step`.
static void release(struct vw_run *run, uint64_t last_step) {
    vw_trainer_stop_after(run->trainer, run->stop_step < last_step ? run->stop_step : last_step);
}

// Notes what the timers found, if the device has any.
static void keep_timers(struct vw_run *run) {
    uint32_t count;
    const struct vw_gpu_timer *timers = vw_gpu_timers(run->gpu, &count);
    run->results.pass_count = count < VW_TIMED_PASSES_MAX ? count : VW_TIMED_PASSES_MAX;
    if (count) memcpy(run->results.passes, timers, run->results.pass_count * sizeof *timers);
}

// Ends the steps. Does not save the end twice: an older checkpoint is worth more than a second one of the same step.
static void end_steps(struct vw_run *run) {
    run->over = true;
    vw_run_save_checkpoint(run);
    report_progress(run, run->results.statistics.steps);
    keep_timers(run);
}

// Asks the budget while nothing is in flight and the trainer is where it was released to.
static enum vw_status check_budget(struct vw_run *run, uint64_t last_step, bool *piece_ends) {
    bool continues = false;
    *piece_ends = run->results.statistics.steps < run->stop_step;
    enum vw_status status = *piece_ends ? VW_OK : spend_budget(run, &continues);
    if (status || *piece_ends) return status;
    if (continues) release(run, last_step);
    else end_steps(run);
    return VW_OK;
}

// Collects what is in flight, for a checkpoint or to stop.
static enum vw_status settle(struct vw_run *run) {
    const struct vw_step_record *records = NULL;
    uint32_t count = 1;
    enum vw_status status = VW_OK;
    while (!status && count > 0) {
        status = vw_trainer_collect(run->trainer, &records, &count);
        if (!status && count > 0) status = take_records(run, records, count);
    }
    if (!status) status = settle_ledger(run); // a checkpoint is never ahead of the ledger
    if (!status) save_checkpoint(run);
    return !status && run->stopping ? stop(run) : status;
}

// Takes one submission of steps on the way to `last_step`.
static enum vw_status take_submission(struct vw_run *run, uint64_t last_step, bool *ended) {
    const struct vw_step_record *records = NULL;
    uint32_t count = 0;
    *ended = false;
    if (run->ledger && (run->stopping || vw_checkpoints_due(&run->checkpoints))) return settle(run);
    enum vw_status status = vw_trainer_advance(run->trainer, &records, &count);
    if (status) return status;
    if (count > 0) return take_records(run, records, count);
    bool piece_ends = false;
    status = settle_ledger(run);
    if (!status && !run->stopping) status = check_budget(run, last_step, &piece_ends);
    *ended = run->over || piece_ends;
    return status;
}

static enum vw_status begin(struct vw_run *run) {
    if (run->begun) return VW_OK;
    enum vw_status status = check_nonfinite(run);
    if (!status) status = begin_budget(run);
    if (status) return status;
    run->begun = true;
    vw_checkpoints_begin(&run->checkpoints);
    report_progress(run, run->started_after);
    return VW_OK;
}

enum vw_status vw_run_catch_up(struct vw_run *run) {
    if (run->complete || run->trainer_step >= run->results.statistics.steps) return VW_OK;
    uint64_t last_step = run->results.statistics.steps;
    bool ended = run->over;
    enum vw_status status = begin(run);
    if (!status) release(run, last_step);
    while (!status && !ended) status = take_submission(run, last_step, &ended);
    return drain(run, status);
}

// ---- An early end --------------------------------------------------------------------------------------------------

void vw_run_end_early(struct vw_run *run, enum vw_status status) {
    struct vw_ledger_run row;
    struct vw_saved_error why = vw_error_save();
    if (!vw_ledger_get_run(run->ledger, &row) && strcmp(row.status, "running") == 0 && status != VW_ERROR_MISMATCH) {
        const char *outcome = status == VW_ERROR_INTERRUPTED ? "interrupted" : "failed";
        vw_scoring_end_early(run->ledger, &run->config, outcome);
    }
    vw_error_restore(&why);
}

// ---- Advancing ------------------------------------------------------------------------------------------------------

enum vw_status vw_run_begin(struct vw_run *run, uint64_t steps) {
    if (!run) return vw_fail(VW_ERROR_USAGE, "vw_run_advance: run is NULL; open one by vw_run_open");
    if (run->failed) return vw_fail(VW_ERROR_USAGE, "vw_run_advance: the run has failed; close it and resume it");
    run->advancing = false;
    if (run->complete || run->over || steps == 0) return VW_OK;
    if (run->finished || run->ended)
        return vw_fail(VW_ERROR_USAGE,
                       "vw_run_advance: the run is finished; open it again with resume to take more steps");
    enum vw_status status = begin(run);
    run->failed = status;
    if (status) return status;
    uint64_t total = vw_trainer_total_steps(run->trainer), taken = run->results.statistics.steps;
    run->last_step = taken < total && steps < total - taken ? taken + steps : total;
    run->advancing = true;
    release(run, run->last_step);
    return VW_OK;
}

// Holds a run that stops, while the runs that share its submissions continue.
enum vw_status vw_run_step(struct vw_run *run, bool *ended) {
    *ended = !run->advancing;
    if (*ended) return VW_OK;
    enum vw_status status = take_submission(run, run->last_step, ended);
    run->advancing = !status && !*ended;
    if (!status) return VW_OK;
    status = drain(run, status);
    vw_trainer_stop_after(run->trainer, 0);
    if (run->ledger) vw_run_end_early(run, status);
    run->failed = status != VW_ERROR_INTERRUPTED;
    return status;
}

enum vw_status vw_run_advance(struct vw_run *run, uint64_t steps) {
    bool ended = false;
    enum vw_status status = vw_run_begin(run, steps);
    while (!status && !ended) status = vw_run_step(run, &ended);
    return status;
}

void vw_run_leave(struct vw_run *run) {
    if (!run->ledger || !run->stepped || run->failed || run->finished) return;
    vw_run_save_checkpoint(run);
    vw_run_end_early(run, VW_ERROR_INTERRUPTED);
}
