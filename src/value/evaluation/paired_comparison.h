// What sets of photos lead to, held against one another: means over seeds, and differences of trainings with the same
// seed, which share whatever luck the seed brings.
#ifndef VIEWWORTH_VALUE_COMPARISON_H
#define VIEWWORTH_VALUE_COMPARISON_H

#include <stdbool.h>
#include <stdint.h>

#include "ledger/retraining.h"

// Of an outcome, by the names of its fields.
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
double vw_quality_of(const struct vw_retrain_result *outcome, enum vw_quality quality);
bool vw_quality_higher_is_better(enum vw_quality quality); // not of L1

struct vw_quality_mean {
    double mean, standard_error; // NaN where an outcome has no such value; the standard error also below two
};
struct vw_quality_mean vw_quality_average(const struct vw_retrain_result *outcomes, uint32_t count,
                                        enum vw_quality quality);

// The mean of the differences outcomes[i] - against[i] of trainings with the same seed; as the measure has it, so that
// less L1 is better.
struct vw_paired_difference {
    double difference, standard_error; // NaN as above
    double ci_low, ci_high; // 95 % interval: Student's t with count - 1 degrees of freedom; NaN below two seeds
    bool beyond_noise;      // the interval leaves 0 out
};
struct vw_paired_difference vw_quality_compare(const struct vw_retrain_result *outcomes,
                                                const struct vw_retrain_result *against, uint32_t count,
                                                enum vw_quality quality);

#endif
