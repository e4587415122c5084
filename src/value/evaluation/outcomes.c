#include "value/evaluation/outcomes.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/statistics.h"

static const struct {
    const char *name;
    size_t offset;
    bool higher_is_better;
} named_outcomes[VW_OUTCOME_COUNT] = {
    {"val_psnr", offsetof(struct vw_retrain_result, val_psnr), true},
    {"val_ssim", offsetof(struct vw_retrain_result, val_ssim), true},
    {"val_l1", offsetof(struct vw_retrain_result, val_l1), false},
    {"test_psnr", offsetof(struct vw_retrain_result, test_psnr), true},
    {"test_ssim", offsetof(struct vw_retrain_result, test_ssim), true},
    {"test_l1", offsetof(struct vw_retrain_result, test_l1), false},
};

const char *vw_outcome_name(enum vw_outcome outcome) { return named_outcomes[outcome].name; }

bool vw_outcome_higher_is_better(enum vw_outcome outcome) { return named_outcomes[outcome].higher_is_better; }

double vw_outcome_of(const struct vw_retrain_result *result, enum vw_outcome outcome) {
    double value;
    memcpy(&value, (const char *)result + named_outcomes[outcome].offset, sizeof value);
    return value;
}

static struct vw_outcome_mean mean_of(const struct vw_spread *spread) {
    if (!spread->count) return (struct vw_outcome_mean){NAN, NAN};
    return (struct vw_outcome_mean){spread->mean, sqrt(vw_spread_variance(spread) / (double)spread->count)};
}

struct vw_outcome_mean vw_samples_average(const double *samples, uint32_t count) {
    struct vw_spread spread = {0};
    for (uint32_t i = 0; i < count; i++) vw_spread_add(&spread, samples[i]);
    return mean_of(&spread);
}

struct vw_paired_difference vw_samples_compare(const double *samples, const double *against, uint32_t count) {
    struct vw_spread spread = {0};
    for (uint32_t i = 0; i < count; i++) vw_spread_add(&spread, samples[i] - against[i]);
    struct vw_outcome_mean mean = mean_of(&spread);
    double half = count > 1 ? vw_student_quantile(count - 1) * mean.standard_error : NAN;
    struct vw_paired_difference paired = {mean.mean, mean.standard_error, mean.mean - half, mean.mean + half, false};
    paired.beyond_noise = paired.ci_low > 0 || paired.ci_high < 0; // never where they are NaN
    return paired;
}

// ---- Subsets ----

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
