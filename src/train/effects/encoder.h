// The encoder of the effect appearance_encoder, for those that use it beside a step's own passes: it makes a code of 48
// numbers from a photo's thumbnail. Slots of its buffers: VW_SLOT_THUMBNAILS, VW_SLOT_ENCODER_ROWS, VW_SLOT_CODE_SHIFT
// of a field, and VW_SLOT_D_ENCODER_ROWS of a step.
#ifndef VIEWWORTH_TRAIN_EFFECTS_ENCODER_H
#define VIEWWORTH_TRAIN_EFFECTS_ENCODER_H

#include "train/effects/kind.h"
#include "train/effects/thumbnails.h"
#include "train/model.h"
#include "train/passes.h"

struct vw_radiance_field;

// Its passes, forward and back.
enum { ENCODER_CONVOLVE, ENCODER_POOL, ENCODER_SPREAD, ENCODER_CONVOLVE_BACK, ENCODER_GRADIENT, ENCODER_PASSES };

// Returns the range of its network in the params, empty without the effect.
struct vw_param_range vw_encoder_network(const struct vw_model *model);

// Gives the field another thumbnail of a view from here on. Does nothing without the effect.
enum vw_status vw_encoder_set_thumbnail(const struct vw_radiance_field *field, const struct vw_scene *scene,
                                        uint32_t view, const struct vw_thumbnail_choice *choice);

// Creates a set of passes of its own, with vw_shader_spread_photo_codes in place of vw_shader_spread_photo; without
// `back` only the first two.
enum vw_status vw_encoder_create_passes(struct vw_gpu_objects *objects, const struct vw_pass_params *common, bool back,
                                        struct vw_effect_passes *set);
// Records the code of a photo. In a step the photo is the step's; record it after generate_rays.
void vw_encoder_record_forward(struct vw_pass *const *passes, struct vw_submission *batch, uint32_t view);
// Records its gradient, after the field's way back. `codes`: what spread_photo_codes takes, NULL without it.
void vw_encoder_record_back(struct vw_pass *const *passes, const struct vw_push_codes *codes,
                            struct vw_submission *batch);

#endif
