// Buffers, bindings and passes of all effects that are on (kind.h).
#ifndef VIEWWORTH_TRAIN_EFFECTS_PARTS_H
#define VIEWWORTH_TRAIN_EFFECTS_PARTS_H

#include "train/effects/kind.h"

// The buffers of effects, by slot.
struct vw_effect_buffers {
    struct vw_buffer *params;          // the block of all params
    struct vw_buffer *const *of_field; // the buffers that rendering needs as well
    struct vw_buffer *const *of_step;  // NULL outside of a step
};

enum vw_status vw_effects_create_of_field(const struct vw_model *model, struct vw_gpu *gpu,
                                          const struct vw_scene *scene, struct vw_buffer *buffers[VW_SLOT_COUNT]);
enum vw_status vw_effects_create_of_step(const struct vw_model *model, struct vw_gpu *gpu, uint32_t padded_rays,
                                         struct vw_buffer *buffers[VW_SLOT_COUNT]);
void vw_effects_destroy_buffers(struct vw_buffer *buffers[VW_SLOT_COUNT]);

// Binds the buffers of effects and their ranges of params after `*count`, which it advances. Buffers that do not exist
// are bound as unused. Slots that are bound already are left alone.
void vw_effects_bind(const struct vw_model *model, const struct vw_effect_buffers *buffers, struct vw_binding *bindings,
                     uint32_t *count);
// Appends the buffers that one step leaves to the next, beside the params.
void vw_effects_training_state(const struct vw_model *model, const struct vw_effect_buffers *buffers,
                               struct vw_buffer **state, uint32_t *count);

enum vw_status vw_effects_create_passes(const struct vw_model *model, struct vw_gpu *gpu,
                                        const struct vw_pass_params *common, struct vw_effect_sets *effects);
// Creates only the passes that see photos.
enum vw_status vw_effects_create_photo_passes(const struct vw_model *model, struct vw_gpu *gpu,
                                              const struct vw_pass_params *common, struct vw_effect_sets *effects);
void vw_effects_destroy_passes(struct vw_effect_sets *effects);

// Records what a photo makes of the field, before the field sees its rays.
void vw_effects_record_photo(const struct vw_model *model, const struct vw_effect_sets *effects,
                             struct vw_submission *batch, uint32_t view);
// Records what precedes the field's passes over a chunk of rays; `specialization` is theirs.
void vw_effects_record_chunk(const struct vw_specialization *specialization, const struct vw_effect_sets *effects,
                             struct vw_submission *batch, const struct vw_push_samples *chunk);

void vw_effects_list_costs(const struct vw_effect_work *work, struct vw_pass_cost *costs, uint32_t *count);
// Lists the costs of a photo. `seen`: only of the effects that see photos.
void vw_effects_list_photo_costs(const struct vw_model *model, double photos, bool seen, const char *role,
                                 struct vw_pass_cost *costs, uint32_t *count);

#endif
