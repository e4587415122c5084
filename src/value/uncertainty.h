// How far a run's scores may be from the mean over all seeds: error bars from a single run.
//
// A score is a sum of what the photo's visits contribute, one per epoch. Were these independent, the sum of n would
// have n times their variance. They are not: their mean drifts as training goes on, neighbouring epochs are correlated,
// and part of a run (its initialisation, its first orders) moves all epochs alike.
// - Drift: a constant, log(t + 1) and its square (t: epochs from the first that counts, from 1) are fitted to every
// photo's contributions
//   and taken out; fewer terms where there are fewer than 4 epochs for each.
// - The variance of a visit: the mean power of what is left at the cosines cos(pi k (t - 1/2) / epochs) of which the
// drift takes less than
//   half; each power is divided by the share of white noise that the drift leaves there. Two degrees of freedom are the
//   median photo's, so that a photo whose few visits happen to agree is not called certain.
// - Correlation: one for the run, for the epochs of one photo do not tell it: the r of a first-order autoregression
// whose spectrum
//   1 / (1 - 2 r cos w + r^2) fits best the powers averaged over photos, each relative to its photo's variance
//   (Whittle's likelihood, with a prior of standard deviation 0.3 that matters for few numbers only). Its value at
//   frequency 0 makes of the variance of visits that of a sum.
// - What a run's epochs share leaves no trace in them. It is taken to be half as much variance again, so that over 18
// scenes and settings
//   of two to twelve seeds 95 to 97 % of the intervals hold the mean over seeds, of sums, shares of wins and ranks of
//   PSNR and L1 alike. From scene to scene it differs: 97 to 100 % on sacre_coeur, fox and statue_of_liberty, 78 to 100
//   % on recipes in which photos with strong defects are many and seeds two; 94 to 100 % with momentum.
// The 95 % interval takes Student's quantile with as many degrees of freedom as there are cosines, and two.
//
// What it covers: other orders, pixels, jitter and initialisations of a run that is otherwise the same. What it does
// not: other photos beside this one, other validation photos or pixels, other lengths of training, other settings, and
// whether the method measures what a photo is worth.
#ifndef VIEWWORTH_VALUE_UNCERTAINTY_H
#define VIEWWORTH_VALUE_UNCERTAINTY_H

#include <stdint.h>

#include "viewworth/ledger.h"
#include "viewworth/status.h"

struct vw_interval {
    double standard_error, ci_low, ci_high; // interval: 95 %; all NaN below two visits
};

// Of the scores of one method: by_epoch[photo * epochs + epoch] is what the photo's visit in that epoch contributes to
// its sum, NaN where it had none. Epochs in which no photo had one, at either end, are no gaps. A mean is the sum of
// contributions divided by the visits; the ends of a monotone function of the sum are those of the sum, put through it.
// VW_ERROR_MEMORY.
enum vw_status vw_intervals_of_sums(const double *by_epoch, uint32_t photos, uint32_t epochs,
                                    struct vw_interval *intervals);

// Fills rank_ci_low and rank_ci_high of the scores of one method from their values and standard errors: 1 plus the
// photos that are surely better and `count` less those that are surely worse, surely being by 1.645 standard errors of
// the difference (one side, 95 %). Where photos crowd, that holds a photo's rank by the mean over seeds 95 times of
// 100; where they lie apart, more often. 0 where the standard error is NaN; such a photo is neither better nor worse
// than others. Takes count^2 comparisons.
void vw_rank_intervals(struct vw_ledger_score *scores, uint32_t count);

#endif
