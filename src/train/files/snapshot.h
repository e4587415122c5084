// A copy of a training's state on the device. Whoever tries a step restores the state from the copy, so that later
// steps keep their bits.
#ifndef VIEWWORTH_TRAIN_FILES_SNAPSHOT_H
#define VIEWWORTH_TRAIN_FILES_SNAPSHOT_H

#include "gpu/compute.h"
#include "train/step.h"

struct vw_snapshot {
    struct vw_buffer *state[TRAINING_STATE_BUFFERS_MAX]; // borrowed from the step
    struct vw_buffer *copies[TRAINING_STATE_BUFFERS_MAX];
    uint32_t count;
    struct vw_gpu_objects objects; // owned: the copies
};

enum vw_status vw_snapshot_create(const struct vw_step_passes *step, struct vw_snapshot *snapshot);
void vw_snapshot_destroy(struct vw_snapshot *snapshot);
void vw_snapshot_record_save(const struct vw_snapshot *snapshot, struct vw_submission *submission);
void vw_snapshot_record_restore(const struct vw_snapshot *snapshot, struct vw_submission *submission);

#endif
