// A copy of a training's state on the device. A probe changes the state and restores it from the copy, so that later
// steps have the same bits as without the probe.
#ifndef VIEWWORTH_TRAIN_SNAPSHOT_H
#define VIEWWORTH_TRAIN_SNAPSHOT_H

#include "gpu/compute.h"
#include "train/step.h"

struct snapshot {
    struct vw_buffer *state[TRAINING_STATE_BUFFERS_MAX];  // borrowed from the step
    struct vw_buffer *copies[TRAINING_STATE_BUFFERS_MAX]; // owned
    uint32_t count;
};

enum vw_status snapshot_create(const struct step_passes *step, struct snapshot *snapshot);
void snapshot_destroy(struct snapshot *snapshot);
void snapshot_record_save(const struct snapshot *snapshot, struct vw_batch *batch);
void snapshot_record_restore(const struct snapshot *snapshot, struct vw_batch *batch);

#endif
