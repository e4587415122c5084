// Scores of photos from gradients along a finished training, without another one: first and second order of In-Run Data
// Shapley, TracIn, and influence functions. Each replays the training forwards (step_replay.h) and works with the
// passes of the backward pass (train/adjoint/adjoint_passes.h), whose check names what it refuses (VW_ERROR_USAGE). U
// is validation PSNR.
#ifndef VIEWWORTH_LAB_GRADIENTS_GRADIENT_METHODS_H
#define VIEWWORTH_LAB_GRADIENTS_GRADIENT_METHODS_H

#include "base/interrupt.h"
#include "train/adjoint/step_replay.h"

struct vw_gradient_params {
    const struct vw_trainer_params *training; // params of the run's training; `validate` set; borrowed for the call
    vw_step_replayed *replayed;               // NULL: not called
    void *context;
    struct vw_interrupt interrupt; // asked between submissions: VW_ERROR_INTERRUPTED
};

// In-Run Data Shapley (Wang et al. 2024): what a step d, as the optimiser took it, changes in U there and then. A step
// is of one photo, so that nothing is shared among photos.
//   first_order    grad U(before) . d
//   second_order   (grad U(before) + grad U(after)) . d / 2
// The latter is the trapezoidal rule. It equals grad U . d + d . Hessian d / 2 up to the third order of d, needs no
// product with a Hessian, no division by a small step, and no Gauss-Newton approximation: with the gradients of all
// states at hand it costs nothing more.
struct vw_in_run_credit {
    double first_order, second_order; // dB; NaN where validation was not finite
};
// Computes the credits of step 1, 2, ..., as many as the training has.
enum vw_status vw_in_run_credits(const struct vw_gradient_params *params, struct vw_in_run_credit *credits);

// TracIn (Pruthi et al. 2020) at checkpoints, ends of epochs spread evenly over those after burn-in: the change of U if
// the next step were on the photo, summed over checkpoints.
//   plain            -rate grad U . gradient of the photo's loss: TracInCP, as if by gradient descent
//   preconditioned   grad U . the step that the optimiser takes
// The photo's pixels are drawn as a step draws them, anew at every checkpoint.
struct vw_tracin_score {
    double plain, preconditioned; // dB; NaN where a step was not finite
};
enum { VW_TRACIN_CHECKPOINTS = 10 };
// Computes scores by photo that is trained on, in ascending order of scene indices. `checkpoints`: at most so many.
enum vw_status vw_tracin_scores(const struct vw_gradient_params *params, uint32_t checkpoints,
                                struct vw_tracin_score *scores);

// Influence functions (Koh and Liang 2017) at the end of the training: what U loses there without the photo, were the
// mean loss of all photos at its minimum and quadratic:
//   -(gradient of the photo's loss) . s / photos,   (H + damping scale / P) s = grad U
// H is the Gauss-Newton matrix of the mean loss, P what Adam multiplies gradients by. LiSSA (Agarwal et al. 2017, as in
// FastIF, Guo et al. 2021), preconditioned by P, finds s by
//   x <- P grad U + (1 - damping) x - P H x / scale,   s = x / scale
// with H of one photo's rays in turn. Without P the sizes of eigenvalues differ by more than iterations can make good.
// Params of photos (appearance, codes), and those that never moved, are held fixed.
//
// In the metric of P each iteration must not lengthen x but for what grad U adds. Where one does, its scale is below
// half an eigenvalue of P H: the scale is doubled, which raises the damping as well, and the iterations start anew.
// Beyond `scale_max` there is no score: `found` is false, and the scores are NaN.
struct vw_influence_settings {
    uint32_t iterations; // the last half of them, in whole passes over the photos, is averaged; 0: see below
    double damping;      // damping of an iteration; 0: VW_INFLUENCE_DAMPING
    double scale;        // to begin with; 0: 1
    double scale_max;    // 0: VW_INFLUENCE_SCALE_MAX
    uint32_t draws;      // draws of every photo's pixels, for its gradient; 0: VW_INFLUENCE_DRAWS
};
#define VW_INFLUENCE_DAMPING 0.01
#define VW_INFLUENCE_SCALE_MAX 1024.0
enum { VW_INFLUENCE_DRAWS = 4, VW_INFLUENCE_ITERATIONS = 400, VW_INFLUENCE_PASSES = 4 }; // the more of the last two
struct vw_influence_result {
    bool found;
    double scale;        // that it was found with
    double size, growth; // |x| at the end; over that of P grad U, at most 1 / damping
    uint32_t iterations; // all of them, those that came to nothing included
};
// Computes scores in the order of vw_tracin_scores.
enum vw_status vw_influence_scores(const struct vw_gradient_params *params,
                                   const struct vw_influence_settings *settings, double *scores,
                                   struct vw_influence_result *result);

#endif
