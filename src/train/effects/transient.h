// The effect `transient` (NeRF-W, Martin-Brualla et al., CVPR 2021): what stands in a photo but not in the scene, such
// as people and cars, is explained by a second density with its own colours and uncertainty, which only training sees.
// It comes from a head, a small network that takes in the field's features at a sample and a code of the photo. Its
// layers are the field's business (vw_mlp_append_head() of fields/mlp.h), its weights stand behind the field's own.
//   feed_transient -> layers -> backward_transient (composites, takes the loss) -> layers back, into the features
// Validation and rendering do without: they see the field's own density alone.
#ifndef VIEWWORTH_TRAIN_EFFECTS_TRANSIENT_H
#define VIEWWORTH_TRAIN_EFFECTS_TRANSIENT_H

#include "gpu/compute.h"
#include "train/field.h"

struct vw_transient_effect { // all NULL when the effect is off
    struct vw_buffer *moments;
    struct vw_pass *update;
};

enum vw_status vw_transient_create_buffers(const struct vw_radiance_field *field,
                                           struct vw_transient_effect *transient);
void vw_transient_bind(const struct vw_radiance_field *field, const struct vw_transient_effect *transient,
                       struct vw_binding *bindings, uint32_t *count);
// `bindings` are those of the step, with vw_transient_bind()'s among them.
enum vw_status vw_transient_create_passes(const struct vw_radiance_field *field, const struct vw_binding *bindings,
                                          uint32_t count, struct vw_transient_effect *transient);
void vw_transient_destroy(struct vw_transient_effect *transient);
// Appends the buffers that one step leaves to the next, beside the params.
void vw_transient_training_state(const struct vw_transient_effect *transient, struct vw_buffer **buffers,
                                 uint32_t *count);
// Recorded before the weights are updated.
void vw_transient_record_update(const struct vw_transient_effect *transient, struct vw_submission *batch,
                                struct vw_push_update push);

#endif
