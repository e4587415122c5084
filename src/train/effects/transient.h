// The effect `transient` (NeRF-W, Martin-Brualla et al., CVPR 2021): what stands in a photo but not in the scene, such
// as people and cars, is explained by a second density with its own colours and uncertainty, which only training sees.
// It comes from a head, a small network that takes in the field's features at a sample and a code of the photo. Its
// layers are the field's business (mlp_append_head() of fields/mlp.h), its weights stand behind the field's own.
//   feed_transient -> layers -> backward_transient (composites, takes the loss) -> layers back, into the features
// Validation and rendering do without: they see the field's own density alone.
#ifndef VIEWWORTH_TRAIN_EFFECTS_TRANSIENT_H
#define VIEWWORTH_TRAIN_EFFECTS_TRANSIENT_H

#include "gpu/compute.h"
#include "train/field.h"

struct transient { // all NULL when the effect is off
    struct vw_buffer *moments;
    struct vw_pass *update;
};

enum vw_status transient_create_buffers(const struct field *field, struct transient *transient);
void transient_bind(const struct field *field, const struct transient *transient, struct vw_binding *bindings,
                    uint32_t *count);
// `bindings` are those of the step, with transient_bind()'s among them.
enum vw_status transient_create_passes(const struct field *field, const struct vw_binding *bindings, uint32_t count,
                                       struct transient *transient);
void transient_destroy(struct transient *transient);
// Appends the buffers that one step leaves to the next, beside the params.
void transient_training_state(const struct transient *transient, struct vw_buffer **buffers, uint32_t *count);
// Recorded before the weights are updated.
void transient_record_update(const struct transient *transient, struct vw_batch *batch, struct vw_push_update push);

#endif
