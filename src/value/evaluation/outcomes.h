// Outcomes of retrainings: means over seeds, differences between trainings with the same seed, so that the seed's noise
// cancels where both share it, and the outcomes of many subsets of photos.
#ifndef VIEWWORTH_VALUE_EVALUATION_OUTCOMES_H
#define VIEWWORTH_VALUE_EVALUATION_OUTCOMES_H

#include <stdbool.h>
#include <stdint.h>

#include "ledger/retraining.h"
#include "value/evaluation/subsets.h"

// The outcomes that a result has, named as its fields.
enum vw_outcome {
    VW_OUTCOME_VAL_PSNR,
    VW_OUTCOME_VAL_SSIM,
    VW_OUTCOME_VAL_L1,
    VW_OUTCOME_TEST_PSNR,
    VW_OUTCOME_TEST_SSIM,
    VW_OUTCOME_TEST_L1,
    VW_OUTCOME_COUNT,
};
const char *vw_outcome_name(enum vw_outcome outcome); // "val_psnr", ...
double vw_outcome_of(const struct vw_retrain_result *result, enum vw_outcome outcome);
bool vw_outcome_higher_is_better(enum vw_outcome outcome); // not of L1

struct vw_outcome_mean {
    double mean, standard_error; // NaN where a result lacks the value; the standard error also for fewer than two
};
struct vw_outcome_mean vw_samples_average(const double *samples, uint32_t count);

// The mean of the differences samples[i] - against[i] of trainings with the same seed. A negative difference of L1 is
// better.
struct vw_paired_difference {
    double difference, standard_error; // NaN as above
    double ci_low, ci_high; // 95 % interval: Student's t with count - 1 degrees of freedom; NaN below two seeds
    bool beyond_noise;      // the interval does not contain 0
};
struct vw_paired_difference vw_samples_compare(const double *samples, const double *against, uint32_t count);

// One outcome of trainings on several subsets, with several seeds each. Trainings without a value are left out.
struct vw_outcomes {
    uint32_t count, seed_count;
    uint32_t *kept; // owned; [count]: which subsets
    double *values; // owned; [seed][count]
    double *means;  // [count]: over the seeds; part of `values`
};

// Keeps the subsets of a range whose trainings all have a value. Free them also after a failure.
enum vw_status vw_outcomes_of_subsets(const struct vw_subsets *subsets, struct vw_subset_range range,
                                      enum vw_outcome outcome, struct vw_outcomes *outcomes);
void vw_outcomes_free(struct vw_outcomes *outcomes);

#endif
