// Photo worths by regression of the outcomes of all subsets on who is in them: v(S) = c + sum of beta_i over the photos
// i in S, a ridge regression whose beta are shrunk toward their own mean, not toward 0, so that shrinking moves no
// zero. Where sizes of subsets vary, the worths have a true zero: below it a photo makes trainings worse. Where all
// sizes are equal, only differences of worths are known, and their mean is 0. Least-squares worths are a datamodel
// (Ilyas et al. 2022).
#ifndef VIEWWORTH_VALUE_WORTH_REGRESSION_H
#define VIEWWORTH_VALUE_WORTH_REGRESSION_H

#include "value/evaluation/outcomes.h"

extern const char vw_subset_worth_name[]; // "subset_worth"

struct vw_worths {
    uint32_t photo_count;
    double *values;           // owned; [photo], dB; NaN where there are too few subsets
    double *ci_low, *ci_high; // [photo]: 95 %, over resampled subsets; part of `values`
    double *resampled;        // owned; [1 + VW_RESAMPLES][photo]
    double *predicted;        // owned; [subset]: by the fit without its fold; NaN where that is unknown
    double pearson, r2;       // of predicted and real outcomes
    uint32_t count;           // subsets that the fit is of
};

// The strength of shrinking is chosen by cross-validation over VW_WORTH_FOLDS folds of subsets, within each fit.
enum { VW_WORTH_FOLDS = 8 };
// Free it also after a failure.
enum vw_status vw_worths_fit(const struct vw_subsets *subsets, enum vw_quality quality, struct vw_worths *worths);
void vw_worths_free(struct vw_worths *worths);

#endif
