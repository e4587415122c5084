#include "run/lasting/lasting.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/file.h"
#include "base/memory.h"
#include "report/page.h"
#include "run/lasting/lasting_file.h"
#include "run/out_folder.h"
#include "run/recorded/replayed_run.h"
#include "run/run_private.h"
#include "train/adjoint/lasting.h"
#include "viewworth/log.h"
#include "viewworth/value.h"

enum { GATE_EPOCHS = 6, GATE_PHOTOS = 6 };
static const double SAVE_INTERVAL_S = 30;

// A sweep on its way.
struct sweep {
    struct vw_run *run;
    struct vw_lasting *lasting;
    struct vw_recorded_steps recorded;
    struct vw_lasting_file file;
    char *path;                     // owned; of the sweep's own file
    struct vw_lasting_rows credits; // owned; of step 1, 2, ...
    uint32_t *views;                // owned; validation photos with credits of their own; file.views
    uint64_t steps, from;           // steps of the run; credits from step `from` on are known; steps + 1: none
    struct vw_gate_check *checks;   // owned
    uint32_t check_count;
    double saved_s;
};

// ---- Stopping and resuming ------------------------------------------------------------------------------------------

// Saves the credits first, so that the backward pass's own file is never ahead of them.
static void save(struct sweep *sweep) {
    if (sweep->from > sweep->steps || sweep->from == 1) return; // nothing to go on from, or the end
    if (vw_lasting_file_save(&sweep->file, &sweep->credits, sweep->from) ||
        vw_lasting_save(sweep->lasting, sweep->path))
        vw_log_warning("%s", vw_error_message());
    sweep->saved_s = vw_now_s();
}

// Loads the saved state. Warns and starts anew when a file cannot be used.
static enum vw_status load(struct sweep *sweep) {
    uint64_t next_step = 0, first_step = 0;
    if (!vw_file_exists(sweep->path)) return VW_OK;
    enum vw_status status = vw_lasting_file_load(&sweep->file, &sweep->credits, &first_step);
    if (!status) status = vw_lasting_load(sweep->lasting, sweep->path, first_step, &next_step);
    if (status == VW_ERROR_INPUT || status == VW_ERROR_IO) {
        vw_log_warning("%s", vw_error_message());
        return VW_OK;
    }
    if (!status) sweep->from = next_step + 1;
    if (!status) vw_log_info("lasting  continues at step %" PRIu64, next_step);
    return status;
}

static enum vw_status remove_file(const char *folder, const char *name) {
    char *path = vw_path_join(folder, name);
    if (!path) return VW_ERROR_MEMORY;
    enum vw_status status = VW_OK;
    if (unlink(path) && errno != ENOENT)
        status =
            vw_fail(VW_ERROR_IO, "%s: cannot remove: %s; remove it, and repeat the command", path, strerror(errno));
    free(path);
    return status;
}

// ---- The sweep ------------------------------------------------------------------------------------------------------

static enum vw_status report_progress(struct sweep *sweep, bool done) {
    struct vw_lasting_state now;
    struct vw_run *run = sweep->run;
    vw_lasting_get_state(sweep->lasting, &now);
    const struct vw_run_state state = {
        .step = now.work_done, .total_steps = now.work_total, .val_psnr_db = NAN, .finished = done, .sweeping = true};
    if (!run->progress || run->progress(run->context, &state) || done) return VW_OK;
    save(sweep);
    return vw_fail(VW_ERROR_INTERRUPTED,
                   "interrupted; %s keeps the run and the sweep so far; the same command continues (a finished run: "
                   "viewworth lasting)",
                   run->out);
}

static enum vw_status take_credits(struct sweep *sweep, const struct vw_lasting_credit *credits, uint32_t count) {
    const struct vw_step_record *records = sweep->run->results.scoring.input.records;
    for (uint32_t i = 0; i < count; i++) {
        const struct vw_lasting_credit *credit = &credits[i];
        if (sweep->from <= 1 || credit->step != sweep->from - 1 || records[credit->step].view != credit->view)
            return vw_fail(VW_ERROR_MISMATCH, "%s: the sweep gave step %" PRIu64 " out of its order; report this",
                           sweep->run->results.ledger_path, credit->step);
        sweep->from--;
        sweep->credits.steps[credit->step - 1] =
            (struct vw_lasting_step){credit->step, credit->psnr, credit->loss, credit->size_psnr, credit->size_loss};
        for (uint32_t v = 0; v < sweep->file.views; v++)
            sweep->credits.view_psnr[(credit->step - 1) * sweep->file.views + v] = credit->view_psnr[v];
    }
    return VW_OK;
}

static enum vw_status advance(struct sweep *sweep) {
    const struct vw_lasting_credit *credits = NULL;
    uint32_t count = 0;
    bool done = false;
    enum vw_status status = report_progress(sweep, false);
    sweep->saved_s = vw_now_s();
    while (!status && !done) {
        status = vw_lasting_advance(sweep->lasting, &credits, &count, &done);
        if (!status) status = take_credits(sweep, credits, count);
        if (!status && vw_now_s() - sweep->saved_s > SAVE_INTERVAL_S) save(sweep);
        if (!status) status = report_progress(sweep, done);
    }
    return status;
}

// ---- The gate -------------------------------------------------------------------------------------------------------

// Sums per train photo the predicted effect of the steps after from_step.
static void predict(const struct sweep *sweep, uint64_t from_step, struct vw_gate_check *photos, uint32_t photo_count) {
    const struct vw_step_record *records = sweep->run->results.scoring.input.records;
    for (uint64_t step = from_step + 1; step <= sweep->steps; step++)
        for (uint32_t i = 0; i < photo_count; i++) {
            if (photos[i].image_id != records[step].view) continue;
            photos[i].predicted_psnr += sweep->credits.steps[step - 1].psnr;
            photos[i].predicted_loss += sweep->credits.steps[step - 1].loss;
        }
}

static int compare_predicted(const void *left, const void *right) {
    const struct vw_gate_check *a = left, *b = right;
    if (a->predicted_psnr != b->predicted_psnr) return a->predicted_psnr < b->predicted_psnr ? -1 : 1;
    return a->image_id < b->image_id ? -1 : a->image_id > b->image_id;
}

static int compare_ids(const void *left, const void *right) {
    const struct vw_gate_check *a = left, *b = right;
    return a->image_id < b->image_id ? -1 : a->image_id > b->image_id;
}

// Keeps two at each end and two in the middle.
static uint32_t choose(struct vw_gate_check *photos, uint32_t photo_count) {
    qsort(photos, photo_count, sizeof *photos, compare_predicted);
    if (photo_count > GATE_PHOTOS) {
        const uint32_t places[GATE_PHOTOS] = {
            0, 1, photo_count / 2 - 1, photo_count / 2, photo_count - 2, photo_count - 1};
        for (uint32_t i = 0; i < GATE_PHOTOS; i++) photos[i] = photos[places[i]];
        photo_count = GATE_PHOTOS;
    }
    qsort(photos, photo_count, sizeof *photos, compare_ids);
    return photo_count;
}

static enum vw_status measure(struct sweep *sweep) {
    struct vw_lasting_check checks[GATE_PHOTOS] = {0};
    uint64_t from_step = sweep->checks[0].from_step;
    for (uint32_t i = 0; i < sweep->check_count; i++) checks[i].view = sweep->checks[i].image_id;
    vw_log_info("gate     %u photos, 2 trainings of %" PRIu64 " steps for each", sweep->check_count,
                sweep->steps - from_step);
    enum vw_status status = vw_lasting_measure(sweep->lasting, from_step, checks, sweep->check_count);
    for (uint32_t i = 0; !status && i < sweep->check_count; i++) {
        sweep->checks[i].measured_psnr = isfinite(checks[i].measured_psnr) ? checks[i].measured_psnr : NAN;
        sweep->checks[i].measured_loss = isfinite(checks[i].measured_loss) ? checks[i].measured_loss : NAN;
    }
    return status;
}

static enum vw_status gate(struct sweep *sweep) {
    struct vw_run *run = sweep->run;
    uint32_t *views = NULL, count = 0;
    if (run->lasting.no_gate) return VW_OK;
    if (!vw_lasting_has_gate(&run->config)) {
        vw_log_warning("no gate: with --beta1 above 0 a step also moves along the gradients of earlier photos, so that "
                       "scaling the steps on a photo says nothing of that photo");
        return VW_OK;
    }
    enum vw_status status = vw_scene_list_views(run->scene, VW_SPLIT_TRAIN, &views, &count);
    if (status) return status;
    uint64_t span = (uint64_t)GATE_EPOCHS * count, from_step = sweep->steps > span ? sweep->steps - span : 0;
    sweep->checks = vw_allocate(count, sizeof *sweep->checks);
    for (uint32_t i = 0; sweep->checks && i < count; i++)
        sweep->checks[i] = (struct vw_gate_check){.image_id = views[i], .from_step = from_step};
    free(views);
    if (!sweep->checks) return VW_ERROR_MEMORY;
    predict(sweep, from_step, sweep->checks, count);
    sweep->check_count = choose(sweep->checks, count);
    return measure(sweep);
}

// ---- Recording ------------------------------------------------------------------------------------------------------

// Writes the table before the ledger, so that a ledger with lasting credit has a scores.csv that contains it.
static enum vw_status record(struct sweep *sweep) {
    struct vw_run *run = sweep->run;
    struct vw_scoring *scoring = &run->results.scoring;
    uint32_t epochs = run->config.epochs < VW_LASTING_EPOCHS ? run->config.epochs : VW_LASTING_EPOCHS;
    uint64_t span = epochs * vw_trainer_epoch_end(run->trainer, 1);
    bool changes_matrix = sweep->file.views || scoring->input.lasting.view_count;
    vw_lasting_pass_free(&scoring->input.lasting);
    scoring->input.lasting = (struct vw_lasting_pass){
        .rays = run->lasting.rays,
        .epochs = epochs,
        .states = span < VW_LASTING_STATES ? (uint32_t)span : VW_LASTING_STATES,
        .steps = sweep->credits.steps,
        .step_count = sweep->steps,
        .checks = sweep->checks,
        .check_count = sweep->check_count,
        .views = sweep->views,
        .view_psnr = sweep->credits.view_psnr,
        .view_count = sweep->file.views,
    };
    sweep->credits = (struct vw_lasting_rows){0}; // the scoring has them now
    sweep->views = NULL;
    sweep->checks = NULL;
    enum vw_status status = vw_scoring_repeat(scoring);
    if (!status) status = vw_run_rank(run);
    if (!status) status = vw_run_remove_outdated_scores(run->out);
    if (!status && changes_matrix) status = remove_file(run->out, "matrix.csv");
    if (!status)
        status = vw_report_write_csv(run->results.scores_path, scoring->scores, scoring->score_count,
                                     scoring->input.images, scoring->input.image_count);
    if (!status)
        status = vw_ledger_set_lasting(run->ledger, &scoring->input.lasting, scoring->scores, scoring->score_count);
    if (!status) status = remove_file(run->out, VW_LASTING_SWEEP_FILE);
    return status ? status : remove_file(run->out, VW_LASTING_CREDITS_FILE);
}

// ---- All of it ------------------------------------------------------------------------------------------------------

static enum vw_status allocate(struct sweep *sweep) {
    const struct vw_run *run = sweep->run;
    enum vw_status status = VW_OK;
    if (run->lasting.matrix) status = vw_scene_list_views(run->scene, VW_SPLIT_VAL, &sweep->views, &sweep->file.views);
    sweep->credits.steps = vw_allocate(sweep->steps, sizeof *sweep->credits.steps);
    sweep->credits.view_psnr = vw_allocate(sweep->steps * sweep->file.views, sizeof *sweep->credits.view_psnr);
    return status || (sweep->path && sweep->credits.steps && sweep->credits.view_psnr) ? status : VW_ERROR_MEMORY;
}

static enum vw_status open_sweep(struct vw_run *run, const char *run_id, struct sweep *sweep) {
    uint64_t photos = vw_trainer_epoch_end(run->trainer, 1);
    sweep->steps = run->results.scoring.input.record_count - 1;
    sweep->from = sweep->steps + 1;
    sweep->recorded =
        (struct vw_recorded_steps){run->results.ledger_path, run->results.scoring.input.records, sweep->steps + 1};
    sweep->file = (struct vw_lasting_file){run->out, run_id, run->lasting.rays, sweep->steps, 0};
    if (sweep->steps == 0 || sweep->steps % photos != 0)
        return vw_fail(VW_ERROR_USAGE,
                       "%s: ends within an epoch, after step %" PRIu64 "; finish it by viewworth value --resume, then "
                       "sweep it",
                       run->results.ledger_path, sweep->steps);
    enum vw_status status =
        vw_lasting_set_epochs(run->results.ledger_path, (uint32_t)(sweep->steps / photos), &run->config);
    const struct vw_config config = vw_config_without_probes(&run->config);
    sweep->path = vw_path_join(run->out, VW_LASTING_SWEEP_FILE);
    if (!status) status = allocate(sweep);
    if (status) return status;
    const struct vw_trainer_params training = {.gpu = run->gpu,
                                               .scene = run->scene,
                                               .config = &config,
                                               .effects = run->effects,
                                               .effect_count = run->effect_count,
                                               .validate = true};
    const struct vw_lasting_params params = {.training = &training,
                                             .rays = run->lasting.rays,
                                             .by_view = run->lasting.matrix,
                                             .replayed = vw_recorded_steps_compare,
                                             .context = &sweep->recorded};
    status = vw_lasting_create(&params, &sweep->lasting);
    return status ? status : load(sweep);
}

enum vw_status vw_run_sweep(struct vw_run *run) {
    struct vw_ledger_run row;
    struct sweep sweep = {.run = run};
    if (vw_lasting_is_there(&run->lasting, &run->config, &run->results.scoring.input.lasting)) {
        vw_log_info("lasting  %s holds this sweep already", run->out);
        return VW_OK;
    }
    enum vw_status status = vw_lasting_check_config(&run->config);
    if (!status) status = vw_ledger_get_run(run->ledger, &row);
    if (!status) status = open_sweep(run, row.run_id, &sweep);
    if (!status) status = advance(&sweep);
    if (!status) status = gate(&sweep);
    vw_lasting_destroy(&sweep.lasting);
    // The pictures of the report show the recorded field, in whatever state the pass left the trainer.
    if (!status) status = vw_trainer_load_field(run->trainer, run->results.field_path);
    if (!status) status = record(&sweep);
    free(sweep.path);
    free(sweep.credits.steps);
    free(sweep.credits.view_psnr);
    free(sweep.views);
    free(sweep.checks);
    return status;
}
