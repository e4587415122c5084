// The evaluation of a trade-off's scores: by trainings on random halves of the photos and by corrupted photos.
#ifndef VIEWWORTH_LAB_EVALUATION_SWEEP_EVALUATION_H
#define VIEWWORTH_LAB_EVALUATION_SWEEP_EVALUATION_H

#include "experiment/retrain.h"
#include "experiment/sweep/sweep.h"

enum { VW_HALF_SEEDS = 2 }; // trainings of each half

struct vw_sweep_evaluation {
    uint32_t halves; // random halves of the photos, each trained on VW_HALF_SEEDS times; 0: none
};

// Lists the ground-truth label of every photo that a retrainer may train on: "clean", or what corrupts it; `known`
// tells whether the scene has any label. The array is owned by the caller, NULL when memory is short; the texts are the
// scene's.
const char **vw_retrainer_list_labels(const struct vw_retrainer *retrainer, bool *known);
// Evaluates the scores of all configurations; a vw_sweep_follower whose context is a struct vw_sweep_evaluation. Trains
// on the halves with the seeds after those of the runs: a shared initialisation would raise their agreement. Writes
// OUT/evaluation.csv, a row per configuration and method:
// - auc: probability that a clean photo scores above a corrupted one
// - lds, lds_ci_low, lds_ci_high: Spearman's correlation of summed scores of halves with what trainings on them reach,
//   and its 95 % interval over the halves
enum vw_status vw_sweep_evaluate(void *context, struct vw_sweep *sweep, const struct vw_score_tables *tables);

#endif
