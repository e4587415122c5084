// Agreement: whether the ranking of a run by dv_psnr can be believed, because it stood still while the training went
// on, and because other validation photos and a longer training would rank alike.
#ifndef VIEWWORTH_VALUE_AGREEMENT_H
#define VIEWWORTH_VALUE_AGREEMENT_H

#include <stdbool.h>
#include <stdint.h>

#include "value/matrix.h"
#include "viewworth/ledger.h"
#include "viewworth/status.h"
#include "viewworth/value.h"

enum {
    VW_AGREEMENT_EPOCHS_MIN = 4, // epochs that count: halves of fewer say too little
    VW_AGREEMENT_VIEWS_MIN = 4,  // validation photos: with fewer, one of them may decide the ranking
};

struct vw_ranking_agreement {
    uint32_t epochs, view_count; // epochs that count; validation photos
    // Spearman's correlations over the train photos; NaN where they are unknown.
    double epoch_halves;    // scores by the first half of the epochs with those by the second
    double better_training; // predicted: with the scores of a training of about ten times the cost
    // Predicted: with the scores by as many other validation photos of the same kind, and its 90 % interval, in [0,1].
    // Unknown without view rows; one photo cannot tell, and has an interval from 0 to 1.
    double other_views, other_views_low, other_views_high;
};

// Measures a run. `matrix` and `scores` are those of the same input. VW_ERROR_MEMORY, VW_ERROR_INPUT as
// vw_value_score().
//
// Other validation photos: a sum over J of them has the variance V of the photos' own effects and a J-th of that of the
// rest, which is photo by validation photo, so that two such sums correlate by 1 - (mean square of the rest) / (mean
// square between photos) (Hoyt, "Test reliability estimated by analysis of variance", 1941). Spearman's correlation of
// a pair of normal variables that correlate by r is 6 / pi asin(r / 2). The interval is by the jackknife of the
// logarithm of that ratio (Arvesen, "Jackknifing U-statistics", 1969), without one validation photo at a time and
// without one block of epochs at a time, their variances added, by Student's t for J - 1 degrees of freedom.
enum vw_status vw_ranking_agreement_measure(const struct vw_value_input *input, const struct vw_matrix *matrix,
                                            const struct vw_ledger_score *scores, uint32_t score_count,
                                            struct vw_ranking_agreement *agreement);

// Returns whether other validation photos may rank the photos otherwise: the interval starts below 0.3. Ranks are then
// not for people to act on. An unknown agreement is not low.
bool vw_ranking_agreement_is_low(const struct vw_ranking_agreement *agreement);

// Returns what a training of about ten times the cost agrees with the scores by: a share of their reliability, which is
// 1 less the ratio of the mean squared standard error to the variance over photos, and 0 below 0 (classical test
// theory). Why this share: src/lab/results/agreement.md. NaN for fewer than three scores with a standard error.
double vw_ranking_agreement_predict(const struct vw_ledger_score *scores, uint32_t score_count);

#endif
