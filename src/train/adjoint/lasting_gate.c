// The gate of lasting credit: retrainings in which the steps on one photo are longer.
#include <math.h>

#include "train/adjoint/lasting.h"
#include "train/adjoint/lasting_private.h"

struct outcome {
    double psnr, loss; // U: validation PSNR, and minus validation L1, averaged over its states
};

// Takes the steps after `from_step` from the state on the device, those on `view` longer by `extra`.
static enum vw_status retrain(const struct vw_lasting *lasting, uint64_t from_step, uint32_t view, float extra,
                              struct outcome *outcome) {
    const struct vw_trainer_parts *context = lasting->replay.context;
    const vw_float4 *rows = vw_buffer_map(context->scalars);
    uint32_t states = vw_lasting_state_count(lasting), count = 0;
    enum vw_status status = VW_OK;
    *outcome = (struct outcome){0};
    for (uint64_t first = from_step + 1; first <= lasting->replay.total_steps && !status; first += count) {
        uint64_t left = lasting->replay.total_steps - first + 1;
        count = left < lasting->replay.submission_steps ? (uint32_t)left : lasting->replay.submission_steps;
        vw_submission_begin(lasting->replay.submission);
        for (uint32_t i = 0; i < count; i++) {
            uint64_t step = first + i;
            uint32_t pixel = vw_step_replay_draw(&lasting->replay, step, i);
            bool scaled = vw_photo_order_view_of_step(context->photo_order, step) == view;
            vw_step_record_gradients(context->step, lasting->replay.submission, step, pixel);
            vw_step_record_update(context->step, lasting->replay.submission, step, pixel, scaled ? extra : 0.0f);
            vw_step_record_loss(context->step, lasting->replay.submission, pixel,
                                vw_step_replay_row(&lasting->replay, i));
            if (vw_lasting_is_state(lasting, step))
                vw_validation_record(context->validation, lasting->replay.submission,
                                     vw_step_replay_row(&lasting->replay, i));
        }
        status = vw_step_replay_run(&lasting->replay);
        for (uint32_t i = 0; i < count && !status; i++) {
            if (!vw_lasting_is_state(lasting, first + i)) continue;
            const struct vw_field_measurement measured =
                vw_validation_read(context->validation, rows + vw_step_replay_row(&lasting->replay, i), NULL);
            outcome->psnr += (measured.finite ? measured.val_psnr : NAN) / states;
            outcome->loss -= (measured.finite ? measured.val_l1 : NAN) / states;
        }
    }
    return status;
}

static enum vw_status restore(const struct vw_lasting *lasting, const struct vw_snapshot *state) {
    vw_submission_begin(lasting->replay.submission);
    vw_snapshot_record_restore(state, lasting->replay.submission);
    return vw_step_replay_run(&lasting->replay);
}

// Brings the device into the state after `from_step`, and keeps it.
static enum vw_status prepare(const struct vw_lasting *lasting, uint64_t from_step, struct vw_snapshot *state) {
    const struct vw_trainer_parts *context = lasting->replay.context;
    uint64_t step = from_step / lasting->segment_steps * lasting->segment_steps;
    enum vw_status status = restore(lasting, &lasting->starts[step / lasting->segment_steps]);
    while (step < from_step && !status) {
        vw_submission_begin(lasting->replay.submission);
        for (uint32_t i = 0; i < lasting->replay.submission_steps && step < from_step; i++) {
            step++;
            vw_step_record_passes(context->step, lasting->replay.submission, step,
                                  vw_step_replay_draw(&lasting->replay, step, i),
                                  vw_step_replay_row(&lasting->replay, i));
        }
        status = vw_step_replay_run(&lasting->replay);
    }
    if (!status) status = vw_snapshot_create(context->step, state);
    if (status) return status;
    vw_submission_begin(lasting->replay.submission);
    vw_snapshot_record_save(state, lasting->replay.submission);
    return vw_step_replay_run(&lasting->replay);
}

// Averages what the training itself reached over the states of U: repeated, it would reach the same bits.
static struct outcome outcome_of(const struct vw_lasting *lasting, const struct vw_step_record *records) {
    struct outcome outcome = {0};
    uint32_t states = vw_lasting_state_count(lasting);
    for (uint64_t step = vw_lasting_first_state(lasting); step <= lasting->replay.total_steps; step++) {
        if (!vw_lasting_is_state(lasting, step)) continue;
        outcome.psnr += records[step].val_psnr / states;
        outcome.loss -= records[step].val_l1 / states;
    }
    return outcome;
}

enum vw_status vw_lasting_measure(struct vw_lasting *lasting, const struct vw_step_record *records, uint64_t from_step,
                                  struct vw_lasting_check *checks, uint32_t count) {
    struct vw_snapshot state = {0};
    struct outcome recorded = outcome_of(lasting, records), longer = {0};
    if (lasting->replay.context->config->beta1 > 0)
        return vw_fail(VW_ERROR_USAGE,
                       "the gate scales steps, which with momentum belong to several photos; use --no-gate");
    if (lasting->next_step != 0 || from_step >= vw_lasting_first_state(lasting))
        return vw_fail(VW_ERROR_USAGE,
                       "the gate follows the whole backward pass, from a step before the states that it measures");
    enum vw_status status = prepare(lasting, from_step, &state);
    // A step that was not finite has no values in its record, although the state after it may well have some.
    if (!status && isnan(recorded.psnr)) status = retrain(lasting, from_step, 0, 0.0f, &recorded);
    for (uint32_t i = 0; i < count && !status; i++) {
        status = restore(lasting, &state);
        if (!status) status = retrain(lasting, from_step, checks[i].view, (float)VW_LASTING_SCALED, &longer);
        checks[i].measured_psnr = (longer.psnr - recorded.psnr) / VW_LASTING_SCALED;
        checks[i].measured_loss = (longer.loss - recorded.loss) / VW_LASTING_SCALED;
    }
    vw_snapshot_destroy(&state);
    return status;
}
