#include "value/evaluation/pareto_front.h"

#include <math.h>

static bool dominates(double cost, double worth, double other_cost, double other_worth) {
    return cost <= other_cost && worth >= other_worth && (cost < other_cost || worth > other_worth);
}

void vw_pareto_front_mark(const double *costs, const double *worths, uint32_t count, bool *on_front) {
    for (uint32_t i = 0; i < count; i++) {
        on_front[i] = !isnan(costs[i]) && !isnan(worths[i]);
        for (uint32_t other = 0; other < count && on_front[i]; other++)
            on_front[i] = !dominates(costs[other], worths[other], costs[i], worths[i]); // false for NaN
    }
}
