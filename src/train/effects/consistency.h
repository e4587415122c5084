// The view-consistency loss of HA-NeRF (Chen et al., CVPR 2022, section 3.2; its code: train_mask_grid_sample.py,
// losses.py) beside the effect appearance_encoder: what is rendered with a photo's code must have that code again,
// from wherever it is seen.
//   code of an earlier step's photo -> the step's picture rendered with it -> thumbnail -> code of the picture
//   loss: weight * mean |code of the picture - code given|, added to the step's mean loss
// The picture is made of the step's first rays, which lie on a grid over its photo (vw_pixels_draw). The given code is
// held fixed, where it renders and where the two are compared. All gradients of this loss have buffers of their own,
// and are added to those of the step at its end; those of the hash grid are sums of integers.
#ifndef VIEWWORTH_TRAIN_EFFECTS_CONSISTENCY_H
#define VIEWWORTH_TRAIN_EFFECTS_CONSISTENCY_H

#include "gpu/compute.h"
#include "interface.h"
#include "train/effects/kind.h"
#include "train/step_passes.h"

struct vw_consistency_effect {
    struct vw_gpu_objects objects;         // owned: all buffers and passes
    uint32_t side, ray_count, padded_rays; // the picture's, and its rays
    struct vw_push_codes codes;
    struct vw_buffer *rays, *ray_loss, *colours, *d_sky, *d_weights;
    struct vw_buffer *thumbnail, *encoder_rows, *d_encoder_rows, *code_shift; // the picture's, in the encoder's slots
    struct vw_effect_passes give, see; // the encoder on the given photo, forward alone; on the picture
    struct vw_gradient_passes gradient;
    struct vw_pass *composite, *shrink, *spread_colours, *add;
};

// Creates it for a step that is otherwise complete. Leaves NULL where the loss is off (model.consistency_weight).
enum vw_status vw_consistency_create(const struct vw_step_passes *step, struct vw_consistency_effect **consistency);
void vw_consistency_destroy(struct vw_consistency_effect **consistency);

// Records the rays of the picture, after the step's own and before anything may mark the step. This and the next do
// nothing where the loss is off.
void vw_consistency_record_rays(const struct vw_consistency_effect *consistency, struct vw_submission *submission,
                                const struct vw_push_rays *rays);
// Records everything that remains, after the last of the step's own gradients.
void vw_consistency_record_gradients(const struct vw_step_passes *step, struct vw_submission *submission,
                                     uint64_t number);

// Returns the view whose code step `number` renders its picture with: the photo of a step up to this one, drawn at
// random.
uint32_t vw_consistency_given_view(const struct vw_step_passes *step, uint64_t number);

#endif
