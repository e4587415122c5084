// Medians, quantiles and correlations of a few numbers, and PSNR. Values that are compared must not be NaN.
#ifndef VIEWWORTH_BASE_STATISTICS_H
#define VIEWWORTH_BASE_STATISTICS_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/status.h"

void vw_sort(double *values, uint32_t count);          // sorts ascending
void vw_sort_places(uint32_t *places, uint32_t count); // sorts ascending
// A value and its index in an array.
struct vw_ordered {
    double value;
    uint32_t place;
};
// Lists the values in ascending order; of equal values the earlier one first.
void vw_order(const double *values, uint32_t count, struct vw_ordered *ordered);
// Returns the quantile of sorted values, linear between neighbours; count > 0, share in [0,1].
double vw_quantile_of_sorted(const double *sorted, uint32_t count, double share);
double vw_median(double *values, uint32_t count); // sorts the values; NaN if there are none
// Standard deviation / median absolute deviation of normal values.
#define VW_NORMAL_SPREAD 1.4826
// Returns VW_NORMAL_SPREAD times the median absolute deviation from the median. Overwrites the values; NaN if there are
// none.
double vw_robust_spread(double *values, uint32_t count);

// The spread of values. Mean and squares by Welford's recurrence, which avoids cancellation.
struct vw_spread {
    uint64_t count;
    double mean, squared_deviations;
};
void vw_spread_add(struct vw_spread *spread, double value);
double vw_spread_variance(const struct vw_spread *spread); // sample variance (n - 1); NaN below two values

// Returns the sum of a[i] * b[i], added in order.
double vw_dot(const double *a, const double *b, uint32_t count);
// Returns Pearson's correlation. NaN for fewer than two values, or if one side does not vary.
double vw_pearson(const double *a, const double *b, uint32_t count);
// Computes Spearman's correlation: Pearson's of the ranks. VW_ERROR_MEMORY.
enum vw_status vw_spearman(const double *a, const double *b, uint32_t count, double *correlation);
// Ranks from 1 for the smallest; equal values share the mean of their ranks. VW_ERROR_MEMORY.
enum vw_status vw_ranks(const double *values, uint32_t count, double *ranks);

// Returns the 97.5 % quantile of Student's t (95 % are within +-t), for `degrees` >= 1 of freedom: exact for 1 and 2,
// otherwise by the expansion of Cornish and Fisher, with an error of at most 0.2 %.
double vw_student_quantile(double degrees);
// Returns the 95 % quantile in the same way (90 % are within +-t).
double vw_student_quantile_95(double degrees);
// Returns the 99 % quantile (98 % are within +-t), with an error of at most 1 %.
double vw_student_quantile_99(double degrees);

// Sets on_front[i] if no other choice has at most its cost and at least its quality, one of them strictly better. Equal
// choices are all on the front. A choice with a NaN is not on it and dominates none.
void vw_pareto_front_mark(const double *costs, const double *qualities, uint32_t count, bool *on_front);

// The floor of the MSE (decision 5), which keeps a perfect match finite: 100 dB.
#define VW_MSE_FLOOR 1e-10

// Returns -10 log10(max(mse, VW_MSE_FLOOR)) in dB; NaN stays NaN.
double vw_psnr_db(double mse);

#endif
