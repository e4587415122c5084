// Uncertainty of scores: how far a score may be from the mean over all seeds, estimated from a single run.
//
// A score is the sum of the contributions of the photo's visits, one per epoch. If these were independent, the sum of n
// would have n times their variance. They are not: their mean drifts during training, neighbouring epochs are
// correlated, and part of a run (its initialisation, its first orders) affects all epochs alike.
// - Drift: a constant, log(t + 1) and its square (t: epochs counted from 1 at the first one that counts) are fitted to
//   each photo's contributions and removed. There are fewer terms if there are fewer than 4 epochs for each.
// - Variance of a visit: the mean power of the residuals at the cosines cos(pi k (t - 1/2) / epochs). Cosines of which
//   the drift removes more than half are left out; each power is divided by the share of white noise that remains. The
//   median photo's variance counts as two degrees of freedom, so that a photo whose few visits happen to agree does not
//   get a tiny error.
// - Correlation: one value for the run, because the epochs of one photo do not determine it. It is the r of a
// first-order
//   autoregression whose spectrum 1 / (1 - 2 r cos w + r^2) fits best the powers averaged over photos, each relative to
//   its photo's variance (Whittle's likelihood, with a prior of standard deviation 0.3 that matters only for few
//   numbers). The spectrum at frequency 0 converts the variance of visits into that of their sum.
// - What all epochs of a run share cannot be seen in them. It is assumed to add half as much variance again. With this,
//   95 to 97 % of the intervals contain the mean over seeds, over 18 scenes and configurations of two to twelve seeds,
//   for sums and ranks of PSNR and L1 alike. Scenes differ: 97 to 100 % on sacre_coeur, fox and
//   statue_of_liberty, 78 to 100 % on recipes with many strong defects and two seeds, 94 to 100 % with momentum.
// The 95 % interval uses Student's quantile; its degrees of freedom are the number of cosines plus two.
//
// The interval of a score covers other orders, pixels, jitter and initialisations of the same run. It does not cover
// other train photos, other validation photos or pixels, another configuration, or whether the method measures what a
// photo is worth. The interval of a rank covers longer trainings as well, whose scores lie elsewhere
// (vw_length_variance()).
#ifndef VIEWWORTH_VALUE_UNCERTAINTY_H
#define VIEWWORTH_VALUE_UNCERTAINTY_H

#include <stdint.h>

#include "viewworth/ledger.h"
#include "viewworth/status.h"

struct vw_interval {
    double standard_error, ci_low, ci_high; // interval: 95 %; all NaN below two visits
};

// The variance of a score relative to what its own epochs show: see above.
extern const double vw_run_variance;

// Computes the uncertainty of the scores of one method. by_epoch[photo * epochs + epoch] is the contribution of the
// photo's visit in that epoch, NaN if there was none. Epochs at either end without any visit do not count as gaps.
// VW_ERROR_MEMORY.
enum vw_status vw_intervals_of_sums(const double *by_epoch, uint32_t photos, uint32_t epochs,
                                    struct vw_interval *intervals);

// Returns the variance that a longer training adds to every score: a share of the squared robust spread of the scores
// over photos. Why this share: src/lab/results/agreement.md. Overwrites the values; 0 if there are none.
double vw_length_variance(double *values, uint32_t count);

// Fills rank_ci_low and rank_ci_high of the scores of one method, from their values and standard errors, to whose
// squares `added_variance` is added (0: other seeds alone). rank_ci_low is 1 plus the number of photos that are surely
// better, rank_ci_high is `count` minus the number that are surely worse; surely means by 1.645 standard errors of the
// difference (95 % on one side). With 0 the interval contains the photo's rank by the mean over seeds in at least 95 of
// 100 cases. It is 0, 0 if the standard error is NaN; such a photo counts as neither better nor worse than others.
// Takes count^2 comparisons.
void vw_rank_intervals(struct vw_ledger_score *scores, uint32_t count, double added_variance);

#endif
