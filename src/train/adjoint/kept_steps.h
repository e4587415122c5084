// The parts of a stretch of training that the backward pass needs, kept while they are replayed: the params before each
// step, the gradient that it took, and after the last step the params that it left.
#ifndef VIEWWORTH_TRAIN_ADJOINT_KEPT_STEPS_H
#define VIEWWORTH_TRAIN_ADJOINT_KEPT_STEPS_H

#include "train/step.h"

struct vw_kept_steps {
    const struct vw_step_passes *step; // borrowed
    struct vw_gpu_objects objects;     // owned: all that follow
    struct vw_buffer *params;          // capacity + 1 blocks, see adjoint_passes.h
    struct vw_buffer *gradients;       // capacity blocks
    struct vw_buffer *moments;         // capacity blocks, too; NULL without momentum
};

// Bytes that one step takes.
uint64_t vw_kept_step_bytes(const struct vw_step_passes *step);
enum vw_status vw_kept_steps_create(const struct vw_step_passes *step, uint32_t capacity, struct vw_kept_steps *kept);
void vw_kept_steps_destroy(struct vw_kept_steps *kept);

// Records what is kept before a step. The second records what is kept after it: its gradient, as gathered in a block,
// and the params that it left.
void vw_kept_steps_record_before(const struct vw_kept_steps *kept, struct vw_submission *submission, uint32_t place);
void vw_kept_steps_record_gradient(const struct vw_kept_steps *kept, struct vw_submission *submission,
                                   struct vw_buffer *gradient, uint32_t place);
void vw_kept_steps_record_after(const struct vw_kept_steps *kept, struct vw_submission *submission, uint32_t place);

// The blocks of a step, back to where the backward pass's passes read them. Of moments: those of grid and weights;
// photos have none here, and count as if they had no momentum.
struct vw_step_blocks {
    struct vw_buffer *before, *after, *gradient, *moment; // moment: NULL without momentum
};
void vw_kept_steps_record_load(const struct vw_kept_steps *kept, struct vw_submission *submission, uint32_t place,
                               const struct vw_step_blocks *blocks);

#endif
