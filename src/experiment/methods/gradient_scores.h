// Methods of the literature that score photos by gradients along one finished run, without a retraining. What they
// compute: train/gradient_methods.h.
#ifndef VIEWWORTH_GRADIENT_SCORES_H
#define VIEWWORTH_GRADIENT_SCORES_H

#include <stdbool.h>
#include <stdint.h>

#include "base/interrupt.h"
#include "viewworth/gpu.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"

enum vw_gradient_method {
    VW_GRADIENT_IN_RUN_FIRST,
    VW_GRADIENT_IN_RUN_SECOND,
    VW_GRADIENT_TRACIN,
    VW_GRADIENT_TRACIN_ADAM,
    VW_GRADIENT_INFLUENCE,
    VW_GRADIENT_METHODS
};

struct vw_gradient_method_row {
    const char *name, *meaning;
    bool has_sign; // a score below 0 says that the photo harms
    // In trainings with validation: the run, and what the pass takes beside, which the methods of a pass share
    // (../../train/README.md, "Scores from gradients").
    double run_equivalents;
};
extern const struct vw_gradient_method_row vw_gradient_methods[VW_GRADIENT_METHODS];

struct vw_gradient_scores_params {
    struct vw_gpu *gpu;
    const struct vw_scene *scene;  // that the run was trained on
    const char *out;               // of a finished run of value: its ledger is read, and nothing is written
    const char *store;             // path of a table of scores that are known, and are to be; NULL: none
    struct vw_interrupt interrupt; // asked between batches; what was finished is in the store
};
// Fills scores[method][photo], photos of the split train in ascending order, more = better, in dB, for the methods
// whose scores are not NULL; NaN where a method has found none. `seconds`: the CPU time of their passes, as it was when
// they were computed; NULL: not asked for. VW_ERROR_USAGE, with the remedy, for a run that no method follows
// (run/replayed_run.h, train/gradient_methods.h); VW_ERROR_MISMATCH when a replayed step is not the recorded one.
enum vw_status vw_gradient_scores_make(const struct vw_gradient_scores_params *params,
                                       double *const scores[VW_GRADIENT_METHODS], double seconds[VW_GRADIENT_METHODS]);

#endif
