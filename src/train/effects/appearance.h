// Photos that differ in exposure, white balance and light: numbers per photo, and the passes that use and update them.
//   light form (effect `appearance`): a gain and a bias per channel of what is rendered, see
//   shaders/effects/appearance.glsl full form (effect `appearance_code`): a code of 48 numbers that enters the colour
//   network, see shaders/effects/mix_code.comp
// Only training uses these numbers. Validation fits a gain and a bias of its own to each view
// (shaders/effects/fit_views.comp), and rendering uses none.
#ifndef VIEWWORTH_TRAIN_EFFECTS_APPEARANCE_H
#define VIEWWORTH_TRAIN_EFFECTS_APPEARANCE_H

#include "gpu/compute.h"
#include "train/field.h"

struct vw_appearance_effect { // the parts of a form that is off are NULL
    struct vw_buffer *d_appearance, *moments;
    struct vw_buffer *code_shift, *code_weight_moments, *code_moments;
    struct vw_pass *update_appearance, *mix_code, *update_code;
};

enum vw_status vw_appearance_create_buffers(const struct vw_radiance_field *field, uint32_t padded_rays,
                                            struct vw_appearance_effect *appearance);
// `bindings` are those of the step, with vw_appearance_bind()'s among them.
enum vw_status vw_appearance_create_passes(const struct vw_radiance_field *field, const struct vw_binding *bindings,
                                           uint32_t count, struct vw_appearance_effect *appearance);
void vw_appearance_destroy(struct vw_appearance_effect *appearance);

// Binds what the shared passes declare. For a form that is off, or when `appearance` is NULL, it binds a buffer that
// exists anyway.
void vw_appearance_bind(const struct vw_radiance_field *field, const struct vw_appearance_effect *appearance,
                        struct vw_binding *bindings, uint32_t *count);

// Appends the buffers that one step leaves to the next, beside the params.
void vw_appearance_training_state(const struct vw_appearance_effect *appearance, struct vw_buffer **buffers,
                                  uint32_t *count);

// Recorded behind generate_rays, which knows the photo; and behind reduce_loss, before any other param is updated.
void vw_appearance_record_forward(const struct vw_appearance_effect *appearance, const struct vw_model *model,
                                  struct vw_submission *batch);
void vw_appearance_record_update(const struct vw_appearance_effect *appearance, struct vw_submission *batch,
                                 struct vw_push_update push, uint32_t padded_rays);

// Whether validation fits gains and biases.
bool vw_appearance_fits_views(const struct vw_model *model);

#endif
