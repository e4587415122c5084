#include "value/evaluation/outcomes.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"

static void keep_subset(const struct vw_retrain_result *results, uint32_t subset, enum vw_outcome outcome,
                        uint32_t stride, struct vw_outcomes *outcomes) {
    uint32_t seeds = outcomes->seed_count;
    double mean = 0;
    for (uint32_t seed = 0; seed < seeds; seed++) {
        double value = vw_outcome_of(&results[seed], outcome);
        outcomes->values[(size_t)seed * stride + outcomes->count] = value;
        mean += value / seeds;
    }
    if (!isfinite(mean)) return;
    outcomes->means[outcomes->count] = mean;
    outcomes->kept[outcomes->count++] = subset;
}

enum vw_status vw_outcomes_of_subsets(const struct vw_subsets *subsets, struct vw_subset_range range,
                                      enum vw_outcome outcome, struct vw_outcomes *outcomes) {
    uint32_t most = range.end - range.begin, seeds = subsets->seed_count;
    *outcomes = (struct vw_outcomes){.seed_count = seeds};
    outcomes->kept = vw_allocate(most, sizeof *outcomes->kept);
    outcomes->values = vw_allocate((size_t)most * (seeds + 1), sizeof *outcomes->values);
    if (!outcomes->kept || !outcomes->values) return VW_ERROR_MEMORY;
    outcomes->means = outcomes->values + (size_t)seeds * most;
    for (uint32_t i = range.begin; i < range.end; i++)
        keep_subset(subsets->results + (size_t)i * seeds, i, outcome, most, outcomes);
    for (uint32_t seed = 1; seed < seeds; seed++) // closes the gaps that subsets without a value leave
        for (uint32_t i = 0; i < outcomes->count; i++)
            outcomes->values[(size_t)seed * outcomes->count + i] = outcomes->values[(size_t)seed * most + i];
    return VW_OK;
}

void vw_outcomes_free(struct vw_outcomes *outcomes) {
    free(outcomes->kept);
    free(outcomes->values);
}
