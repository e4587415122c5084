// The effect `appearance_encoder` (HA-NeRF, Chen et al., CVPR 2022, section 3.1): photos that differ in exposure, white
// balance and light. A small convolutional network makes a code of 48 numbers from a photo's thumbnail
// (effects/thumbnails.h); the code enters the colour network as those of appearance_code do. The network's weights
// stand behind all others that update_weights moves.
//   convolve_photo, pool_photo: the photo's code and the shift of the colour network -> the field, forward and back ->
//   spread_photo, convolve_photo_back, gradient_photo: gradients of the network
// A photo that nothing was trained on has a code as well: validation and renders of a view see it by the view's own
// photo. They remain a function of the params alone: thumbnails are the scene's.
#ifndef VIEWWORTH_TRAIN_EFFECTS_APPEARANCE_ENCODER_H
#define VIEWWORTH_TRAIN_EFFECTS_APPEARANCE_ENCODER_H

#include "gpu/compute.h"
#include "train/effects/thumbnails.h"
#include "train/model.h"

struct vw_appearance_encoder_effect { // of a field; all NULL when the effect is off, as below
    struct vw_buffer *thumbnails, *rows, *code_shift;
};

struct vw_encoder_passes { // of a step or an evaluator: forward
    struct vw_pass *convolve, *pool;
};

struct vw_encoder_gradient { // of a step
    struct vw_buffer *d_rows;
    struct vw_pass *spread, *convolve_back, *gradient;
};

// Makes the thumbnails of all photos. VW_ERROR_USAGE where they are too many for the device.
enum vw_status vw_encoder_create(struct vw_gpu *gpu, const struct vw_model *model, const struct vw_scene *scene,
                                 struct vw_appearance_encoder_effect *encoder);
void vw_encoder_destroy(struct vw_appearance_encoder_effect *encoder);
// Another thumbnail of a view from here on.
enum vw_status vw_encoder_set_thumbnail(const struct vw_appearance_encoder_effect *encoder,
                                        const struct vw_scene *scene, uint32_t view,
                                        const struct vw_thumbnail_choice *choice);

// Binds what its passes and the field's declare; nothing where the effect is off. `gradient`: NULL outside of a step.
void vw_encoder_bind(const struct vw_appearance_encoder_effect *encoder, const struct vw_encoder_gradient *gradient,
                     struct vw_binding *bindings, uint32_t *count);

// `params` has no shader yet; its bindings have vw_encoder_bind()'s among them.
enum vw_status vw_encoder_create_passes(struct vw_gpu *gpu, const struct vw_appearance_encoder_effect *encoder,
                                        const struct vw_pass_params *params, struct vw_encoder_passes *passes);
void vw_encoder_destroy_passes(struct vw_encoder_passes *passes);
// Recorded before the field renders rays of the view; in a step, whose view it is, behind generate_rays. Does nothing
// when the effect is off.
void vw_encoder_record_forward(const struct vw_encoder_passes *passes, struct vw_submission *batch, uint32_t view);

enum vw_status vw_encoder_gradient_create_buffers(struct vw_gpu *gpu, const struct vw_model *model,
                                                  struct vw_encoder_gradient *gradient);
// `spread`: the first of them, vw_shader_spread_photo or its variant for the consistency loss.
enum vw_status vw_encoder_gradient_create_passes(struct vw_gpu *gpu, const struct vw_pass_params *params,
                                                 const struct vw_shader *spread, struct vw_encoder_gradient *gradient);
void vw_encoder_gradient_destroy(struct vw_encoder_gradient *gradient);
// Recorded behind the field's way back. `codes`: what the variant takes, else NULL.
void vw_encoder_gradient_record(const struct vw_encoder_gradient *gradient, const struct vw_push_codes *codes,
                                struct vw_submission *batch);

#endif
