// Outcomes of retrainings: one quality of several trainings (of subsets, or without single photos), with several seeds
// each. Trainings without a value are left out. And how reliable these outcomes are, which limits every score.
#ifndef VIEWWORTH_VALUE_EVALUATION_OUTCOMES_H
#define VIEWWORTH_VALUE_EVALUATION_OUTCOMES_H

#include "value/evaluation/evaluation.h"
#include "value/evaluation/paired_comparison.h"

enum { VW_TRUTH_COUNT = 2 };
extern const enum vw_quality vw_truths[VW_TRUTH_COUNT]; // target of scores: val_psnr and test_psnr
extern const char vw_noise_ceiling_name[], vw_chance_name[];

struct vw_outcomes {
    uint32_t count, seed_count;
    uint32_t *kept; // owned; [count]: which subsets
    double *values; // owned; [seed][count]
    double *means;  // [count]: over the seeds; part of `values`
};

// Keeps the subsets of a range whose trainings all have a value. Free them also after a failure.
enum vw_status vw_outcomes_of_subsets(const struct vw_subsets *subsets, struct vw_subset_range range,
                                      enum vw_quality quality, struct vw_outcomes *outcomes);
void vw_outcomes_free(struct vw_outcomes *outcomes);

// The reliability of values[seed][count].
struct vw_reliability {
    double agreement; // mean of Spearman's correlation over all pairs of seeds; NaN with one seed
    double ceiling;   // the largest correlation with the mean of the seeds that noise permits: the square root of that
                      // mean's reliability, which follows from the agreement by the formula of Spearman and Brown
                      // (1910); NaN where the seeds do not agree
};
enum vw_status vw_reliability_find(const double *values, uint32_t seed_count, uint32_t count,
                                   struct vw_reliability *reliability);
// Adds rows <group>/<name> of "noise ceiling" and agreement_<group>/<name> of "outcomes".
enum vw_status vw_evaluate_reliability(const double *values, uint32_t seed_count, uint32_t count, const char *group,
                                       const char *name, struct vw_metrics *metrics);

#endif
