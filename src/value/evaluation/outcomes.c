#include "value/evaluation/outcomes.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/statistics.h"

const enum vw_quality vw_truths[VW_TRUTH_COUNT] = {VW_QUALITY_VAL_PSNR, VW_QUALITY_TEST_PSNR};
const char vw_noise_ceiling_name[] = "noise ceiling", vw_chance_name[] = "chance";

static void keep_subset(const struct vw_retrain_result *results, uint32_t subset, enum vw_quality quality,
                        uint32_t stride, struct vw_outcomes *outcomes) {
    uint32_t seeds = outcomes->seed_count;
    double mean = 0;
    for (uint32_t seed = 0; seed < seeds; seed++) {
        double value = vw_quality_of(&results[seed], quality);
        outcomes->values[(size_t)seed * stride + outcomes->count] = value;
        mean += value / seeds;
    }
    if (!isfinite(mean)) return;
    outcomes->means[outcomes->count] = mean;
    outcomes->kept[outcomes->count++] = subset;
}

enum vw_status vw_outcomes_of_subsets(const struct vw_subsets *subsets, struct vw_subset_range range,
                                      enum vw_quality quality, struct vw_outcomes *outcomes) {
    uint32_t most = range.end - range.begin, seeds = subsets->seed_count;
    *outcomes = (struct vw_outcomes){.seed_count = seeds};
    outcomes->kept = vw_allocate(most, sizeof *outcomes->kept);
    outcomes->values = vw_allocate((size_t)most * (seeds + 1), sizeof *outcomes->values);
    if (!outcomes->kept || !outcomes->values) return VW_ERROR_MEMORY;
    outcomes->means = outcomes->values + (size_t)seeds * most;
    for (uint32_t i = range.begin; i < range.end; i++)
        keep_subset(subsets->results + (size_t)i * seeds, i, quality, most, outcomes);
    for (uint32_t seed = 1; seed < seeds; seed++) // closes the gaps that subsets without a value leave
        for (uint32_t i = 0; i < outcomes->count; i++)
            outcomes->values[(size_t)seed * outcomes->count + i] = outcomes->values[(size_t)seed * most + i];
    return VW_OK;
}

void vw_outcomes_free(struct vw_outcomes *outcomes) {
    free(outcomes->kept);
    free(outcomes->values);
}

enum vw_status vw_reliability_find(const double *values, uint32_t seed_count, uint32_t count,
                                   struct vw_reliability *reliability) {
    double sum = 0;
    uint32_t pairs = 0;
    enum vw_status status = VW_OK;
    for (uint32_t a = 0; a < seed_count; a++)
        for (uint32_t b = a + 1; !status && b < seed_count; b++, pairs++) {
            double rho = NAN; // as the correlations that lie below the ceiling
            status = vw_spearman(values + (size_t)a * count, values + (size_t)b * count, count, &rho);
            sum += rho;
        }
    double agreement = pairs ? sum / pairs : NAN;
    double of_mean = seed_count * agreement / (1 + (seed_count - 1) * agreement);
    *reliability = (struct vw_reliability){agreement, agreement > 0 ? sqrt(of_mean) : NAN};
    return status;
}

enum vw_status vw_evaluate_reliability(const double *values, uint32_t seed_count, uint32_t count, const char *group,
                                       const char *name, struct vw_metrics *metrics) {
    struct vw_reliability reliability;
    char agreement_group[VW_METRIC_BYTES];
    snprintf(agreement_group, sizeof agreement_group, "agreement_%s", group);
    enum vw_status status = vw_reliability_find(values, seed_count, count, &reliability);
    struct vw_metric row = {
        .method = "outcomes", .value = reliability.agreement, .ci_low = NAN, .ci_high = NAN, .count = count};
    if (!status) status = vw_metrics_add(metrics, agreement_group, name, row);
    row.method = vw_noise_ceiling_name;
    row.value = reliability.ceiling;
    return status ? status : vw_metrics_add(metrics, group, name, row);
}
