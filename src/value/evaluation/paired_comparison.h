// What sets of photos lead to, held against one another: means over seeds, and differences of trainings with the same
// seed, which share whatever luck the seed brings.
#ifndef VIEWWORTH_VALUE_COMPARISON_H
#define VIEWWORTH_VALUE_COMPARISON_H

#include <stdbool.h>
#include <stdint.h>

#include "ledger/retraining.h"

// Of an outcome, by the names of its fields.
enum vw_outcome_measure {
    VW_AGGREGATE_VAL_PSNR,
    VW_AGGREGATE_VAL_SSIM,
    VW_AGGREGATE_VAL_L1,
    VW_AGGREGATE_TEST_PSNR,
    VW_AGGREGATE_TEST_SSIM,
    VW_AGGREGATE_TEST_L1,
    VW_AGGREGATE_MEASURES,
};
const char *vw_outcome_measure_name(enum vw_outcome_measure measure); // "val_psnr", ...
double vw_outcome_of(const struct vw_retrain_result *outcome, enum vw_outcome_measure measure);
bool vw_outcome_more_is_better(enum vw_outcome_measure measure); // not of L1

struct vw_outcome_mean {
    double mean, standard_error; // NaN where an outcome has no such value; the standard error also below two
};
struct vw_outcome_mean vw_outcomes_mean(const struct vw_retrain_result *outcomes, uint32_t count,
                                        enum vw_outcome_measure measure);

// The mean of the differences outcomes[i] - against[i] of trainings with the same seed; as the measure has it, so that
// less L1 is better.
struct vw_paired_difference {
    double difference, standard_error; // NaN as above
    double ci_low, ci_high; // 95 % interval: Student's t with count - 1 degrees of freedom; NaN below two seeds
    bool beyond_noise;      // the interval leaves 0 out
};
struct vw_paired_difference vw_outcomes_compare(const struct vw_retrain_result *outcomes,
                                                const struct vw_retrain_result *against, uint32_t count,
                                                enum vw_outcome_measure measure);

#endif
