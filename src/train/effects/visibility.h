// The effect `visibility`: what stands before the scene in one photo alone is left out of the loss, as far as a small
// network of the pixel's place and of a code of the photo says so (HA-NeRF's image-dependent 2-D mask,
// shaders/visibility.glsl). The network's weights stand behind all others that update_weights moves; codes are lazy.
//   predict_visibility: how visible each ray is -> backward_rays: the loss and its slope, times that ->
//   gradient_visibility, reduce_visibility: the network's gradient -> update_visibility: the photo's code
// Training alone uses it; validation and rendering do not know it. The backward sweep of lasting credit holds what is
// visible fixed: how a step changes it for later steps is left out.
#ifndef VIEWWORTH_TRAIN_EFFECTS_VISIBILITY_H
#define VIEWWORTH_TRAIN_EFFECTS_VISIBILITY_H

#include "gpu/compute.h"
#include "train/field.h"

struct visibility { // all NULL when the effect is off
    struct vw_buffer *of_rays, *partials, *moments;
    struct vw_pass *predict, *gradient, *reduce, *update;
};

enum vw_status visibility_create_buffers(const struct field *field, uint32_t padded_rays,
                                         struct visibility *visibility);
// `bindings` are those of the step, with visibility_bind()'s among them.
enum vw_status visibility_create_passes(const struct field *field, const struct vw_binding *bindings, uint32_t count,
                                        struct visibility *visibility);
void visibility_destroy(struct visibility *visibility);

// Binds what backward_rays declares; where the effect is off, a buffer that exists anyway.
void visibility_bind(const struct field *field, const struct visibility *visibility, struct vw_binding *bindings,
                     uint32_t *count);
// Appends the buffers that one step leaves to the next, beside the params and the moments of weights.
void visibility_training_state(const struct visibility *visibility, struct vw_buffer **buffers, uint32_t *count);

// Recorded behind generate_rays, whose push it takes; behind backward_rays; and before update_weights.
void visibility_record_forward(const struct visibility *visibility, struct vw_batch *batch,
                               const struct vw_push_rays *rays, uint32_t padded_rays);
void visibility_record_gradients(const struct visibility *visibility, struct vw_batch *batch,
                                 const struct vw_push_rays *rays, uint32_t padded_rays);
void visibility_record_update(const struct visibility *visibility, struct vw_batch *batch,
                              const struct vw_push_update *push);

#endif
