// When scores have settled (`value --until-stable R`): a pure function of the recorded steps.
//
// After n epochs that count (those from burn-in on of which every train photo's step is recorded) the scores of a
// method are held against what they were after the first n / 2 (rounded down) of them, by Spearman's rank correlation
// over the train photos. Of this the smallest counts after n, n - 1 and n - 2 epochs, so that no chance ends a run.
// Photos that differ only by noise reach about 0.7 at any n, for half of what is summed is the same; a fixed lag of
// some epochs would reach 1 by itself as n grows. Not a promise about other seeds: the part of a score that all epochs
// of a run share is in both sides.
#ifndef VIEWWORTH_STABILITY_H
#define VIEWWORTH_STABILITY_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/value.h"

enum {
    VW_STABILITY_EPOCHS_MIN =
        10,                // epochs that count, before which nothing is called stable: of fewer, half says too little
    VW_STABILITY_ENDS = 3, // of the last epochs, at which the smallest correlation is taken
};

struct vw_stability {
    uint32_t epochs;         // n: epochs that count
    uint32_t earlier_epochs; // those compared with after n
    double correlation; // the smallest; NaN below VW_STABILITY_EPOCHS_MIN, and where the scores of either do not differ
};

// Of the scores of `method`. Steps of an epoch that is not complete are left out.
enum vw_status vw_value_stability(const struct vw_value_input *input, const char *method,
                                  struct vw_stability *stability);
// Whether the correlation reaches `wanted`.
bool vw_stability_reaches(const struct vw_stability *stability, double wanted);

#endif
