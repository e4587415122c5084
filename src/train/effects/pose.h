// The corrections of cameras by the effect `pose` (pose.c).
#ifndef VIEWWORTH_TRAIN_EFFECTS_POSE_H
#define VIEWWORTH_TRAIN_EFFECTS_POSE_H

#include <stdint.h>

#include "viewworth/status.h"

struct vw_camera_corrections; // train/trainer.h
struct vw_radiance_field;

// Measures the corrections of these views' cameras, 0 without the effect.
enum vw_status vw_pose_measure(const struct vw_radiance_field *field, const uint32_t *views, uint32_t count,
                               struct vw_camera_corrections *corrections);

#endif
