// The checkpoints of a run: two files in its folder; saving overwrites the older one (decision 11 of src/README.md).
// They trail the ledger: a checkpoint has a step that is recorded.
#ifndef VIEWWORTH_RUN_CHECKPOINTS_H
#define VIEWWORTH_RUN_CHECKPOINTS_H

#include <stdbool.h>
#include <stdint.h>

#include "train/trainer.h"
#include "viewworth/status.h"
#include "viewworth/train.h"

struct vw_checkpoints {
    char *paths[2]; // owned
    int next;       // the one to overwrite
    double due_s;   // when the next is to be saved
    double interval_s;
};

enum vw_status vw_checkpoints_open(const char *out, struct vw_checkpoints *checkpoints);
void vw_checkpoints_close(struct vw_checkpoints *checkpoints);

// Loads the newest usable checkpoint of a step up to `last_step` into the trainer, and warns of one that is not usable.
// Without any, `*found` is false, `*step` is 0 and the trainer stays at its start.
enum vw_status vw_checkpoints_load(struct vw_checkpoints *checkpoints, struct vw_trainer *trainer, uint64_t last_step,
                                   bool *found, uint64_t *step);
// Starts the time until the first one is due.
void vw_checkpoints_begin(struct vw_checkpoints *checkpoints);
// Returns whether the next one is due: after 1 s, then 2, 4, ... up to every 30 s, and rarely enough to cost at most a
// twentieth of the time.
bool vw_checkpoints_due(const struct vw_checkpoints *checkpoints);
// Saves the trainer's state; nothing may be in flight. A failure is a warning: the ledger has all that counts.
void vw_checkpoints_save(struct vw_checkpoints *checkpoints, struct vw_trainer *trainer);

#endif
