// Photos that differ in exposure, white balance and light: the numbers of the step's photo, and the passes that use and
// move them.
//   light form (effect `appearance`): a gain and a bias per channel of what is rendered, see shaders/appearance.glsl
//   full form (effect `appearance_code`): a code of 48 numbers that enters the colour network, see
//   shaders/mix_code.comp
// Both only train: validation fits a gain and a bias of its own to each view (shaders/fit_views.comp), and rendering
// knows no photo.
#ifndef VIEWWORTH_TRAIN_APPEARANCE_H
#define VIEWWORTH_TRAIN_APPEARANCE_H

#include "gpu/compute.h"
#include "train/field.h"

struct appearance { // what belongs to a form that is off is NULL
    struct vw_buffer *d_appearance, *moments;
    struct vw_buffer *code_shift, *code_weight_moments, *code_moments;
    struct vw_pass *update_appearance, *mix_code, *update_code;
};

enum vw_status appearance_create_buffers(const struct field *field, uint32_t padded_rays,
                                         struct appearance *appearance);
// `bindings` are those of the step, with appearance_bind()'s among them.
enum vw_status appearance_create_passes(const struct field *field, const struct vw_binding *bindings, uint32_t count,
                                        struct appearance *appearance);
void appearance_destroy(struct appearance *appearance);

// Binds what the shared passes declare; where a form is off, or `appearance` NULL, something that exists anyway in its
// place.
void appearance_bind(const struct field *field, const struct appearance *appearance, struct vw_binding *bindings,
                     uint32_t *count);

// Appends what one step leaves to the next, beside the params.
void appearance_training_state(const struct appearance *appearance, struct vw_buffer **buffers, uint32_t *count);

// Behind generate_rays, which knows the photo; and behind reduce_loss, but before any other param moves.
void appearance_record_forward(const struct appearance *appearance, const struct model *model, struct vw_batch *batch);
void appearance_record_update(const struct appearance *appearance, struct vw_batch *batch, struct vw_push_update push,
                              uint32_t padded_rays);

// Whether validation fits gains and biases.
bool appearance_fits_views(const struct model *model);

#endif
