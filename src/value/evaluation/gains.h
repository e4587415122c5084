// Gains: which of several lists of photos reconstructs better than all photos, and how sure that is. Every list is
// trained on with the same seeds, and judged on the same validation photos.
#ifndef VIEWWORTH_VALUE_EVALUATION_GAINS_H
#define VIEWWORTH_VALUE_EVALUATION_GAINS_H

#include <stdint.h>

#include "viewworth/status.h"

// The gain of a list over all photos: the mean over validation photos and seeds of the paired differences of PSNR.
struct vw_gain {
    double gain_db, standard_error;
    double ci_low, ci_high; // 98 % interval: a gain exceeds ci_low in 99 of 100 cases, because many lists are tried
};

// Computes the gain of every list over the first one, all photos, from psnr_db[(list * seeds + seed) * views + view].
//
// The variance of a gain has two parts. Validation photos are a sample of those that there could be: the variance over
// photos of the differences, each a mean over seeds, divided by the number of photos. Seeds are a sample, too, and
// shift all photos together: 2 / seeds times the variance of one training's mean PSNR, which is pooled over the lists,
// as the residual of an analysis of variance with the effects list and seed. The interval is Student's with the degrees
// of freedom of Welch and Satterthwaite (Satterthwaite, Biometrics Bulletin 1946), rounded down. A list with the
// results of all photos has the gain 0 for sure. Needs 2 seeds and 2 views; otherwise, and if a result is unknown,
// interval and error are NaN. VW_ERROR_MEMORY.
enum vw_status vw_gains_estimate(const double *psnr_db, uint32_t lists, uint32_t seeds, uint32_t views,
                                 struct vw_gain *gains);

// Returns the list to take: among those whose interval lies above 0 the one with the largest gain; the first one, all
// photos, if there is none.
uint32_t vw_gains_choose(const struct vw_gain *gains, uint32_t lists);

#endif
