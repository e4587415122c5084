// The effect `visibility`: what stands before the scene in one photo alone is left out of the loss, as far as a small
// network of the pixel's place and of a code of the photo says so (HA-NeRF's image-dependent 2-D mask,
// shaders/effects/visibility.glsl). The network's weights stand behind all others that update_weights moves; codes are
// lazy.
//   predict_visibility: how visible each ray is -> backward_rays: the loss and its slope, times that ->
//   gradient_visibility, reduce_visibility: the network's gradient -> update_visibility: the photo's code
// Training alone uses it; validation and rendering do not know it. The backward sweep of lasting credit holds what is
// visible fixed: how a step changes it for later steps is left out.
#ifndef VIEWWORTH_TRAIN_EFFECTS_VISIBILITY_H
#define VIEWWORTH_TRAIN_EFFECTS_VISIBILITY_H

#include "gpu/compute.h"
#include "train/field.h"

struct vw_visibility_effect { // all NULL when the effect is off
    struct vw_buffer *of_rays, *partials, *moments;
    struct vw_pass *predict, *gradient, *reduce, *update;
};

enum vw_status vw_visibility_create_buffers(const struct vw_radiance_field *field, uint32_t padded_rays,
                                            struct vw_visibility_effect *visibility);
// `bindings` are those of the step, with vw_visibility_bind()'s among them.
enum vw_status vw_visibility_create_passes(const struct vw_radiance_field *field, const struct vw_binding *bindings,
                                           uint32_t count, struct vw_visibility_effect *visibility);
void vw_visibility_destroy(struct vw_visibility_effect *visibility);

// Binds what backward_rays declares; where the effect is off, a buffer that exists anyway.
void vw_visibility_bind(const struct vw_radiance_field *field, const struct vw_visibility_effect *visibility,
                        struct vw_binding *bindings, uint32_t *count);
// Appends the buffers that one step leaves to the next, beside the params and the moments of weights.
void vw_visibility_training_state(const struct vw_visibility_effect *visibility, struct vw_buffer **buffers,
                                  uint32_t *count);

// Recorded behind generate_rays, whose push it takes; behind backward_rays; and before update_weights.
void vw_visibility_record_forward(const struct vw_visibility_effect *visibility, struct vw_submission *batch,
                                  const struct vw_push_rays *rays, uint32_t padded_rays);
void vw_visibility_record_gradients(const struct vw_visibility_effect *visibility, struct vw_submission *batch,
                                    const struct vw_push_rays *rays, uint32_t padded_rays);
void vw_visibility_record_update(const struct vw_visibility_effect *visibility, struct vw_submission *batch,
                                 const struct vw_push_update *push);

#endif
