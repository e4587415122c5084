#include "train/adjoint/step_replay.h"

#include <math.h>

enum { SUBMISSION_STEPS_MAX = 64 };

enum vw_status vw_step_replay_create(const struct vw_trainer_params *training, vw_step_replayed *replayed,
                                     void *context, struct vw_step_replay *replay) {
    *replay = (struct vw_step_replay){.replayed = replayed, .replayed_context = context};
    enum vw_status status = vw_trainer_create(training, &replay->trainer);
    if (status) return status;
    replay->context = vw_trainer_get_parts(replay->trainer);
    replay->total_steps = vw_trainer_total_steps(replay->trainer);
    uint32_t room = replay->context->photo_order->submission_steps_max;
    replay->submission_steps = room < SUBMISSION_STEPS_MAX ? room : SUBMISSION_STEPS_MAX;
    const struct vw_photo_order *photo_order = replay->context->photo_order;
    status = vw_step_take_photos(replay->context->step, photo_order->train_views, photo_order->train_count);
    return status ? status : vw_submission_create(replay->context->field->gpu, &replay->submission);
}

void vw_step_replay_destroy(struct vw_step_replay *replay) {
    vw_submission_destroy(&replay->submission);
    vw_trainer_destroy(&replay->trainer);
}

uint32_t vw_step_replay_draw_photo(const struct vw_step_replay *replay, uint32_t view, uint64_t step, uint32_t draw,
                                   uint32_t index) {
    const struct vw_trainer_parts *context = replay->context;
    uint32_t rays = context->config->rays;
    const struct vw_pixel_draw drawn = {vw_config_seed_of(context->config, VW_VARY_PIXELS), step, draw, 0,
                                        context->masks};
    vw_step_draw_pixels(context->step, replay->submission, view, &drawn, index * rays);
    return index * rays;
}

uint32_t vw_step_replay_draw(const struct vw_step_replay *replay, uint64_t step, uint32_t index) {
    return vw_step_replay_draw_photo(replay, vw_photo_order_view_of_step(replay->context->photo_order, step), step, 0,
                                     index);
}

uint32_t vw_step_replay_row(const struct vw_step_replay *replay, uint32_t index) {
    return index * vw_validation_rows_per_measurement(replay->context->validation);
}

enum vw_status vw_step_replay_run(const struct vw_step_replay *replay) {
    enum vw_status status = vw_submission_submit(replay->submission);
    return !status ? vw_submission_wait(replay->submission) : status;
}

enum vw_status vw_step_replay_tell(const struct vw_step_replay *replay, uint64_t first_step, uint32_t count) {
    const struct vw_trainer_parts *context = replay->context;
    const vw_float4 *rows = vw_buffer_map(context->scalars);
    for (uint32_t i = 0; i < count && replay->replayed; i++) {
        const vw_float4 *row = rows + vw_step_replay_row(replay, i);
        uint64_t step = first_step + i;
        struct vw_step_record record = {.step = step,
                                        .epoch = vw_photo_order_epoch_of_step(context->photo_order, step),
                                        .view = vw_photo_order_view_of_step(context->photo_order, step),
                                        .train_loss = ((double)row->x + row->y) / context->config->rays,
                                        .nonfinite = row->z != 0.0f,
                                        .clamped_count = (uint64_t)row->w,
                                        .val_psnr = NAN,
                                        .val_psnr_pooled = NAN,
                                        .val_l1 = NAN};
        if (!isfinite(record.train_loss)) record.train_loss = NAN;
        enum vw_status status = replay->replayed(replay->replayed_context, &record);
        if (status) return status;
    }
    return VW_OK;
}
