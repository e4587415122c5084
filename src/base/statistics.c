#include "viewworth/statistics.h"

#include <math.h>
#include <stdlib.h>

static int compare(const void *a, const void *b) {
    double left = *(const double *)a, right = *(const double *)b;
    return (left > right) - (left < right);
}

void vw_sort(double *values, uint32_t count) { qsort(values, count, sizeof *values, compare); }

double vw_quantile_of_sorted(const double *sorted, uint32_t count, double share) {
    double place = share * (count - 1);
    uint32_t below = (uint32_t)place, above = below + 1 < count ? below + 1 : below;
    return sorted[below] + (place - below) * (sorted[above] - sorted[below]);
}

double vw_median(double *values, uint32_t count) {
    if (!count) return NAN;
    vw_sort(values, count);
    return vw_quantile_of_sorted(values, count, 0.5);
}

double vw_robust_spread(double *values, uint32_t count) {
    double middle = vw_median(values, count);
    for (uint32_t i = 0; i < count; i++) values[i] = fabs(values[i] - middle);
    return VW_NORMAL_SPREAD * vw_median(values, count);
}
