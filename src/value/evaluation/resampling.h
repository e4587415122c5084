// Bootstrap: percentile intervals of statistics over resampled subsets, or photos (Efron 1979). Every statistic of the
// same number of items sees the same resamples, so that differences of statistics are paired.
#ifndef VIEWWORTH_VALUE_EVALUATION_RESAMPLING_H
#define VIEWWORTH_VALUE_EVALUATION_RESAMPLING_H

#include <stdbool.h>
#include <stdint.h>

#include "base/statistics.h"

enum { VW_RESAMPLES = 1000 };

bool vw_all_finite(const double *values, uint32_t count);

// Draws times[resample][item]: how often each of `count` items was drawn. Resample 0 is the items themselves; 1 +
// VW_RESAMPLES in all. Owned by the caller; NULL when memory is short.
uint16_t *vw_resamples_draw(uint32_t count);
// Draws a uniform number in [0,1) for item `item` of resample `resample`; no training and nothing else uses it.
double vw_resampling_unit(uint32_t resample, uint32_t item);
// Draws a standard normal number (Box and Muller 1958) in the same way.
double vw_resampling_normal(uint32_t resample, uint32_t item);

// Sets ci_low and ci_high to the middle 95 % of a statistic's VW_RESAMPLES values, which are sorted; those that are not
// finite are left out.
void vw_resampling_interval(double *resampled, double *ci_low, double *ci_high);

// Adds Spearman's correlation of a and b in every resample, times `weight`, to values[1 + VW_RESAMPLES]; NaN where a
// value of either is not finite. VW_ERROR_MEMORY.
enum vw_status vw_resampled_spearman_add(const double *a, const double *b, const uint16_t *times, uint32_t count,
                                         double weight, double *values);

#endif
