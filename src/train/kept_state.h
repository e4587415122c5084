// A training's state put aside on the device, so that something else can be tried from it: the steps behind a probe have the bits that they
// have without it.
#ifndef VIEWWORTH_TRAIN_KEPT_STATE_H
#define VIEWWORTH_TRAIN_KEPT_STATE_H

#include "step.h"

struct kept_state {
    struct vw_buffer *state[TRAINING_STATE_BUFFERS_MAX], *kept[TRAINING_STATE_BUFFERS_MAX]; // state: borrowed from the step
    uint32_t count;
};

enum vw_status kept_state_create(const struct step_passes *step, struct kept_state *kept);
void kept_state_destroy(struct kept_state *kept);
void kept_state_record_keep(const struct kept_state *kept, struct vw_batch *batch);
void kept_state_record_put_back(const struct kept_state *kept, struct vw_batch *batch);

#endif
