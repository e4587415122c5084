// A finished training, repeated: its steps with the pixels that they had, which gives the same bits. What is done at
// each step is up to the caller: the backward pass of lasting credit (lasting.h) or a method that goes forwards
// (gradient_methods.h).
#ifndef VIEWWORTH_TRAIN_ADJOINT_STEP_REPLAY_H
#define VIEWWORTH_TRAIN_ADJOINT_STEP_REPLAY_H

#include "train/step.h"
#include "train/trainer.h"
#include "train/trainer_parts.h"

// Called with every step's record as it is replayed (train_loss, nonfinite; not validated), first to last: the caller
// compares it with what is recorded. What it returns, unless VW_OK, ends the replay.
typedef enum vw_status vw_step_replayed(void *context, const struct vw_step_record *record);

struct vw_step_replay {
    struct vw_trainer *trainer;             // owned
    const struct vw_trainer_parts *context; // borrowed from the trainer
    vw_step_replayed *replayed;             // NULL: not called
    void *replayed_context;
    uint64_t total_steps;
    uint32_t submission_steps; // at most, of a submission
    struct vw_submission *submission;
};

// Creates a replay. `training` is the run's, borrowed for the call. Destroy the replay also after a failure.
enum vw_status vw_step_replay_create(const struct vw_trainer_params *training, vw_step_replayed *replayed,
                                     void *context, struct vw_step_replay *replay);
void vw_step_replay_destroy(struct vw_step_replay *replay);

// Draws the pixels of a step, or records that in the submission, which has begun, at place `index` of one; returns the
// first pixel.
uint32_t vw_step_replay_draw(const struct vw_step_replay *replay, uint64_t step, uint32_t index);
// Draws the same for another photo than the step's, or by another draw than 0, which is the step's own.
uint32_t vw_step_replay_draw_photo(const struct vw_step_replay *replay, uint32_t view, uint64_t step, uint32_t draw,
                                   uint32_t index);
// Returns the first row in the trainer's scalars of place `index` of a submission.
uint32_t vw_step_replay_row(const struct vw_step_replay *replay, uint32_t index);
enum vw_status vw_step_replay_run(const struct vw_step_replay *replay);
// Tells the records of `count` steps, which the submission that ran last has taken from place 0 on.
enum vw_status vw_step_replay_tell(const struct vw_step_replay *replay, uint64_t first_step, uint32_t count);

// ---- Steps that are stored ------------------------------------------------------------------------------------------

// The parts of a stretch of training that the backward pass needs, stored while they are replayed: the params before
// each step, the gradient that it took, and after the last step the params that it left.

struct vw_stored_steps {
    const struct vw_step_passes *step; // borrowed
    struct vw_gpu_objects objects;     // owned: all that follow
    struct vw_buffer *params;          // capacity + 1 blocks, see adjoint_passes.h
    struct vw_buffer *gradients;       // capacity blocks
    struct vw_buffer *moments;         // capacity blocks, too; NULL without momentum
};

uint64_t vw_stored_step_bytes(const struct vw_step_passes *step);
enum vw_status vw_stored_steps_create(const struct vw_step_passes *step, uint32_t capacity,
                                      struct vw_stored_steps *stored);
void vw_stored_steps_destroy(struct vw_stored_steps *stored);

// Records what is stored before a step. The second records what is stored after it: its gradient, as gathered in a
// block, and the params that it left.
void vw_stored_steps_record_before(const struct vw_stored_steps *stored, struct vw_submission *submission,
                                   uint32_t place);
void vw_stored_steps_record_gradient(const struct vw_stored_steps *stored, struct vw_submission *submission,
                                     struct vw_buffer *gradient, uint32_t place);
void vw_stored_steps_record_after(const struct vw_stored_steps *stored, struct vw_submission *submission,
                                  uint32_t place);

// The blocks of a step, back to where the backward pass's passes read them. Of moments: those of grid and weights;
// photos have none here, and count as if they had no momentum.
struct vw_step_blocks {
    struct vw_buffer *before, *after, *gradient, *moment; // moment: NULL without momentum
};
void vw_stored_steps_record_load(const struct vw_stored_steps *stored, struct vw_submission *submission, uint32_t place,
                                 const struct vw_step_blocks *blocks);

#endif
