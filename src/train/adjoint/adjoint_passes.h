// The passes of the backward pass (lasting.h) at one step of a finished training. They go forward and back through the
// step's rays by the passes of the training itself; what is their own works on blocks: buffers with a float for every
// param, laid out as the params are.
//   direct_adjoint: the step's credit, and a direction
//   -> colours forward and backward along it -> difference x curvature = slopes -> back -> added to the adjoint
// The adjoint begins as the gradient of U, which is added at every state that U averages over:
//   validation -> slope_views -> back -> added to the adjoint
// The passes have one adjoint to work on. Every measure of U keeps its own in `by_measure`, and it is copied there and
// back.
#ifndef VIEWWORTH_TRAIN_ADJOINT_ADJOINT_PASSES_H
#define VIEWWORTH_TRAIN_ADJOINT_ADJOINT_PASSES_H

#include "train/adjoint/step_replay.h"
#include "train/renderers/volume/volume.h"
#include "train/trainer_parts.h"

// Measures of U, each with an adjoint of its own: of all validation views, and after these, where asked for, the PSNR
// of one view after another.
enum vw_adjoint_measure { ADJOINT_PSNR, ADJOINT_LOSS, ADJOINT_OF_VIEWS };

// The gradients that a step leaves in their several forms, brought into one block.
struct vw_gathered {
    struct vw_buffer *block;                       // borrowed
    struct vw_pass *grid[VW_LEVELS_MAX], *weights; // grid: per window
    struct vw_pass *codes;                         // NULL without the effect appearance_code
};

struct vw_adjoint_blocks {
    struct vw_buffer *lambda, *moment; // moment: NULL without momentum
};

struct vw_adjoint {
    struct vw_adjoint_blocks blocks;
    struct vw_gathered sum; // adds to lambda
    struct vw_pass *direct;
};

struct vw_adjoint_passes {
    const struct vw_trainer_parts *context; // borrowed
    uint32_t rays;                          // most rays of a step that the product takes
    struct vw_gpu_objects objects;          // owned: all buffers and passes
    struct vw_step_blocks blocks;
    struct vw_buffer *direction, *sums, *state, *seen_ahead;
    struct vw_buffer *places;   // the places of all samples of a step, with importance samples: they are held fixed
    struct vw_buffer *val_rays; // vw_ray per ray of validation: slopes in place of targets
    // val_rays as they begin, for a single view and for all of them, where views have weights: the rays have these.
    struct vw_buffer *plain_rays, *weighted_rays;
    struct vw_buffer *rows;                        // READBACK: vec4 per step of a submission and measure
    struct vw_gradient_passes product, validation; // from slopes that are given
    struct vw_field_passes forward;                // for colours forward and backward along it: nothing is stored
    struct vw_pass *perturb, *difference, *reduce;
    struct vw_pass *normalise_step, *slope_views, *normalise_views;
    struct vw_gathered step_gradient; // writes blocks.gradient
    struct vw_adjoint adjoint;
    struct vw_adjoint_blocks *by_measure; // owned
    uint32_t measure_count;
    bool views_on_host; // the host has the adjoints of single views
};

struct vw_adjoint_params {
    uint32_t rays;             // rays of each step that the product takes, at most the step's; 0: all
    uint32_t submission_steps; // rows for so many
    bool psnr_alone;           // no other measure than validation PSNR
    bool by_view;              // also the PSNR of each single validation view; without psnr_alone
    // Memory for the adjoints of single views on the device: more lie in host memory. Changes no bit.
    uint64_t views_memory_bytes;
};
// Returns VW_ERROR_USAGE and names the reason for a training that the backward pass cannot go back over: with half
// tables, with an effect that the backward pass does not go back through, or with params beyond one binding.
enum vw_status vw_adjoint_check(const struct vw_trainer_parts *context);
// Checks that first.
enum vw_status vw_adjoint_create(const struct vw_trainer_parts *context, const struct vw_adjoint_params *params,
                                 struct vw_adjoint_passes *backward);
// Returns the bytes that the adjoints of single views take on the device.
uint64_t vw_adjoint_views_bytes(const struct vw_adjoint_passes *backward);
void vw_adjoint_destroy(struct vw_adjoint_passes *backward);

// Replays step `number`, with its pixels at `first_pixel`: as vw_step_record_passes() does, which gives the same bits,
// and keeps at `place` what the backward pass needs of it.
void vw_adjoint_record_stored_step(const struct vw_adjoint_passes *backward, const struct vw_stored_steps *stored,
                                   struct vw_submission *submission, uint64_t number, uint32_t first_pixel,
                                   uint32_t scalar_row, uint32_t place);

// Adds U's gradient at the state after the step that is loaded to the adjoints, U being 1 / `states` of it.
void vw_adjoint_record_state(const struct vw_adjoint_passes *backward, struct vw_submission *submission,
                             uint32_t scalar_row, uint32_t states);

// Carries the adjoints back over step `number`, which is loaded, and writes its rows, one per measure, from `row` on.
void vw_adjoint_record_step(const struct vw_adjoint_passes *backward, struct vw_submission *submission, uint64_t number,
                            uint32_t first_pixel, uint32_t row);

// ---- For methods that go forwards, too (lab/gradients/) -------------------------------------------------------------

// Takes step `number` as vw_step_record_passes() does, which gives the same bits, and leaves its gradient in the block.
void vw_adjoint_record_own_step(const struct vw_adjoint_passes *backward, struct vw_submission *submission,
                                uint64_t number, uint32_t first_pixel, uint32_t scalar_row);
// Adds to the adjoint the curvature of the loss of these rays, which are made, at the params `before` in the blocks,
// times the direction.
void vw_adjoint_record_product(const struct vw_adjoint_passes *backward, struct vw_submission *submission,
                               const struct vw_push_rays *rays);

#endif
