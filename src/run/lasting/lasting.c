#include "run/lasting/lasting.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/file.h"
#include "base/memory.h"
#include "base/text.h"
#include "run/lasting/lasting_summary.h"
#include "run/out_folder.h"
#include "run/plan/accuracy_levels.h"
#include "run/plan/plan.h"
#include "train/adjoint/lasting.h"
#include "train/trainer.h"
#include "viewworth/log.h"

enum { GATE_EPOCHS = 6, GATE_PHOTOS = 6 };
static const double BACKWARD_PASS = 2.5; // times a run: 2.4 (courtyard) and 2.5 (fox), draft, lavapipe, 2026-11-27
static const double SAVE_INTERVAL_S = 30;

struct backward {
    const struct vw_backward_params *params;
    struct vw_lasting *lasting;
    char *path;                      // owned; of its file; NULL: it is not kept
    struct vw_lasting_step *credits; // owned; of step 1, 2, ...
    double *view_psnr;               // owned; as of vw_lasting_pass
    uint32_t *views, view_count;     // owned; validation photos with credits of their own
    uint64_t steps, from;            // steps of the run; credits from step `from` on are known; steps + 1: none
    struct vw_gate_check *checks;    // owned
    uint32_t check_count;
    double saved_s;
};

// ---- Stopping and resuming ------------------------------------------------------------------------------------------

static size_t row_bytes(const struct backward *pass) {
    return sizeof *pass->credits + pass->view_count * sizeof *pass->view_psnr;
}

// Saves the known credits in two blocks: those of the steps, then those of their validation photos.
static enum vw_status write_file(const struct backward *pass) {
    size_t count = (size_t)(pass->steps - pass->from + 1), steps_bytes = count * sizeof *pass->credits;
    uint8_t *rows = vw_allocate(count, row_bytes(pass));
    if (!rows) return VW_ERROR_MEMORY;
    memcpy(rows, &pass->credits[pass->from - 1], steps_bytes);
    if (pass->view_count)
        memcpy(rows + steps_bytes, &pass->view_psnr[(pass->from - 1) * pass->view_count],
               count * row_bytes(pass) - steps_bytes);
    enum vw_status status = vw_lasting_save(pass->lasting, pass->path, rows, row_bytes(pass));
    free(rows);
    return status;
}

static void save(struct backward *pass) {
    if (!pass->path || pass->from > pass->steps || pass->from == 1) return; // nothing to go on from, or the end
    if (write_file(pass)) vw_log_warning("%s", vw_error_message());
    pass->saved_s = vw_now_s();
}

// Loads the saved state. Warns and starts anew when the file cannot be used.
static enum vw_status load(struct backward *pass) {
    uint64_t next_step = 0;
    void *rows = NULL;
    if (!pass->path || !vw_file_exists(pass->path)) return VW_OK;
    enum vw_status status = vw_lasting_load(pass->lasting, pass->path, row_bytes(pass), &rows, &next_step);
    if (status == VW_ERROR_INPUT || status == VW_ERROR_IO) {
        vw_log_warning("%s", vw_error_message());
        return VW_OK;
    }
    if (status) return status;
    size_t count = (size_t)(pass->steps - next_step), steps_bytes = count * sizeof *pass->credits;
    memcpy(&pass->credits[next_step], rows, steps_bytes);
    if (pass->view_count)
        memcpy(&pass->view_psnr[next_step * pass->view_count], (uint8_t *)rows + steps_bytes,
               count * row_bytes(pass) - steps_bytes);
    free(rows);
    pass->from = next_step + 1;
    vw_log_info("lasting  continues at step %" PRIu64, next_step);
    return VW_OK;
}

// ---- The pass -------------------------------------------------------------------------------------------------------

static enum vw_status report_progress(struct backward *pass, bool done) {
    const struct vw_backward_params *params = pass->params;
    struct vw_lasting_state now;
    vw_lasting_get_state(pass->lasting, &now);
    const struct vw_run_state state = {
        .step = now.work_done, .total_steps = now.work_total, .val_psnr_db = NAN, .finished = done, .backward = true};
    if (!params->progress || params->progress(params->context, &state) || done) return VW_OK;
    save(pass);
    if (!params->out) return vw_fail(VW_ERROR_INTERRUPTED, "interrupted; the backward pass was not made again");
    return vw_fail(
        VW_ERROR_INTERRUPTED,
        "interrupted; %s keeps the run and the backward pass so far; the same command continues (a finished run: "
        "viewworth lasting)",
        params->out);
}

static enum vw_status take_credits(struct backward *pass, const struct vw_lasting_credit *credits, uint32_t count) {
    const struct vw_recorded_steps *recorded = &pass->params->recorded;
    for (uint32_t i = 0; i < count; i++) {
        const struct vw_lasting_credit *credit = &credits[i];
        if (pass->from <= 1 || credit->step != pass->from - 1 || recorded->records[credit->step].view != credit->view)
            return vw_fail(VW_ERROR_MISMATCH,
                           "%s: the backward pass gave step %" PRIu64 " out of its order; report this",
                           recorded->ledger_path, credit->step);
        pass->from--;
        pass->credits[credit->step - 1] =
            (struct vw_lasting_step){credit->step, credit->psnr, credit->loss, credit->size_psnr, credit->size_loss};
        for (uint32_t v = 0; v < pass->view_count; v++)
            pass->view_psnr[(credit->step - 1) * pass->view_count + v] = credit->view_psnr[v];
    }
    return VW_OK;
}

static enum vw_status advance(struct backward *pass) {
    const struct vw_lasting_credit *credits = NULL;
    uint32_t count = 0;
    bool done = false;
    enum vw_status status = report_progress(pass, false);
    pass->saved_s = vw_now_s();
    while (!status && !done) {
        status = vw_lasting_advance(pass->lasting, &credits, &count, &done);
        if (!status) status = take_credits(pass, credits, count);
        if (!status && vw_now_s() - pass->saved_s > SAVE_INTERVAL_S) save(pass);
        if (!status) status = report_progress(pass, done);
    }
    return status;
}

// ---- The gate -------------------------------------------------------------------------------------------------------

// Sums per train photo the predicted effect of the steps after from_step.
static void predict(const struct backward *pass, uint64_t from_step, struct vw_gate_check *photos,
                    uint32_t photo_count) {
    const struct vw_step_record *records = pass->params->recorded.records;
    for (uint64_t step = from_step + 1; step <= pass->steps; step++)
        for (uint32_t i = 0; i < photo_count; i++) {
            if (photos[i].image_id != records[step].view) continue;
            photos[i].predicted_psnr += pass->credits[step - 1].psnr;
            photos[i].predicted_loss += pass->credits[step - 1].loss;
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

static enum vw_status measure(struct backward *pass) {
    struct vw_lasting_check checks[GATE_PHOTOS] = {0};
    uint64_t from_step = pass->checks[0].from_step;
    for (uint32_t i = 0; i < pass->check_count; i++) checks[i].view = pass->checks[i].image_id;
    vw_log_info("gate     %u photos, a training of %" PRIu64 " steps for each", pass->check_count,
                pass->steps - from_step);
    enum vw_status status =
        vw_lasting_measure(pass->lasting, pass->params->recorded.records, from_step, checks, pass->check_count);
    for (uint32_t i = 0; !status && i < pass->check_count; i++) {
        pass->checks[i].measured_psnr = isfinite(checks[i].measured_psnr) ? checks[i].measured_psnr : NAN;
        pass->checks[i].measured_loss = isfinite(checks[i].measured_loss) ? checks[i].measured_loss : NAN;
    }
    return status;
}

static enum vw_status gate(struct backward *pass) {
    const struct vw_trainer_params *training = pass->params->training;
    uint32_t *views = NULL, count = 0;
    if (pass->params->options.no_gate) return VW_OK;
    if (!vw_lasting_has_gate(training->config)) {
        vw_log_warning("no gate: with --beta1 above 0 a step also moves along the gradients of earlier photos, so that "
                       "scaling the steps on a photo says nothing of that photo");
        return VW_OK;
    }
    enum vw_status status = vw_scene_list_views(training->scene, VW_SPLIT_TRAIN, &views, &count);
    if (status) return status;
    uint64_t span = (uint64_t)GATE_EPOCHS * count, from_step = pass->steps > span ? pass->steps - span : 0;
    pass->checks = vw_allocate(count, sizeof *pass->checks);
    for (uint32_t i = 0; pass->checks && i < count; i++)
        pass->checks[i] = (struct vw_gate_check){.image_id = views[i], .from_step = from_step};
    free(views);
    if (!pass->checks) return VW_ERROR_MEMORY;
    predict(pass, from_step, pass->checks, count);
    pass->check_count = choose(pass->checks, count);
    return measure(pass);
}

// ---- Its price ------------------------------------------------------------------------------------------------------

double vw_lasting_seconds(const struct vw_config *config, bool gated, double run_s, double training_s) {
    double trainings = gated ? GATE_PHOTOS * fmin(1, (double)GATE_EPOCHS / config->epochs) : 0;
    return BACKWARD_PASS * run_s + trainings * training_s;
}

// Tells it before a pass that begins.
static enum vw_status announce(const struct backward *pass) {
    const struct vw_trainer_params *training = pass->params->training;
    bool gated = !pass->params->options.no_gate && vw_lasting_has_gate(training->config);
    struct vw_estimate estimate = {0};
    char about[VW_ABOUT_BYTES];
    if (pass->path && vw_file_exists(pass->path)) return VW_OK;
    enum vw_status status = vw_estimate_take_steps(training, &estimate);
    if (status) return status;
    double run_s = estimate.seconds_per_step * (double)pass->steps;
    double training_s = run_s * vw_accuracy_unvalidated_share(training->config);
    vw_text_about(vw_lasting_seconds(training->config, gated, run_s, training_s), about);
    vw_log_info("a backward pass%s%s%s", gated ? " and 6 short trainings that check it" : "", about,
                pass->path ? "; Ctrl-C keeps what is done" : "");
    return VW_OK;
}

// ---- Making it ------------------------------------------------------------------------------------------------------

static enum vw_status allocate(struct backward *pass) {
    const struct vw_backward_params *params = pass->params;
    enum vw_status status = VW_OK;
    if (params->options.matrix)
        status = vw_scene_list_views(params->training->scene, VW_SPLIT_VAL, &pass->views, &pass->view_count);
    if (params->out) pass->path = vw_path_join(params->out, VW_LASTING_PASS_FILE);
    pass->credits = vw_allocate(pass->steps, sizeof *pass->credits);
    pass->view_psnr = vw_allocate(pass->steps * pass->view_count, sizeof *pass->view_psnr);
    bool whole = (pass->path || !params->out) && pass->credits && pass->view_psnr;
    return status || whole ? status : VW_ERROR_MEMORY;
}

static enum vw_status make(struct backward *pass) {
    const struct vw_backward_params *params = pass->params;
    const struct vw_lasting_params of_pass = {.training = params->training,
                                              .rays = params->options.rays,
                                              .by_view = params->options.matrix,
                                              .replayed = vw_recorded_steps_compare,
                                              .context = (void *)&params->recorded};
    enum vw_status status = allocate(pass);
    if (!status) status = announce(pass);
    if (!status) status = vw_lasting_create(&of_pass, &pass->lasting);
    if (!status) status = load(pass);
    if (!status) status = advance(pass);
    if (!status) status = gate(pass);
    vw_lasting_destroy(&pass->lasting);
    return status;
}

enum vw_status vw_backward_make(const struct vw_backward_params *params, struct vw_lasting_pass *made) {
    uint64_t steps = params->recorded.record_count - 1;
    struct backward pass = {.params = params, .steps = steps, .from = steps + 1};
    enum vw_status status = make(&pass);
    free(pass.path);
    uint32_t all_epochs = params->training->config->epochs,
             epochs = all_epochs < VW_LASTING_EPOCHS ? all_epochs : VW_LASTING_EPOCHS;
    uint64_t span = epochs * (steps / all_epochs);
    struct vw_lasting_pass whole = {.rays = params->options.rays,
                                    .epochs = epochs,
                                    .states = span < VW_LASTING_STATES ? (uint32_t)span : VW_LASTING_STATES,
                                    .steps = pass.credits,
                                    .step_count = steps,
                                    .checks = pass.checks,
                                    .check_count = pass.check_count,
                                    .views = pass.views,
                                    .view_psnr = pass.view_psnr,
                                    .view_count = pass.view_count};
    if (status) vw_lasting_pass_free(&whole);
    else *made = whole;
    return status;
}
