// The encoder of the effect appearance_encoder, for those that use it beside a step's own passes: it makes a code of 48
// numbers from a photo's thumbnail. Slots of its buffers: VW_SLOT_THUMBNAILS, VW_SLOT_ENCODER_ROWS, VW_SLOT_CODE_SHIFT
// of a field, and VW_SLOT_D_ENCODER_ROWS of a step.
#ifndef VIEWWORTH_TRAIN_EFFECTS_APPEARANCE_ENCODER_H
#define VIEWWORTH_TRAIN_EFFECTS_APPEARANCE_ENCODER_H

#include "gpu/compute.h"
#include "interface.h"
#include "train/effects/kind.h"
#include "train/model.h"
#include "train/passes.h"
#include "train/pixels.h"
#include "train/renderers/volume/volume.h"

struct vw_radiance_field;

struct vw_thumbnail_choice {
    struct vw_pixel_columns columns; // the photo's
    bool masks;                      // mask files are obeyed
};

// Writes THUMBNAIL_PIXELS pixels, rows top to bottom. Each is the mean over an equal part of the columns, parts of
// pixels counted by their area: x, y, z of 2 rgb - 1, w of 1. A pixel that is left out (vw_view_keeps) counts as 0 in
// all four, a transparent one by its alpha. So w is the share that counts, and a photo all masked is all 0.
void vw_thumbnail_make(const struct vw_view *view, const struct vw_thumbnail_choice *choice, vw_float4 *thumbnail);

// Returns the range of its network in the params, empty without the effect.
struct vw_param_range vw_encoder_network(const struct vw_model *model);

// Gives the field another thumbnail of a view from here on. Does nothing without the effect.
enum vw_status vw_encoder_set_thumbnail(const struct vw_radiance_field *field, const struct vw_scene *scene,
                                        uint32_t view, const struct vw_thumbnail_choice *choice);

// ---- The consistency loss -------------------------------------------------------------------------------------------

// The view-consistency loss of HA-NeRF (Chen et al., CVPR 2022, section 3.2; its code: train_mask_grid_sample.py,
// losses.py) beside the effect appearance_encoder: what is rendered with a photo's code must have that code again,
// from wherever it is seen.
//   code of an earlier step's photo -> the step's picture rendered with it -> thumbnail -> code of the picture
//   loss: weight * mean |code of the picture - code given|, added to the step's mean loss
// The picture is made of the step's first rays, which lie on a grid over its photo (vw_pixels_draw). The given code is
// held fixed, where it renders and where the two are compared. All gradients of this loss have buffers of their own,
// and are added to those of the step at its end; those of the hash grid are sums of integers.
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

// Returns the view whose code step `number` renders its picture with: the photo of a step up to this one, drawn at
// random.
uint32_t vw_consistency_given_view(const struct vw_step_passes *step, uint64_t number);

#endif
