// The correlation of one method's scores between runs. Needs only scores.
#ifndef VIEWWORTH_VALUE_EVALUATION_AGREEMENT_H
#define VIEWWORTH_VALUE_EVALUATION_AGREEMENT_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#include "viewworth/status.h"

// Two runs. A correlation of fewer than two photos or of equal scores is NaN.
struct vw_agreement {
    double pearson;  // r, [-1,1]
    double spearman; // rho: r of the ranks, ties share their mean
    uint32_t photos; // compared
};

// Correlates the scores a[i] and b[i] of photo i. Photos that one of both has no finite score for are left out, and
// those that are not `only`, unless that is NULL. VW_ERROR_MEMORY.
enum vw_status vw_agreement_of_pair(const double *a, const double *b, const bool *only, uint32_t count,
                                    struct vw_agreement *agreement);
// Keeps the scores of these photos. Returns how many.
uint32_t vw_agreement_keep(const double *a, const double *b, const bool *only, uint32_t count, double *kept_a,
                           double *kept_b);

#endif
