// The effect `pose`: a small correction of each training camera, a shift and a turn, all 0 at first
// (shaders/effects/pose.glsl).
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

struct vw_pose_effect { // all NULL when the effect is off
    struct vw_buffer *moments, *d_positions, *d_poses;
    struct vw_pass *gradient_positions, *gradient, *update;
};

enum vw_status vw_pose_create_buffers(const struct vw_radiance_field *field, uint32_t padded_rays,
                                      struct vw_pose_effect *pose);
// Binds what generate_rays declares, where the effect is off a buffer that exists anyway; and behind it, unless `pose`
// is NULL, what the effect's own passes do.
void vw_pose_bind(const struct vw_radiance_field *field, const struct vw_pose_effect *pose, struct vw_binding *bindings,
                  uint32_t *count);
// `bindings` are those of the step, with vw_pose_bind()'s among them.
enum vw_status vw_pose_create_passes(const struct vw_radiance_field *field, const struct vw_binding *bindings,
                                     uint32_t count, struct vw_pose_effect *pose);
void vw_pose_destroy(struct vw_pose_effect *pose);
// Appends the buffers that one step leaves to the next, beside the params.
void vw_pose_training_state(const struct vw_pose_effect *pose, struct vw_buffer **buffers, uint32_t *count);

// Recorded behind the way back of each chunk, and once the step is known to be taken.
void vw_pose_record_chunk(const struct vw_pose_effect *pose, const struct vw_model *model, struct vw_submission *batch,
                          const struct vw_field_chunk *chunk);
void vw_pose_record_update(const struct vw_pose_effect *pose, struct vw_submission *batch, struct vw_push_update push,
                           uint32_t padded_rays);

// How far the cameras of these views are corrected, 0 without the effect.
enum vw_status vw_pose_measure(const struct vw_radiance_field *field, const uint32_t *views, uint32_t count,
                               struct vw_camera_corrections *corrections);

#endif
