// The effect `occupancy`: training leaves out samples in empty cells of the box (shaders/effects/occupancy.glsl);
// validation never does. The kept samples of a chunk move together, by a prefix sum, so that the passes over them are
// shorter:
//   mark_samples: bits and counts per ray -> place_rays: where rays begin, how many workgroups -> list_samples: slot to
//   sample
// Every OCCUPANCY_STEPS steps the field is sampled to find what is empty; the result (field->occupancy) is part of the
// training's state.
#ifndef VIEWWORTH_TRAIN_EFFECTS_OCCUPANCY_H
#define VIEWWORTH_TRAIN_EFFECTS_OCCUPANCY_H

#include "gpu/compute.h"
#include "train/field.h"

enum { OCCUPANCY_STEPS = 16 };

struct vw_occupancy_effect {                               // all NULL when the effect is off
    struct vw_buffer *bits, *begins, *kept_samples, *kept; // of one chunk, see the slots VW_SLOT_KEPT_*
    struct vw_pass *refresh, *mark, *place, *list;
};

enum vw_status vw_occupancy_create_buffers(const struct vw_radiance_field *field,
                                           struct vw_occupancy_effect *occupancy);
// Bindings of the chunk's kept samples for passes that may skip, unused where the effect is off. Writes them behind
// `*count` and advances it.
void vw_occupancy_bind(const struct vw_radiance_field *field, const struct vw_occupancy_effect *occupancy,
                       struct vw_binding *bindings, uint32_t *count);
// `bindings`: those of occupancy_bind, field_bind, and the step's rays and d_field.
enum vw_status vw_occupancy_create_passes(const struct vw_radiance_field *field, const struct vw_binding *bindings,
                                          uint32_t count, struct vw_occupancy_effect *occupancy);
void vw_occupancy_destroy(struct vw_occupancy_effect *occupancy);

// Records what step `number` does before its rays are sampled.
void vw_occupancy_record_refresh(const struct vw_occupancy_effect *occupancy, struct vw_submission *batch,
                                 uint64_t number, vw_uint4 key);
void vw_occupancy_record_chunk(const struct vw_occupancy_effect *occupancy, struct vw_submission *batch,
                               const struct vw_push_samples *push);

#endif
