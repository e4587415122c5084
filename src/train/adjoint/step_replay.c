#include "train/adjoint/step_replay.h"

#include <math.h>

#include "base/memory.h"
#include "train/passes.h"
#include "train/renderers/volume/volume.h"

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

// ---- Steps that are stored ------------------------------------------------------------------------------------------

static uint64_t block_bytes(const struct vw_step_passes *step) { return step->field->model->param_bytes; }

static bool has_momentum(const struct vw_step_passes *step) { return step->field->model->specialization.momentum; }

uint64_t vw_stored_step_bytes(const struct vw_step_passes *step) {
    return block_bytes(step) * (has_momentum(step) ? 3 : 2);
}

enum vw_status vw_stored_steps_create(const struct vw_step_passes *step, uint32_t capacity,
                                      struct vw_stored_steps *stored) {
    *stored = (struct vw_stored_steps){.step = step, .objects = {.gpu = step->field->gpu}};
    uint64_t blocks = block_bytes(step) * capacity;
    const struct vw_buffer_row buffers[] = {
        {&stored->params, "stored_params", blocks + block_bytes(step)},
        {&stored->gradients, "stored_gradients", blocks},
        {&stored->moments, "stored_moments", has_momentum(step) ? blocks : 0},
    };
    enum vw_status status = vw_buffers_create(&stored->objects, VW_BUFFER_DEVICE, buffers, VW_ARRAY_COUNT(buffers));
    if (status) vw_stored_steps_destroy(stored);
    return status;
}

void vw_stored_steps_destroy(struct vw_stored_steps *stored) { vw_gpu_objects_destroy(&stored->objects); }

void vw_stored_steps_record_before(const struct vw_stored_steps *stored, struct vw_submission *submission,
                                   uint32_t place) {
    uint64_t block = block_bytes(stored->step);
    vw_submission_copy(submission, stored->step->field->params, 0, stored->params, block * place, block);
}

void vw_stored_steps_record_gradient(const struct vw_stored_steps *stored, struct vw_submission *submission,
                                     struct vw_buffer *gradient, uint32_t place) {
    uint64_t block = block_bytes(stored->step);
    vw_submission_copy(submission, gradient, 0, stored->gradients, block * place, block);
}

void vw_stored_steps_record_after(const struct vw_stored_steps *stored, struct vw_submission *submission,
                                  uint32_t place) {
    const struct vw_step_passes *step = stored->step;
    const struct vw_model *model = step->field->model;
    uint64_t first = block_bytes(step) * place;
    vw_stored_steps_record_before(stored, submission, place + 1); // the next step begins where this one ended
    if (stored->moments) {
        if (vw_volume_of(model)->grid.size_bytes)
            vw_submission_copy(submission, vw_volume_step_of(step)->grid_moment1, 0, stored->moments,
                               first + vw_volume_of(model)->grid.offset_bytes, vw_volume_of(model)->grid.size_bytes);
        vw_submission_copy(submission, step->weight_moments, 0, stored->moments, first + model->weights.offset_bytes,
                           16 * (uint64_t)model->moved_columns);
    }
}

void vw_stored_steps_record_load(const struct vw_stored_steps *stored, struct vw_submission *submission, uint32_t place,
                                 const struct vw_step_blocks *blocks) {
    uint64_t block = block_bytes(stored->step);
    vw_submission_copy(submission, stored->params, block * place, blocks->before, 0, block);
    vw_submission_copy(submission, stored->params, block * (place + 1), blocks->after, 0, block);
    vw_submission_copy(submission, stored->gradients, block * place, blocks->gradient, 0, block);
    if (stored->moments) vw_submission_copy(submission, stored->moments, block * place, blocks->moment, 0, block);
}
