#include "value/evaluation/pareto_front.h"

#include <math.h>

static bool dominates(double cost, double quality, double other_cost, double other_quality) {
    return cost <= other_cost && quality >= other_quality && (cost < other_cost || quality > other_quality);
}

void vw_pareto_front_mark(const double *costs, const double *qualities, uint32_t count, bool *on_front) {
    for (uint32_t i = 0; i < count; i++) {
        on_front[i] = !isnan(costs[i]) && !isnan(qualities[i]);
        for (uint32_t other = 0; other < count && on_front[i]; other++)
            on_front[i] = !dominates(costs[other], qualities[other], costs[i], qualities[i]); // false for NaN
    }
}
