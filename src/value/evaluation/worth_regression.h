// Worths by regression of the outcomes of subsets on who is in them, the only such regression: of photos in a
// benchmark, of photos in `worth`, and of providers as players.
//
//   v(S) = c + g size(S) + sum over the players i of w_i x_i(S)
//
// The w_i are shrunk toward a linear function of the players' features f (a prior: other scores), w = B f, and without
// features toward their own mean: sum of squared errors + lambda |w - B f|^2 + rho lambda |B - B0|^2. The size has a
// coefficient of its own, so that shrinking moves no zero. Where sizes of subsets vary, the worths have a true zero:
// below it a player makes trainings worse. Where all sizes are equal, only differences are known. Least-squares worths
// are a datamodel (Ilyas et al. 2022); the prior is that of a multilevel regression (Gelman and Hill 2007, ch. 12).
#ifndef VIEWWORTH_VALUE_EVALUATION_WORTH_REGRESSION_H
#define VIEWWORTH_VALUE_EVALUATION_WORTH_REGRESSION_H

#include "value/evaluation/outcomes.h"

// The form in which a subset's outcome is linear. In both, a worth is what the fit loses when the player leaves all the
// others.
enum vw_worth_form {
    VW_WORTH_SUM,  // size: the share s of the photos; x_i: 1 or 0, less s
    VW_WORTH_MEAN, // for trainings of equal steps, which the members share. Size: log s, since the error falls by a
                   // power of the number of photos; x_i: (1 or 0) / s, less 1. No subset is empty
};

struct vw_worth_params {
    const struct vw_subsets *subsets; // subsets of players
    enum vw_outcome outcome;
    enum vw_worth_form form;
    const double *features; // [feature][player], of mean 0; NULL with feature_count 0
    const double *expected; // [feature], dB: the coefficient toward which B is shrunk; NULL: 0
    uint32_t feature_count;
    bool predict;  // fill `predicted`, `by_size`, pearson and r2, which takes VW_WORTH_FOLDS fits more
    bool resample; // fill `resampled`
    bool draw;     // fill `drawn`
};

struct vw_worths {
    uint32_t photo_count;     // players
    double *values;           // owned; [player], dB; NaN where there are too few subsets
    double *ci_low, *ci_high; // [player]: 95 %; part of `values`
    double *standard_errors;  // [player]; part of `values`
    double *resampled;        // owned; [1 + VW_RESAMPLES][player]: worths by subsets drawn anew; NULL unless asked for
    double *drawn;            // owned; [VW_RESAMPLES][player]: drawn together; NULL unless asked for
    double *predicted;        // owned; [subset]: by the fit without its fold; NaN where that is unknown
    double *by_size;          // [subset]: the same from its size alone; part of `predicted`
    double pearson, r2;       // between predicted and real outcomes
    uint32_t count;           // subsets that the fit is of
};

// Penalties (lambda and rho, 16 and 4 of them) are weighed by cross-validation within each fit: each subset is left out
// in turn (PRESS: Allen 1974), and penalties of the squared error E weigh E^(-n/2), as their likelihoods would (Geisser
// and Eddy 1979). Values are the mean over penalties, intervals contain the variance within and between them (Student).
// `drawn` are draws of all worths together from that distribution: what other subsets and seeds, and photos of which
// the retrainings say little, leave open, with the correlations that intervals of single players lack. Predictions come
// from VW_WORTH_FOLDS folds, each predicted by a fit that knows nothing of it, penalties included.
enum { VW_WORTH_FOLDS = 8 };
// Fits the worths. Fewer than VW_WORTH_FOLDS outcomes give none. Free it also after a failure.
enum vw_status vw_worths_fit(const struct vw_worth_params *params, struct vw_worths *worths);
void vw_worths_free(struct vw_worths *worths);

// The accuracy (worth_accuracy.c).
//
// Spearman's correlation of what is left of left-out outcomes and of their predictions when the part that follows from
// the size alone is taken off: what the players' differences explain. Subsets of all players count in neither. The
// interval is the middle 95 % over resampled subsets.
struct vw_worth_accuracy {
    double spearman, ci_low, ci_high;
    double r2; // accuracy of these parts
    uint32_t count;
    double variance; // rest of the outcomes, dB^2
};
enum vw_status vw_worths_accuracy(const struct vw_worth_params *params, const struct vw_worths *worths,
                                  struct vw_worth_accuracy *accuracy);
// Returns the same for a score per player, summed as the form says, instead of the worths.
enum vw_status vw_worths_score_accuracy(const struct vw_worth_params *params, const struct vw_worths *worths,
                                        const double *scores, struct vw_worth_accuracy *accuracy);

#endif
