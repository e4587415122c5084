// The evidence of a run about its own ranking by dv_psnr: whether it stood still while the training went
// on, and whether the validation photos agree on it.
#ifndef VIEWWORTH_VALUE_RANKING_AGREEMENT_H
#define VIEWWORTH_VALUE_RANKING_AGREEMENT_H

#include <stdint.h>

#include "value/matrix.h"
#include "viewworth/ledger.h"
#include "viewworth/status.h"
#include "viewworth/value.h"

enum {
    VW_AGREEMENT_EPOCHS_MIN = 4, // epochs that count: halves of fewer say too little
    VW_AGREEMENT_VIEWS_MIN = 4,  // validation photos: with fewer, one of them may decide the ranking
    VW_AGREEMENT_DIVISIONS = 20, // divisions of the validation photos, over which the mean is taken
};

struct vw_ranking_agreement {
    uint32_t epochs, view_count; // epochs that count; validation photos
    // Spearman's correlations over the train photos; NaN where they are unknown.
    double epoch_halves;    // scores by the first half of the epochs with those by the second
    double better_training; // predicted: with the scores of a training of about ten times the cost
    // Scores by one half of the validation photos with those by the other: the mean over the divisions, of a
    // random half each (vw_halves_split), r, corrected to the length of all photos (Spearman 1910, Brown 1910): 2 r /
    // (1 + r); r itself where it is negative. It predicts the correlation with the scores by as many other photos of
    // the same kind.
    double view_halves;
};

// Measures a run. `matrix` and `scores` are those of the same input. VW_ERROR_MEMORY, VW_ERROR_INPUT as
// vw_value_score().
enum vw_status vw_ranking_agreement_measure(const struct vw_value_input *input, const struct vw_matrix *matrix,
                                            const struct vw_ledger_score *scores, uint32_t score_count,
                                            struct vw_ranking_agreement *agreement);

// Returns what a training of about ten times the cost agrees with the scores by: a share of their reliability, which is
// 1 less the ratio of the mean squared standard error to the variance over photos, and 0 below 0 (classical test
// theory). Why this share: src/lab/results/agreement.md. NaN for fewer than three scores with a standard error.
double vw_ranking_agreement_predict(const struct vw_ledger_score *scores, uint32_t score_count);

#endif
