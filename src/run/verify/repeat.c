#include "run/verify/repeat.h"

#include <inttypes.h>
#include <math.h>

#include "run/lasting/lasting.h"
#include "run/recorded/recorded_run.h"
#include "train/trainer.h"

static enum vw_status open_scene(const struct vw_repeat_params *params) {
    struct vw_recorded_run *run = params->run;
    if (run->scene) return VW_OK;
    enum vw_status status = vw_recorded_open_scene(run, params->device ? params->device : run->row.device);
    return status ? status : vw_recorded_check_images(run);
}

// Returns whether the run is one of `value`: the untrained field has a validation, or one that is not finite.
static bool is_validated(const struct vw_value_input *input) {
    return input->record_count > 0 && (input->records[0].validated || input->records[0].nonfinite);
}

// ---- Steps ---------------------------------------------------------------------------------------------------------

static enum vw_status take_steps(const struct vw_repeat_params *params, struct vw_trainer *trainer, uint64_t wanted,
                                 uint64_t *compared) {
    struct vw_ledger *ledger = params->run->ledger;
    uint32_t validation_count = 0, count = 0;
    const uint32_t *validation_views = vw_trainer_validation_views(trainer, &validation_count);
    const struct vw_step_record *records = NULL;
    uint64_t end = vw_ledger_next_step(ledger);
    if (wanted < end) end = wanted + 1; // step 0 comes for free
    vw_trainer_stop_after(trainer, end - 1);
    enum vw_status status = vw_trainer_advance(trainer, &records, &count);
    while (!status && count > 0 && records[0].step < end) {
        if (records[0].step + count > end) count = (uint32_t)(end - records[0].step);
        status = vw_ledger_compare(ledger, records, count, validation_views);
        if (!status) *compared = records[count - 1].step;
        if (!status && vw_interrupt_requested(params->interrupt))
            status = vw_fail(VW_ERROR_INTERRUPTED, "interrupted after step %" PRIu64, *compared);
        if (!status) status = vw_trainer_advance(trainer, &records, &count);
    }
    return status;
}

enum vw_status vw_repeat_steps(const struct vw_repeat_params *params, uint64_t wanted, uint64_t *compared) {
    struct vw_trainer *trainer = NULL;
    enum vw_status status = open_scene(params);
    if (status || !vw_ledger_next_step(params->run->ledger)) return status;
    status = vw_recorded_create_trainer(params->run, is_validated(params->input), &trainer);
    if (!status) status = take_steps(params, trainer, wanted, compared);
    vw_trainer_destroy(&trainer);
    return status;
}

// ---- Lasting credit ------------------------------------------------------------------------------------------------

static bool same(double a, double b) { return a == b || (isnan(a) && isnan(b)); }

static bool same_step(const struct vw_lasting_pass *a, const struct vw_lasting_pass *b, uint64_t place) {
    const struct vw_lasting_step *x = &a->steps[place], *y = &b->steps[place];
    bool equal =
        x->psnr == y->psnr && x->loss == y->loss && x->size_psnr == y->size_psnr && x->size_loss == y->size_loss;
    for (uint64_t i = place * a->view_count; equal && i < (place + 1) * a->view_count; i++)
        equal = a->view_psnr[i] == b->view_psnr[i];
    return equal;
}

static bool same_check(const struct vw_gate_check *a, const struct vw_gate_check *b) {
    return a->image_id == b->image_id && a->from_step == b->from_step && a->predicted_psnr == b->predicted_psnr &&
           a->predicted_loss == b->predicted_loss && same(a->measured_psnr, b->measured_psnr) &&
           same(a->measured_loss, b->measured_loss);
}

static enum vw_status compare(const char *path, const struct vw_lasting_pass *recorded,
                              const struct vw_lasting_pass *made) {
    for (uint64_t i = 0; i < made->step_count; i++)
        if (!same_step(recorded, made, i))
            return vw_fail(VW_ERROR_MISMATCH,
                           "%s: lasting credit of step %" PRIu64 ", made again, is %.9g dB, and its row is another one "
                           "(%.9g dB): this program did not make it on this device",
                           path, i + 1, made->steps[i].psnr, recorded->steps[i].psnr);
    bool gated = recorded->check_count == made->check_count;
    for (uint32_t i = 0; gated && i < made->check_count; i++)
        gated = same_check(&recorded->checks[i], &made->checks[i]);
    if (gated && recorded->epochs == made->epochs && recorded->states == made->states) return VW_OK;
    return vw_fail(
        VW_ERROR_MISMATCH,
        "%s: the gate of lasting credit, made again, or its settings are not the recorded ones: this program "
        "did not make it on this device",
        path);
}

static bool goes_on(void *context, const struct vw_run_state *state) {
    (void)state;
    return !vw_interrupt_requested(context);
}

// Compares the identity of the run, and makes its pass.
static enum vw_status make_pass(const struct vw_repeat_params *params, struct vw_lasting_pass *made) {
    struct vw_recorded_run *run = params->run;
    const struct vw_lasting_pass *recorded = &params->input->lasting;
    struct vw_trainer *trainer = NULL;
    enum vw_status status = vw_recorded_create_trainer(run, true, &trainer);
    vw_trainer_destroy(&trainer);
    if (status) return status;
    struct vw_trainer_params training = vw_recorded_trainer_params(run);
    training.validate = true;
    const struct vw_backward_params pass = {
        .training = &training,
        .recorded = {run->ledger_path, params->input->records, params->input->record_count},
        .options = {.rays = recorded->rays, .no_gate = !recorded->check_count, .matrix = recorded->view_count > 0},
        .progress = goes_on,
        .context = (void *)params->interrupt};
    return vw_backward_make(&pass, made);
}

enum vw_status vw_repeat_lasting(const struct vw_repeat_params *params) {
    struct vw_recorded_run *run = params->run;
    struct vw_lasting_pass made = {0};
    if (!params->input->lasting.step_count)
        return vw_fail(VW_ERROR_USAGE, "%s: has no lasting credit to make again; leave out --lasting",
                       run->ledger_path);
    enum vw_status status = vw_recorded_check_replay(run);
    if (!status) status = open_scene(params);
    if (!status) status = make_pass(params, &made);
    if (!status) status = compare(run->ledger_path, &params->input->lasting, &made);
    vw_lasting_pass_free(&made);
    return status;
}
