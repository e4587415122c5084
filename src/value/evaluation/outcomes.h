// Outcomes of retrainings: one outcome of several trainings (of subsets, or without single photos), with several seeds
// each. Trainings without a value are left out. And how reliable these outcomes are, which limits every score.
#ifndef VIEWWORTH_VALUE_EVALUATION_OUTCOMES_H
#define VIEWWORTH_VALUE_EVALUATION_OUTCOMES_H

#include "value/evaluation/paired_comparison.h"
#include "value/evaluation/subsets.h"

struct vw_outcomes {
    uint32_t count, seed_count;
    uint32_t *kept; // owned; [count]: which subsets
    double *values; // owned; [seed][count]
    double *means;  // [count]: over the seeds; part of `values`
};

// Keeps the subsets of a range whose trainings all have a value. Free them also after a failure.
enum vw_status vw_outcomes_of_subsets(const struct vw_subsets *subsets, struct vw_subset_range range,
                                      enum vw_outcome outcome, struct vw_outcomes *outcomes);
void vw_outcomes_free(struct vw_outcomes *outcomes);

#endif
