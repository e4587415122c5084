// The inside of a sweep, for lasting.c and lasting_gate.c.
#ifndef VIEWWORTH_TRAIN_LASTING_PRIVATE_H
#define VIEWWORTH_TRAIN_LASTING_PRIVATE_H

#include "train/sweep_passes.h"

struct vw_lasting_credit;
struct vw_step_record;
struct vw_trainer;

// The training is cut into segments of equal length, the last one perhaps shorter. Behind a replay that saves the state
// at the beginning of each, the segments are replayed once more from the last to the first, each with its steps kept,
// and swept. The last one is kept the first time, so that a training of a single segment is replayed only once.
struct vw_lasting {
    struct vw_trainer *trainer;          // owned
    const struct probe_context *context; // borrowed from the trainer
    enum vw_status (*replayed)(void *context, const struct vw_step_record *record);
    void *replayed_context;
    uint64_t total_steps;
    uint32_t batch_steps; // at most, replayed
    uint32_t sweep_steps; // at most, swept; fewer where more is carried back
    struct sweep_passes sweep;
    struct kept_steps kept;
    struct snapshot *starts; // owned; by segment, up to the last that is swept
    uint64_t segment_steps;
    uint32_t segment_count;
    struct vw_batch *batch;
    struct vw_lasting_credit *credits; // of the batch handed out last
    double *view_psnr;                 // theirs

    bool replaying;      // else sweeping
    uint64_t state_step; // replaying: the step that the state on the device is behind
    uint64_t until_step; // replaying: up to this one
    uint32_t segment;    // that is kept, or being replayed to be kept
    uint64_t next_step;  // to sweep; 0: done
    uint64_t work_done;
};

// Draws the pixels of a step into the trainer's upload buffer, at place `index` of a batch; returns the first pixel.
uint32_t lasting_draw(const struct vw_lasting *lasting, uint64_t step, uint32_t index);
// The first row in the trainer's scalars of place `index` of a batch.
uint32_t lasting_row(const struct vw_lasting *lasting, uint32_t index);
enum vw_status lasting_run_batch(const struct vw_lasting *lasting);
// Whether U averages over the state behind a step, and over how many.
bool lasting_is_state(const struct vw_lasting *lasting, uint64_t step);
uint32_t lasting_state_count(const struct vw_lasting *lasting);

#endif
