// The inside of lasting credit, for lasting.c and lasting_gate.c.
#ifndef VIEWWORTH_TRAIN_ADJOINT_LASTING_PRIVATE_H
#define VIEWWORTH_TRAIN_ADJOINT_LASTING_PRIVATE_H

#include "train/adjoint/adjoint_passes.h"
#include "train/adjoint/step_replay.h"
#include "train/files/snapshot.h"

struct vw_lasting_credit;

// The training is cut into segments of equal length, the last one perhaps shorter. A first replay saves the state at
// the beginning of each. Then the segments are replayed once more from the last to the first, each with its steps kept,
// and gone back over. The last one is kept the first time, so that a training of a single segment is replayed only
// once.
struct vw_lasting {
    struct vw_step_replay replay;
    uint32_t backward_steps; // at most, gone back over at a time; fewer where more is carried back
    struct vw_adjoint_passes backward;
    struct vw_kept_steps kept;
    struct vw_snapshot *starts; // owned; by segment, up to the last that is gone back over
    uint64_t segment_steps;
    uint32_t segment_count;
    struct vw_lasting_credit *credits; // credits of the submission handed out last
    double *view_psnr;                 // theirs

    bool replaying;      // else going back
    uint64_t state_step; // replaying: the step whose result is the state on the device
    uint64_t until_step; // replaying: up to this one
    uint32_t segment;    // that is kept, or being replayed to be kept
    uint64_t next_step;  // to go back over; 0: done
    uint64_t work_done;
};

// Returns whether U averages over the state after a step. The second returns over how many states.
bool vw_lasting_is_state(const struct vw_lasting *lasting, uint64_t step);
uint32_t vw_lasting_state_count(const struct vw_lasting *lasting);

#endif
