// Paired comparison of retrainings: means over seeds, and differences between trainings with the same seed, so that the
// seed's noise cancels where both share it.
#ifndef VIEWWORTH_VALUE_EVALUATION_PAIRED_COMPARISON_H
#define VIEWWORTH_VALUE_EVALUATION_PAIRED_COMPARISON_H

#include <stdbool.h>
#include <stdint.h>

#include "ledger/retraining.h"

// The qualities that a result has, named as its fields.
enum vw_quality {
    VW_QUALITY_VAL_PSNR,
    VW_QUALITY_VAL_SSIM,
    VW_QUALITY_VAL_L1,
    VW_QUALITY_TEST_PSNR,
    VW_QUALITY_TEST_SSIM,
    VW_QUALITY_TEST_L1,
    VW_QUALITY_COUNT,
};
const char *vw_quality_name(enum vw_quality quality); // "val_psnr", ...
double vw_quality_of(const struct vw_retrain_result *result, enum vw_quality quality);
bool vw_quality_higher_is_better(enum vw_quality quality); // not of L1

struct vw_quality_mean {
    double mean, standard_error; // NaN where a result lacks the value; the standard error also for fewer than two
};
struct vw_quality_mean vw_quality_average(const struct vw_retrain_result *results, uint32_t count,
                                          enum vw_quality quality);

// Averages numbers in the same way.
struct vw_quality_mean vw_samples_average(const double *samples, uint32_t count);

// The mean of the differences samples[i] - against[i] of trainings with the same seed. A negative difference of L1 is
// better.
struct vw_paired_difference {
    double difference, standard_error; // NaN as above
    double ci_low, ci_high; // 95 % interval: Student's t with count - 1 degrees of freedom; NaN below two seeds
    bool beyond_noise;      // the interval does not hold 0
};
struct vw_paired_difference vw_samples_compare(const double *samples, const double *against, uint32_t count);

#endif
