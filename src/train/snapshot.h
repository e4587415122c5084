// A training's state put aside on the device, so that something else can be tried from it: the steps behind a probe
// have the bits that they have without it.
#ifndef VIEWWORTH_TRAIN_SNAPSHOT_H
#define VIEWWORTH_TRAIN_SNAPSHOT_H

#include "gpu/compute.h"
#include "train/step.h"

struct snapshot {
    struct vw_buffer *state[TRAINING_STATE_BUFFERS_MAX],
        *kept[TRAINING_STATE_BUFFERS_MAX]; // state: borrowed from the step
    uint32_t count;
};

enum vw_status snapshot_create(const struct step_passes *step, struct snapshot *kept);
void snapshot_destroy(struct snapshot *kept);
void snapshot_record_save(const struct snapshot *kept, struct vw_batch *batch);
void snapshot_record_restore(const struct snapshot *kept, struct vw_batch *batch);

#endif
