// The table of methods that need only the steps of a ledger: how each turns the series of visits into a score.
#ifndef VIEWWORTH_VALUE_METHODS_H
#define VIEWWORTH_VALUE_METHODS_H

#include <stdint.h>

#include "value/series.h"

// Fills the weights of the epochs after burn-in; a visit in an epoch of weight 0 does not count. `epoch_count` > 0.
typedef void vw_weighting(double *weights, uint32_t epoch_count);

// The score is the sum of a photo's weighted deltas.
struct vw_method {
    const char *name, *unit;
    enum vw_measure measure;
    enum vw_form form;
    vw_weighting *weighting; // NULL: all weigh 1
};

extern const struct vw_method vw_methods[];
extern const uint32_t vw_method_count;

// Compares two struct vw_ledger_score for qsort.
int vw_score_compare(const void *left, const void *right);
// Copies the scores of a method, in order: an array for free(), whose texts are lent by `scores`.
enum vw_status vw_scores_rank(const struct vw_ledger_score *scores, uint32_t score_count, const char *method,
                              struct vw_ledger_score **ranked, uint32_t *ranked_count);

#endif
