// What the backward sweep needs of the steps of a stretch of training, kept while they are replayed: the params before
// each of them, the gradient that it took, and behind the last one the params that it left.
#ifndef VIEWWORTH_TRAIN_ADJOINT_KEPT_STEPS_H
#define VIEWWORTH_TRAIN_ADJOINT_KEPT_STEPS_H

#include "train/step.h"

struct kept_steps {
    const struct step_passes *step; // borrowed
    uint32_t capacity;              // steps
    struct vw_buffer *params;       // capacity + 1 blocks, see sweep_passes.h
    struct vw_buffer *gradients;    // capacity blocks
    struct vw_buffer *moments;      // likewise; NULL without momentum
    struct vw_buffer *occupancy;    // capacity times field->occupancy; NULL without it
};

// Bytes that one step takes.
uint64_t kept_step_bytes(const struct step_passes *step);
enum vw_status kept_steps_create(const struct step_passes *step, uint32_t capacity, struct kept_steps *kept);
void kept_steps_destroy(struct kept_steps *kept);

// Recorded before a step, and behind it: its gradient, as gathered in a block, and what it has left.
void kept_steps_record_before(const struct kept_steps *kept, struct vw_batch *batch, uint32_t place);
void kept_steps_record_gradient(const struct kept_steps *kept, struct vw_batch *batch, struct vw_buffer *gradient,
                                uint32_t place);
void kept_steps_record_after(const struct kept_steps *kept, struct vw_batch *batch, uint32_t place);

// The blocks of a step, back to where the sweep's passes read them. Of moments: those of grid and weights; photos have
// none here, and count as if they had no momentum.
struct step_blocks {
    struct vw_buffer *before, *after, *gradient, *moment; // moment: NULL without momentum
};
void kept_steps_record_load(const struct kept_steps *kept, struct vw_batch *batch, uint32_t place,
                            const struct step_blocks *blocks);

#endif
