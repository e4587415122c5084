// All measures of the agreement of one method's scores between runs that differ only by their seed. Needs only scores.
#ifndef VIEWWORTH_LAB_EVALUATION_FULL_AGREEMENT_H
#define VIEWWORTH_LAB_EVALUATION_FULL_AGREEMENT_H

#include <stdbool.h>
#include <stdint.h>

#include "value/evaluation/score_tables.h"

// Clean: photos whose ground-truth label is "clean". Agreement on which photos are corrupted is easy and raises the
// correlation over all. Positive: photos with a score above 0, the set that the paper keeps. Most extreme: farthest
// from the median by the scores of either run. The distance of a photo is the larger one of its two |score - median| /
// spread, with median and robust spread (statistics.h) over the photos of that run; without the division for a run
// whose spread is 0. For equal distances the earlier photo is left out. One or two outliers raise r although the order
// of the others is chance.
enum vw_agreement_measure {
    VW_AGREEMENT_PEARSON,          // r, [-1,1]
    VW_AGREEMENT_SPEARMAN,         // rho: r of the ranks, ties share their mean
    VW_AGREEMENT_TRIMMED_PEARSON,  // r without the two most extreme photos
    VW_AGREEMENT_CLEAN_PEARSON,    // r within the clean photos
    VW_AGREEMENT_CLEAN_SPEARMAN,   // rho of the same
    VW_AGREEMENT_POSITIVE_JACCARD, // photos positive in both runs / photos positive in either, [0,1]
    VW_AGREEMENT_SAME_SIGN,        // share of photos that both runs call positive, or neither, [0,1]
    VW_AGREEMENT_SIGN_KAPPA, // the same beyond chance: Cohen's kappa (J. Cohen, "A coefficient of agreement for nominal
                             // scales", 1960), (observed - expected) / (1 - expected)
    VW_AGREEMENT_COUNT
};
const char *vw_agreement_name(enum vw_agreement_measure measure); // "pearson", "clean_spearman", ...

// Two runs. A measure is NaN where it is undefined: a correlation of fewer than two photos (the trimmed one: of
// fewer than five) or of equal scores, within clean photos without ground-truth labels, the Jaccard index where neither
// run has a positive photo, kappa where both runs give all photos the same sign. Measures of signs are NaN for methods
// without a zero (vw_full_agreement_of_pairs).
struct vw_full_agreement {
    double values[VW_AGREEMENT_COUNT];
    uint32_t photos, clean; // compared
};

// Compares the scores a[i] and b[i] of photo i. Photos that one of both has no finite score for are left out. `clean`
// is NULL without ground-truth labels. VW_ERROR_MEMORY.
enum vw_status vw_full_agreement_of_pair(const double *a, const double *b, const bool *clean, uint32_t count,
                                         struct vw_full_agreement *agreement);

// The number of 95 % intervals of single runs that contain the photo's mean over seeds, estimated from the other runs.
// That mean is known from few runs: it is moved towards the score by 1 / sqrt(1 + 1 / (runs - 1)), so that correct
// intervals contain it in 95 of 100 cases whatever the number of runs. The intervals of one photo share runs: the share
// is known less well than from as many independent ones.
struct vw_coverage {
    double share;       // NaN: no interval is known
    uint32_t intervals; // one per photo and run
};
struct vw_coverage vw_agreement_coverage(const struct vw_score_tables *tables, const struct vw_score_table *table);

// Compares all pairs of a method's runs, (0,1), (0,2), ..., (1,2), ...: run_count * (run_count - 1) / 2, owned by the
// caller (free).
enum vw_status vw_full_agreement_of_pairs(const struct vw_score_tables *tables, const struct vw_score_table *table,
                                          struct vw_full_agreement **pairs, uint32_t *pair_count);
// A measure over all pairs of runs; pairs where it is undefined are left out; NaN when none is left. Pairs share runs,
// so their range is narrower than that of as many independent ones.
struct vw_agreement_summary {
    double mean, lowest, highest;
    uint32_t pairs;
};
struct vw_agreement_summary vw_full_agreement_summarise(const struct vw_full_agreement *pairs, uint32_t pair_count,
                                                        enum vw_agreement_measure measure);

#endif
