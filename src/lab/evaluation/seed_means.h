// Scores of several seeds: their mean by photo, its interval over seeds, and which photos it cannot tell apart.
//
// Each seed's scores are taken minus their mean over the photos first, since seeds also differ in a level that all
// photos share, and only differences between photos rank them. The variance of a photo's score over K seeds then has K
// - 1 degrees of freedom, too few for K of two or three. So the mean variance of all photos counts as two more, as in
// uncertainty.h. The 95 % interval is that of Student with K + 1 degrees of freedom. It covers other seeds of the same
// run, and nothing else (uncertainty.h lists what).
#ifndef VIEWWORTH_LAB_EVALUATION_SEED_MEANS_H
#define VIEWWORTH_LAB_EVALUATION_SEED_MEANS_H

#include <stdint.h>

#include "viewworth/status.h"

struct vw_seed_mean {
    double mean, standard_error, ci_low, ci_high; // NaN where a seed has no score of the photo
    uint32_t rank;                                // 1 = highest mean; equal means in the order of the photos
    uint32_t rank_ci_low, rank_ci_high; // no photo whose interval lies above this one's, or below it, is passed over
    uint32_t overlaps;                  // other photos whose intervals overlap this one's: indistinguishable from it
};

// Computes the mean score of each photo over the seeds. `values`: [seed * photo_count + photo], at least two seeds;
// `means`: one per photo. VW_ERROR_MEMORY.
enum vw_status vw_seed_means_make(const double *values, uint32_t seed_count, uint32_t photo_count,
                                  struct vw_seed_mean *means);

#endif
