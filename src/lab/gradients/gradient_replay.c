#include "lab/gradients/gradient_replay.h"

#include <math.h>

enum vw_status vw_gradient_replay_create(const struct vw_gradient_params *params, struct vw_gradient_replay *sweep) {
    *sweep = (struct vw_gradient_replay){.interrupt = params->interrupt};
    enum vw_status status = vw_step_replay_create(params->training, params->replayed, params->context, &sweep->replay);
    if (status) return status;
    const struct vw_trainer_parts *context = sweep->replay.context;
    const struct vw_adjoint_params passes = {.batch_steps = 2 * sweep->replay.batch_steps, .psnr_alone = true};
    const struct vw_buffer_params zeros = {.name = "zeros", .size_bytes = context->field->model->param_bytes};
    status = vw_adjoint_create(context, &passes, &sweep->passes);
    if (!status) status = vw_buffer_create(context->field->gpu, &zeros, &sweep->zeros);
    return !status ? vw_snapshot_create(context->step, &sweep->state) : status;
}

void vw_gradient_replay_destroy(struct vw_gradient_replay *sweep) {
    vw_snapshot_destroy(&sweep->state);
    vw_buffer_destroy(&sweep->zeros);
    vw_adjoint_destroy(&sweep->passes);
    vw_step_replay_destroy(&sweep->replay);
}

enum vw_status vw_gradient_replay_check_interrupt(const struct vw_gradient_replay *sweep) {
    if (!vw_interrupt_requested(&sweep->interrupt)) return VW_OK;
    return vw_fail(VW_ERROR_INTERRUPTED, "interrupted; repeat the command to begin these scores anew");
}

enum vw_status vw_gradient_replay_go_to(struct vw_gradient_replay *sweep, uint64_t step) {
    const struct vw_step_replay *replay = &sweep->replay;
    enum vw_status status = VW_OK;
    while (!status && sweep->step < step) {
        uint64_t first = sweep->step + 1, left = step - sweep->step;
        uint32_t count = left < replay->batch_steps ? (uint32_t)left : replay->batch_steps;
        status = vw_gradient_replay_check_interrupt(sweep);
        if (status) return status;
        vw_submission_begin(replay->batch);
        for (uint32_t i = 0; i < count; i++) {
            uint32_t pixel = vw_step_replay_draw(replay, first + i, i);
            vw_step_record_passes(replay->context->step, replay->batch, first + i, pixel,
                                  vw_step_replay_row(replay, i));
        }
        status = vw_step_replay_run(replay);
        if (!status) status = vw_step_replay_tell(replay, first, count);
        sweep->step += count;
    }
    return status;
}

void vw_gradient_replay_record_zero(const struct vw_gradient_replay *sweep) {
    uint64_t bytes = vw_buffer_size_bytes(sweep->zeros);
    vw_submission_copy(sweep->replay.batch, sweep->zeros, 0, sweep->passes.adjoint.blocks.lambda, 0, bytes);
    vw_submission_copy(sweep->replay.batch, sweep->zeros, 0, sweep->passes.kept[ADJOINT_PSNR].lambda, 0, bytes);
}

void vw_gradient_replay_record_validation(const struct vw_gradient_replay *sweep, uint32_t scalar_row) {
    struct vw_submission *batch = sweep->replay.batch;
    vw_gradient_replay_record_zero(sweep);
    vw_submission_copy(batch, sweep->replay.context->field->params, 0, sweep->passes.blocks.after, 0,
                       vw_buffer_size_bytes(sweep->zeros));
    vw_adjoint_record_state(&sweep->passes, batch, scalar_row, 1);
}

double vw_gradient_replay_read(const struct vw_gradient_replay *sweep, uint32_t row) {
    const vw_float4 *product = (const vw_float4 *)vw_buffer_map(sweep->passes.rows) + row;
    double value = (double)product->x + product->y;
    return isfinite(value) && product->w == 0.0f ? value : NAN;
}

static enum vw_status save_state(const struct vw_gradient_replay *sweep) {
    vw_submission_begin(sweep->replay.batch);
    vw_snapshot_record_save(&sweep->state, sweep->replay.batch);
    return vw_step_replay_run(&sweep->replay);
}

enum vw_status vw_gradient_replay_try_photos(struct vw_gradient_replay *sweep, uint64_t number,
                                             struct vw_photo_products *products) {
    const struct vw_step_replay *replay = &sweep->replay;
    const struct vw_photo_order *schedule = replay->context->schedule;
    enum vw_status status = save_state(sweep);
    for (uint32_t first = 0, count = 0; first < schedule->train_count && !status; first += count) {
        uint32_t left = schedule->train_count - first;
        count = left < replay->batch_steps ? left : replay->batch_steps;
        status = vw_gradient_replay_check_interrupt(sweep);
        if (status) return status;
        vw_submission_begin(replay->batch);
        for (uint32_t i = 0; i < count; i++) { // draw 0 is that of the step of this number
            uint32_t view = schedule->train_views[first + i],
                     pixel = vw_step_replay_draw_photo(replay, view, number, 1 + first + i, i);
            vw_adjoint_record_own_step(&sweep->passes, replay->batch, number, pixel, vw_step_replay_row(replay, i));
            vw_adjoint_record_multiply(&sweep->passes, replay->batch, false, 2 * i);
            vw_adjoint_record_multiply(&sweep->passes, replay->batch, true, 2 * i + 1);
            vw_snapshot_record_restore(&sweep->state, replay->batch);
        }
        status = vw_step_replay_run(replay);
        for (uint32_t i = 0; i < count && !status; i++)
            products[first + i] = (struct vw_photo_products){vw_gradient_replay_read(sweep, 2 * i),
                                                             vw_gradient_replay_read(sweep, 2 * i + 1)};
    }
    return status;
}
