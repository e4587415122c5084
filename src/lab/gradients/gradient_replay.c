#include "lab/gradients/gradient_replay.h"

#include <math.h>

#include "base/memory.h"
#include "gpu/shaders.h"

static enum vw_status create_multiply(struct vw_gradient_replay *gradient_replay) {
    const struct vw_adjoint_passes *passes = &gradient_replay->passes;
    const struct vw_binding bindings[] = {
        {.slot = VW_SLOT_PARAMS_BEFORE, .buffer = passes->blocks.before},
        {.slot = VW_SLOT_PARAMS_AFTER, .buffer = passes->blocks.after},
        {.slot = VW_SLOT_STEP_GRADIENT, .buffer = passes->blocks.gradient},
        {.slot = VW_SLOT_ADJOINT, .buffer = passes->adjoint.blocks.lambda},
        {.slot = VW_SLOT_ADJOINT_SUMS, .buffer = passes->sums},
    };
    const struct vw_pass_params common = vw_pass_params_of(&passes->context->field->model->specialization, bindings,
                                                           VW_ARRAY_COUNT(bindings), "adjoint");
    return vw_pass_create_of(&gradient_replay->objects, &common, &vw_shader_multiply_blocks,
                             &gradient_replay->multiply);
}

enum vw_status vw_gradient_replay_create(const struct vw_gradient_params *params,
                                         struct vw_gradient_replay *gradient_replay) {
    *gradient_replay = (struct vw_gradient_replay){.interrupt = params->interrupt};
    enum vw_status status =
        vw_step_replay_create(params->training, params->replayed, params->context, &gradient_replay->replay);
    if (status) return status;
    const struct vw_trainer_parts *context = gradient_replay->replay.context;
    const struct vw_adjoint_params passes = {.submission_steps = 2 * gradient_replay->replay.submission_steps,
                                             .psnr_alone = true};
    const struct vw_buffer_row zeros = {&gradient_replay->zeros, "zeros", context->field->model->param_bytes};
    gradient_replay->objects.gpu = context->field->gpu;
    status = vw_adjoint_create(context, &passes, &gradient_replay->passes);
    if (!status) status = vw_buffers_create(&gradient_replay->objects, VW_BUFFER_DEVICE, &zeros, 1);
    if (!status) status = create_multiply(gradient_replay);
    return !status ? vw_snapshot_create(context->step, &gradient_replay->state) : status;
}

void vw_gradient_replay_destroy(struct vw_gradient_replay *gradient_replay) {
    vw_snapshot_destroy(&gradient_replay->state);
    vw_gpu_objects_destroy(&gradient_replay->objects);
    vw_adjoint_destroy(&gradient_replay->passes);
    vw_step_replay_destroy(&gradient_replay->replay);
}

enum vw_status vw_gradient_replay_check_interrupt(const struct vw_gradient_replay *gradient_replay) {
    if (!vw_interrupt_requested(&gradient_replay->interrupt)) return VW_OK;
    return vw_fail(VW_ERROR_INTERRUPTED, "interrupted; repeat the command to recompute these scores");
}

enum vw_status vw_gradient_replay_go_to(struct vw_gradient_replay *gradient_replay, uint64_t step) {
    const struct vw_step_replay *replay = &gradient_replay->replay;
    enum vw_status status = VW_OK;
    while (!status && gradient_replay->step < step) {
        uint64_t first = gradient_replay->step + 1, left = step - gradient_replay->step;
        uint32_t count = left < replay->submission_steps ? (uint32_t)left : replay->submission_steps;
        status = vw_gradient_replay_check_interrupt(gradient_replay);
        if (status) return status;
        vw_submission_begin(replay->submission);
        for (uint32_t i = 0; i < count; i++) {
            uint32_t pixel = vw_step_replay_draw(replay, first + i, i);
            vw_step_record_passes(replay->context->step, replay->submission, first + i, pixel,
                                  vw_step_replay_row(replay, i));
        }
        status = vw_step_replay_run(replay);
        if (!status) status = vw_step_replay_tell(replay, first, count);
        gradient_replay->step += count;
    }
    return status;
}

void vw_gradient_replay_record_zero(const struct vw_gradient_replay *gradient_replay) {
    uint64_t bytes = vw_buffer_size_bytes(gradient_replay->zeros);
    vw_submission_copy(gradient_replay->replay.submission, gradient_replay->zeros, 0,
                       gradient_replay->passes.adjoint.blocks.lambda, 0, bytes);
    vw_submission_copy(gradient_replay->replay.submission, gradient_replay->zeros, 0,
                       gradient_replay->passes.by_measure[ADJOINT_PSNR].lambda, 0, bytes);
}

void vw_gradient_replay_record_validation(const struct vw_gradient_replay *gradient_replay, uint32_t scalar_row) {
    struct vw_submission *submission = gradient_replay->replay.submission;
    vw_gradient_replay_record_zero(gradient_replay);
    vw_submission_copy(submission, gradient_replay->replay.context->field->params, 0,
                       gradient_replay->passes.blocks.after, 0, vw_buffer_size_bytes(gradient_replay->zeros));
    vw_adjoint_record_state(&gradient_replay->passes, submission, scalar_row, 1);
}

void vw_gradient_replay_record_step(const struct vw_gradient_replay *gradient_replay, uint64_t number,
                                    uint32_t first_pixel, uint32_t scalar_row) {
    const struct vw_adjoint_passes *passes = &gradient_replay->passes;
    struct vw_submission *submission = gradient_replay->replay.submission;
    struct vw_buffer *params = passes->context->field->params;
    uint64_t bytes = passes->context->field->model->param_bytes;
    vw_submission_copy(submission, params, 0, passes->blocks.before, 0, bytes);
    vw_adjoint_record_own_step(passes, submission, number, first_pixel, scalar_row);
    vw_submission_copy(submission, params, 0, passes->blocks.after, 0, bytes);
}

void vw_gradient_replay_record_multiply(const struct vw_gradient_replay *gradient_replay, bool by_gradient,
                                        uint32_t row) {
    struct vw_submission *submission = gradient_replay->replay.submission;
    const struct vw_push_product push = {
        .count = (uint32_t)(vw_buffer_size_bytes(gradient_replay->zeros) / sizeof(vw_float4)),
        .by_gradient = by_gradient};
    const struct vw_push_reduce reduce = {.count = VW_ADJOINT_GROUPS, .scalar_row = row};
    vw_submission_dispatch(submission, gradient_replay->multiply, &push, sizeof push, 64ull * VW_ADJOINT_GROUPS);
    vw_submission_dispatch(submission, gradient_replay->passes.reduce, &reduce, sizeof reduce, 1);
}

double vw_gradient_replay_read(const struct vw_gradient_replay *gradient_replay, uint32_t row) {
    const vw_float4 *product = (const vw_float4 *)vw_buffer_map(gradient_replay->passes.rows) + row;
    double value = (double)product->x + product->y;
    return isfinite(value) && product->w == 0.0f ? value : NAN;
}

static enum vw_status save_state(const struct vw_gradient_replay *gradient_replay) {
    vw_submission_begin(gradient_replay->replay.submission);
    vw_snapshot_record_save(&gradient_replay->state, gradient_replay->replay.submission);
    return vw_step_replay_run(&gradient_replay->replay);
}

enum vw_status vw_gradient_replay_try_photos(struct vw_gradient_replay *gradient_replay, uint64_t number,
                                             struct vw_photo_products *products) {
    const struct vw_step_replay *replay = &gradient_replay->replay;
    const struct vw_photo_order *photo_order = replay->context->photo_order;
    enum vw_status status = save_state(gradient_replay);
    for (uint32_t first = 0, count = 0; first < photo_order->train_count && !status; first += count) {
        uint32_t left = photo_order->train_count - first;
        count = left < replay->submission_steps ? left : replay->submission_steps;
        status = vw_gradient_replay_check_interrupt(gradient_replay);
        if (status) return status;
        vw_submission_begin(replay->submission);
        for (uint32_t i = 0; i < count; i++) { // draw 0 is that of the step of this number
            uint32_t view = photo_order->train_views[first + i],
                     pixel = vw_step_replay_draw_photo(replay, view, number, 1 + first + i, i);
            vw_gradient_replay_record_step(gradient_replay, number, pixel, vw_step_replay_row(replay, i));
            vw_gradient_replay_record_multiply(gradient_replay, false, 2 * i);
            vw_gradient_replay_record_multiply(gradient_replay, true, 2 * i + 1);
            vw_snapshot_record_restore(&gradient_replay->state, replay->submission);
        }
        status = vw_step_replay_run(replay);
        for (uint32_t i = 0; i < count && !status; i++)
            products[first + i] = (struct vw_photo_products){vw_gradient_replay_read(gradient_replay, 2 * i),
                                                             vw_gradient_replay_read(gradient_replay, 2 * i + 1)};
    }
    return status;
}
