// The part of a training step that the effects which are on (kind.h) add.
#ifndef VIEWWORTH_TRAIN_EFFECTS_STEP_EFFECTS_H
#define VIEWWORTH_TRAIN_EFFECTS_STEP_EFFECTS_H

#include "train/effects/kind.h"

// Creates and destroys what effects have beyond buffers and passes.
enum vw_status vw_effects_create_rest(struct vw_step_passes *step);
void vw_effects_destroy_rest(struct vw_step_passes *step);

// Records what the effects add, in the order in which a step records it; see kind.h.
void vw_effects_record_begin(const struct vw_step_passes *step, struct vw_submission *batch, uint64_t number,
                             vw_uint4 key);
void vw_effects_record_rays(const struct vw_step_passes *step, struct vw_submission *batch,
                            const struct vw_push_rays *rays);
void vw_effects_record_chunk_gradient(const struct vw_step_passes *step, struct vw_submission *batch,
                                      const struct vw_push_samples *chunk);
void vw_effects_record_gradient(const struct vw_step_passes *step, struct vw_submission *batch,
                                const struct vw_push_rays *rays, uint64_t number);
void vw_effects_record_update(const struct vw_step_passes *step, struct vw_submission *batch,
                              struct vw_push_update push);

#endif
