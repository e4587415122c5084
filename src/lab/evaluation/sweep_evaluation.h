// The evaluation of a trade-off's scores: by trainings on random halves of the photos and by corrupted photos.
#ifndef VIEWWORTH_LAB_EVALUATION_SWEEP_EVALUATION_H
#define VIEWWORTH_LAB_EVALUATION_SWEEP_EVALUATION_H

#include "experiment/retrain.h"
#include "experiment/sweep/sweep.h"
#include "value/evaluation/subsets.h"

struct vw_sweep_evaluation {
    uint32_t halves;           // random halves of the photos, each trained on twice; 0: none
    struct vw_subsets subsets; // filled by the sweep
};

// Lists the ground-truth label of every photo that a retrainer may train on: "clean", or what corrupts it; `known`
// tells whether the scene has any label. The array is owned by the caller, NULL when memory is short; the texts are the
// scene's.
const char **vw_retrainer_list_labels(const struct vw_retrainer *retrainer, bool *known);
// Returns an evaluator whose context is `evaluation`.
struct vw_sweep_evaluator vw_sweep_evaluator_of(struct vw_sweep_evaluation *evaluation);
void vw_sweep_evaluation_free(struct vw_sweep_evaluation *evaluation);

#endif
