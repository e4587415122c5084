#include "train/adjoint/kept_steps.h"

#include "base/memory.h"
#include "train/passes.h"

static uint64_t block_bytes(const struct vw_step_passes *step) { return step->field->model->param_bytes; }

static bool has_momentum(const struct vw_step_passes *step) { return step->field->model->specialization.momentum; }

uint64_t vw_kept_step_bytes(const struct vw_step_passes *step) {
    return block_bytes(step) * (has_momentum(step) ? 3 : 2);
}

enum vw_status vw_kept_steps_create(const struct vw_step_passes *step, uint32_t capacity, struct vw_kept_steps *kept) {
    *kept = (struct vw_kept_steps){.step = step, .objects = {.gpu = step->field->gpu}};
    uint64_t blocks = block_bytes(step) * capacity;
    const struct vw_buffer_row buffers[] = {
        {&kept->params, "kept_params", blocks + block_bytes(step)},
        {&kept->gradients, "kept_gradients", blocks},
        {&kept->moments, "kept_moments", has_momentum(step) ? blocks : 0},
    };
    enum vw_status status = vw_buffers_create(&kept->objects, VW_BUFFER_DEVICE, buffers, VW_ARRAY_COUNT(buffers));
    if (status) vw_kept_steps_destroy(kept);
    return status;
}

void vw_kept_steps_destroy(struct vw_kept_steps *kept) { vw_gpu_objects_destroy(&kept->objects); }

void vw_kept_steps_record_before(const struct vw_kept_steps *kept, struct vw_submission *submission, uint32_t place) {
    uint64_t block = block_bytes(kept->step);
    vw_submission_copy(submission, kept->step->field->params, 0, kept->params, block * place, block);
}

void vw_kept_steps_record_gradient(const struct vw_kept_steps *kept, struct vw_submission *submission,
                                   struct vw_buffer *gradient, uint32_t place) {
    uint64_t block = block_bytes(kept->step);
    vw_submission_copy(submission, gradient, 0, kept->gradients, block * place, block);
}

void vw_kept_steps_record_after(const struct vw_kept_steps *kept, struct vw_submission *submission, uint32_t place) {
    const struct vw_step_passes *step = kept->step;
    const struct vw_model *model = step->field->model;
    uint64_t first = block_bytes(step) * place;
    vw_kept_steps_record_before(kept, submission, place + 1); // the next step begins where this one ended
    if (kept->moments) {
        if (model->grid.size_bytes)
            vw_submission_copy(submission, step->grid_moment1, 0, kept->moments, first + model->grid.offset_bytes,
                               model->grid.size_bytes);
        vw_submission_copy(submission, step->weight_moments, 0, kept->moments, first + model->weights.offset_bytes,
                           16 * (uint64_t)model->moved_columns);
    }
}

void vw_kept_steps_record_load(const struct vw_kept_steps *kept, struct vw_submission *submission, uint32_t place,
                               const struct vw_step_blocks *blocks) {
    uint64_t block = block_bytes(kept->step);
    vw_submission_copy(submission, kept->params, block * place, blocks->before, 0, block);
    vw_submission_copy(submission, kept->params, block * (place + 1), blocks->after, 0, block);
    vw_submission_copy(submission, kept->gradients, block * place, blocks->gradient, 0, block);
    if (kept->moments) vw_submission_copy(submission, kept->moments, block * place, blocks->moment, 0, block);
}
