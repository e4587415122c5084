#include "lab/gradients/gradient_replay.h"

#include <math.h>

enum vw_status gradient_sweep_create(const struct vw_gradient_params *params, struct gradient_sweep *sweep) {
    *sweep = (struct gradient_sweep){.interrupt = params->interrupt};
    enum vw_status status = step_replay_create(params->training, params->replayed, params->context, &sweep->replay);
    if (status != VW_OK) return status;
    const struct probe_context *context = sweep->replay.context;
    const struct sweep_params passes = {.batch_steps = 2 * sweep->replay.batch_steps, .psnr_alone = true};
    const struct vw_buffer_params zeros = {.name = "zeros", .size_bytes = context->field->model->param_bytes};
    status = sweep_passes_create(context, &passes, &sweep->passes);
    if (status == VW_OK) status = vw_buffer_create(context->field->gpu, &zeros, &sweep->zeros);
    return status == VW_OK ? snapshot_create(context->step, &sweep->state) : status;
}

void gradient_sweep_destroy(struct gradient_sweep *sweep) {
    snapshot_destroy(&sweep->state);
    vw_buffer_destroy(&sweep->zeros);
    sweep_passes_destroy(&sweep->passes);
    step_replay_destroy(&sweep->replay);
}

enum vw_status gradient_sweep_check_interrupt(const struct gradient_sweep *sweep) {
    if (!vw_interrupt_requested(&sweep->interrupt)) return VW_OK;
    return vw_fail(VW_ERROR_INTERRUPTED, "interrupted; repeat the command to begin these scores anew");
}

enum vw_status gradient_sweep_go_to(struct gradient_sweep *sweep, uint64_t step) {
    const struct step_replay *replay = &sweep->replay;
    enum vw_status status = VW_OK;
    while (status == VW_OK && sweep->step < step) {
        uint64_t first = sweep->step + 1, left = step - sweep->step;
        uint32_t count = left < replay->batch_steps ? (uint32_t)left : replay->batch_steps;
        status = gradient_sweep_check_interrupt(sweep);
        if (status != VW_OK) return status;
        vw_batch_begin(replay->batch);
        for (uint32_t i = 0; i < count; i++) {
            uint32_t pixel = step_replay_draw(replay, first + i, i);
            step_record(replay->context->step, replay->batch, first + i, pixel, step_replay_row(replay, i));
        }
        status = step_replay_run(replay);
        if (status == VW_OK) status = step_replay_tell(replay, first, count);
        sweep->step += count;
    }
    return status;
}

void gradient_sweep_record_zero(const struct gradient_sweep *sweep) {
    uint64_t bytes = vw_buffer_size_bytes(sweep->zeros);
    vw_batch_copy(sweep->replay.batch, sweep->zeros, 0, sweep->passes.adjoint.blocks.lambda, 0, bytes);
    vw_batch_copy(sweep->replay.batch, sweep->zeros, 0, sweep->passes.kept[SWEEP_PSNR].lambda, 0, bytes);
}

void gradient_sweep_record_validation(const struct gradient_sweep *sweep, uint32_t scalar_row) {
    struct vw_batch *batch = sweep->replay.batch;
    gradient_sweep_record_zero(sweep);
    vw_batch_copy(batch, sweep->replay.context->field->params, 0, sweep->passes.blocks.after, 0,
                  vw_buffer_size_bytes(sweep->zeros));
    sweep_record_state(&sweep->passes, batch, scalar_row, 1);
}

double gradient_sweep_read(const struct gradient_sweep *sweep, uint32_t row) {
    const vw_float4 *product = (const vw_float4 *)vw_buffer_map(sweep->passes.rows) + row;
    double value = (double)product->x + product->y;
    return isfinite(value) && product->w == 0.0f ? value : NAN;
}

static enum vw_status save_state(const struct gradient_sweep *sweep) {
    vw_batch_begin(sweep->replay.batch);
    snapshot_record_save(&sweep->state, sweep->replay.batch);
    return step_replay_run(&sweep->replay);
}

enum vw_status gradient_sweep_try_photos(struct gradient_sweep *sweep, uint64_t number,
                                         struct photo_products *products) {
    const struct step_replay *replay = &sweep->replay;
    const struct schedule *schedule = replay->context->schedule;
    enum vw_status status = save_state(sweep);
    for (uint32_t first = 0, count = 0; first < schedule->train_count && status == VW_OK; first += count) {
        uint32_t left = schedule->train_count - first;
        count = left < replay->batch_steps ? left : replay->batch_steps;
        status = gradient_sweep_check_interrupt(sweep);
        if (status != VW_OK) return status;
        vw_batch_begin(replay->batch);
        for (uint32_t i = 0; i < count; i++) { // draw 0 is that of the step of this number
            uint32_t view = schedule->train_views[first + i],
                     pixel = step_replay_draw_photo(replay, view, number, 1 + first + i, i);
            sweep_record_own_step(&sweep->passes, replay->batch, number, pixel, step_replay_row(replay, i));
            sweep_record_multiply(&sweep->passes, replay->batch, false, 2 * i);
            sweep_record_multiply(&sweep->passes, replay->batch, true, 2 * i + 1);
            snapshot_record_restore(&sweep->state, replay->batch);
        }
        status = step_replay_run(replay);
        for (uint32_t i = 0; i < count && status == VW_OK; i++)
            products[first + i] =
                (struct photo_products){gradient_sweep_read(sweep, 2 * i), gradient_sweep_read(sweep, 2 * i + 1)};
    }
    return status;
}
