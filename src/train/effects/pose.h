// The effect `pose`: a small correction of each training camera, a shift and a turn, all 0 at first
// (shaders/pose.glsl).
//   generate_rays: rays of the corrected camera -> ... -> gradient_positions: from the gradients by samples' encodings
//   to those by their positions -> gradient_pose: force and torque of each ray -> update_pose: the photo's correction,
//   lazily
// Training alone uses it: validation and rendering see all cameras as the scene has them. It needs the field hash,
// whose encoding has a gradient by the position, and a box.
#ifndef VIEWWORTH_TRAIN_EFFECTS_POSE_H
#define VIEWWORTH_TRAIN_EFFECTS_POSE_H

#include "gpu/compute.h"
#include "train/camera_corrections.h"
#include "train/field.h"
#include "train/fields/registry.h"

struct pose { // all NULL when the effect is off
    struct vw_buffer *moments, *d_positions, *d_poses;
    struct vw_pass *gradient_positions, *gradient, *update;
};

enum vw_status pose_create_buffers(const struct field *field, uint32_t padded_rays, struct pose *pose);
// Binds what generate_rays declares, where the effect is off a buffer that exists anyway; and behind it, unless `pose`
// is NULL, what the effect's own passes do.
void pose_bind(const struct field *field, const struct pose *pose, struct vw_binding *bindings, uint32_t *count);
// `bindings` are those of the step, with pose_bind()'s among them.
enum vw_status pose_create_passes(const struct field *field, const struct vw_binding *bindings, uint32_t count,
                                  struct pose *pose);
void pose_destroy(struct pose *pose);
// Appends the buffers that one step leaves to the next, beside the params.
void pose_training_state(const struct pose *pose, struct vw_buffer **buffers, uint32_t *count);

// Recorded behind the way back of each chunk, and once the step is known to be taken.
void pose_record_chunk(const struct pose *pose, const struct model *model, struct vw_batch *batch,
                       const struct field_chunk *chunk);
void pose_record_update(const struct pose *pose, struct vw_batch *batch, struct vw_push_update push,
                        uint32_t padded_rays);

// How far the cameras of these views are corrected, 0 without the effect.
enum vw_status pose_measure(const struct field *field, const uint32_t *views, uint32_t count,
                            struct vw_camera_corrections *corrections);

#endif
