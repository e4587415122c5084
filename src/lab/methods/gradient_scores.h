// Methods of the literature that score photos by gradients along one finished run, without a retraining. What they
// compute: lab/gradients/gradient_methods.h.
#ifndef VIEWWORTH_LAB_METHODS_GRADIENT_SCORES_H
#define VIEWWORTH_LAB_METHODS_GRADIENT_SCORES_H

#include "base/interrupt.h"
#include "lab/methods/gradient_list.h"
#include "viewworth/gpu.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"

struct vw_gradient_scores_params {
    struct vw_gpu *gpu;
    const struct vw_scene *scene;  // that the run was trained on
    uint32_t epochs;               // that the run must have; 0: any
    const char *out;               // folder of a finished run of value: its ledger is read, and nothing is written
    const char *store;             // path of a table of scores that are known, and are to be; NULL: none
    struct vw_interrupt interrupt; // asked between submissions; what was finished is in the store
};
// Fills scores[method][photo], photos of the split train in ascending order, more = better, in dB, for the methods
// whose scores are not NULL; NaN where a method has found none. `seconds`: the CPU time of their passes, as it was when
// they were computed; NULL: not asked for. VW_ERROR_USAGE, with the remedy, for a run that no method follows
// (run/recorded/recorded_run.h, lab/gradients/gradient_methods.h); VW_ERROR_MISMATCH when a replayed step is not the
// recorded one.
enum vw_status vw_gradient_scores_make(const struct vw_gradient_scores_params *params,
                                       double *const scores[VW_GRADIENT_METHODS], double seconds[VW_GRADIENT_METHODS]);

#endif
