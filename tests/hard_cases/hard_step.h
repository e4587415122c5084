// Whole steps and renderings of a bench held against the reference, whatever the params and the rays are: for hard
// cases.
#ifndef VIEWWORTH_TESTS_SUPPORT_HARD_STEP_H
#define VIEWWORTH_TESTS_SUPPORT_HARD_STEP_H

#include "hard_cases/hard_case.h"
#include "kernels/checks/check.h"
#include "reference/reference.h"
#include "reference/step_bench.h"

// The sizes that most hard cases share, and the loss that has no kink.
#define HARD_SIZES .rays = 64, .samples = 16, .levels = 4, .log2_table = 8, .width = 16
#define HARD_STEP HARD_SIZES, .loss = VW_LOSS_L2

// The state a step starts from and leaves, read back.
struct hard_state {
    struct grid_state grid;               // its `grid` is the whole params block
    float *weight_moments;                // first all first moments, then all second ones
    float *effect_moments[VW_SLOT_COUNT]; // moments of codes, which their effects move; NULL where they are off
    vw_float4 scalars;                    // results of the last step: loss high and low, not finite, clamped
    bool skipped;                         // the last step was not finite before its update
};
struct hard_state hard_state_read(struct step_bench *bench);

// The gradients on the device of one step: of the sum over rays.
struct hard_gradients {
    float *weights;  // in the order of the params block, then the sky's
    int64_t *quanta; // per feature of the grid
};

// Puts bench->pixels, changed by the test, where the device reads them.
void hard_write_pixels(struct step_bench *bench);

// Sets all densities' logarithms to `weight` times the sum of the hidden units, which are never below 0.
void hard_set_density(struct step_bench *bench, float weight);

// Runs step `number` from the params on the device and holds losses, gradients and the updated params and moments
// against the reference's, which it returns. All must be finite and the step not flagged.
struct reference_step *hard_check_step(struct hard_finding *finding, struct step_bench *bench, uint64_t number);
// Runs the first half of hard_check_step(): takes the gradients of step `number`. They are cleared on the device, so
// that a whole step can follow.
struct hard_gradients hard_take_gradients(struct step_bench *bench, uint64_t number);
// Checks what step `number` made of `before` with these gradients. A step that is not finite must have changed nothing;
// where an update would leave the floats, the params must be as they were; in both cases the row must be flagged.
void hard_check_update(struct hard_finding *finding, const struct step_bench *bench, uint64_t number,
                       const struct hard_gradients *gradients, const struct hard_state *before,
                       const struct hard_state *after);
// Checks that step 1 is skipped and says so where a pixel's loss is infinite.
void hard_check_infinite_loss(struct hard_finding *finding, struct step_bench *bench);

// Renders bench->pixels as validation does and holds colours and transmittance against the reference's.
void hard_check_rendering(struct hard_finding *finding, struct step_bench *bench);

#endif
