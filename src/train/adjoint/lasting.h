// Lasting credit: what each step of a finished training leaves at its end, by a backward pass over its steps (MAGIC,
// arXiv 2504.16430; Hara et al. 2019; Gauss-Newton products: Martens 2010). The training is replayed bit for bit. Then
// lambda, the gradient of U (validation PSNR, and minus validation L1, averaged over states of the last epochs) by the
// params, is carried back from step to step; a step's credit is what U gains by the step, to first order.
#ifndef VIEWWORTH_TRAIN_ADJOINT_LASTING_H
#define VIEWWORTH_TRAIN_ADJOINT_LASTING_H

#include "train/adjoint/adjoint_passes.h"
#include "train/adjoint/step_replay.h"
#include "train/files/training_files.h"

enum { VW_LASTING_EPOCHS = 4, VW_LASTING_STATES = 32 }; // U: at most so many states, evenly spread over the last epochs

struct vw_lasting_params {
    const struct vw_trainer_params *training; // the run's; `validate` set; borrowed until vw_lasting_create returns
    uint32_t rays;                            // rays of each step that the product takes; 0: all (--lasting-rays)
    bool by_view; // also credits of each validation view's own PSNR (--lasting-matrix). Each costs up to half a
                  // backward pass
    uint64_t memory_bytes;      // limit for what is stored on the device; 0: chosen by it. Changes no bit
    vw_step_replayed *replayed; // NULL: not called
    void *context;
};

struct vw_lasting_credit {
    uint64_t step;
    uint32_t view;           // trained on, scene index
    double psnr, loss;       // dB of U gained; mean absolute error removed. 0 for a step that was skipped (not finite)
    const double *view_psnr; // with by_view: dB that each validation view gains, in image order; lent. Else NULL
    double size_psnr, size_loss; // |lambda| at the step: how much it grows towards the first step tells trust
};

// `psnr` is the mean of view_psnr but for rounding, and for the differences of colours: the steps at which they are
// taken depend on what is carried back.
struct vw_lasting;
// Returns VW_ERROR_USAGE, with the remedy, for a training that vw_lasting_create refuses. Call before it takes its
// steps.
enum vw_status vw_lasting_check_trainer(struct vw_trainer *trainer);
enum vw_status vw_lasting_create(const struct vw_lasting_params *params, struct vw_lasting **lasting);
void vw_lasting_destroy(struct vw_lasting **lasting);

// Works for about half a second. Lends credits until the next call, from the last step of the training to the first;
// count may be 0 while the training is replayed. `done` when step 1 was handed out.
enum vw_status vw_lasting_advance(struct vw_lasting *lasting, const struct vw_lasting_credit **credits, uint32_t *count,
                                  bool *done);
struct vw_lasting_state {
    uint64_t work_done, work_total; // in steps, replayed and gone back over (more for each, by_view): for progress
    uint64_t next_step;             // the next credit handed out is of this step; 0: done
    uint64_t memory_bytes;          // bytes stored on the device
};
void vw_lasting_get_state(const struct vw_lasting *lasting, struct vw_lasting_state *state);

// Saves the backward pass so far as a file (lambda and place, written as checkpoints are, then the caller's rows, of
// row_bytes for each step whose credit was handed out), after an advance. The second restores it, before the first
// advance: then credits begin with those of *next_step, and `*rows` is owned by the caller. The training is replayed
// again. VW_ERROR_INPUT: the file is damaged, or belongs to another run or other settings; the backward pass is then
// untouched.
enum vw_status vw_lasting_save(struct vw_lasting *lasting, const char *path, const void *rows, size_t row_bytes);
enum vw_status vw_lasting_load(struct vw_lasting *lasting, const char *path, size_t row_bytes, void **rows,
                               uint64_t *next_step);

// The gate: once all credits are handed out, tests what they say. The steps on `view` after `from_step` are made longer
// by VW_LASTING_SCALED of themselves in a retraining from there on with everything else as it was. The change of U
// against the recorded training, per length of a step, is to be compared with the sum of the credits of these steps.
#define VW_LASTING_SCALED 0.1
struct vw_lasting_check {
    uint32_t view;                       // given: scene index
    double measured_psnr, measured_loss; // in units of the credits; NaN where a retraining was not finite
};
// Measures that change; `records`: those of the training, by step. Without momentum only, where a step is its photo's
// own (VW_ERROR_USAGE). `from_step`: before the first of the states that U averages over (vw_lasting_first_state).
enum vw_status vw_lasting_measure(struct vw_lasting *lasting, const struct vw_step_record *records, uint64_t from_step,
                                  struct vw_lasting_check *checks, uint32_t count);
uint64_t vw_lasting_first_state(const struct vw_lasting *lasting);

// ---- The inside, for lasting.c and tests ----------------------------------------------------------------------------

// The training is cut into segments of equal length, the last one perhaps shorter. A first replay saves the state at
// the beginning of each. Then the segments are replayed once more from the last to the first, each with its steps
// stored, and gone back over. The last one is stored the first time, so that a training of a single segment is replayed
// only once.
struct vw_lasting {
    struct vw_step_replay replay;
    uint32_t backward_steps; // at most, gone back over at a time; fewer where more is carried back
    struct vw_adjoint_passes backward;
    struct vw_stored_steps stored;
    struct vw_snapshot *starts; // owned; by segment, up to the last that is gone back over
    uint64_t segment_steps;
    uint32_t segment_count;
    struct vw_lasting_credit *credits; // credits of the submission handed out last
    double *view_psnr;                 // theirs

    bool replaying;      // else going back
    uint64_t state_step; // replaying: the step whose result is the state on the device
    uint64_t until_step; // replaying: up to this one
    uint32_t segment;    // that is stored, or being replayed to be stored
    uint64_t next_step;  // to go back over; 0: done
    uint64_t work_done;
};

// Returns whether U averages over the state after a step. The second returns over how many states.
bool vw_lasting_is_state(const struct vw_lasting *lasting, uint64_t step);
uint32_t vw_lasting_state_count(const struct vw_lasting *lasting);

#endif
