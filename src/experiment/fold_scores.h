// Scores over folds: the same photos valued by several trainings, each of which leaves some of them out to validate.
//
// A photo has scores x_1 ... x_n in the n folds in which it trained, each with its own standard error e_k
// (uncertainty.h). Its pooled score is their mean.
// - Between folds: the variance s^2 of the x_k, n - 1 degrees of freedom. With so few folds the median photo's variance
//   counts as two degrees more: v = ((n - 1) s^2 + 2 median) / (n + 1).
// - Within folds: w, the mean of the e_k^2.
// Both estimate what one fold's score is uncertain by. v also has what folds differ in (their photos), and w also has
// what the folds' trainings share; so the larger one counts: stderr = sqrt(max(v, w) / n), and the 95 % interval is the
// score +- stderr times Student's quantile for n + 1 degrees of freedom. With n = 1 (two folds) the fold's own error
// and interval stay. The interval of `quality` ends within [0,1].
#ifndef VIEWWORTH_EXPERIMENT_FOLD_SCORES_H
#define VIEWWORTH_EXPERIMENT_FOLD_SCORES_H

#include <stdint.h>

#include "viewworth/ledger.h"
#include "viewworth/status.h"

// The scores of one fold, as vw_value_score() makes them.
struct vw_fold_scores {
    const struct vw_ledger_score *scores;
    uint32_t count;
};

// Pools by method and photo; image_ids mean the same photo in all folds. `*pooled` has the methods in the order of the
// first fold that has them, the photos of each by image_id; its texts are those of the folds. Visits are sums. Ranks
// have intervals by the pooled errors. A photo that no fold has a visit of has the value 0, 0 visits and no errors. The
// caller frees `*pooled`. VW_ERROR_MEMORY.
enum vw_status vw_fold_scores_pool(const struct vw_fold_scores *folds, uint32_t fold_count,
                                   struct vw_ledger_score **pooled, uint32_t *pooled_count);

#endif
