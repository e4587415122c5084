#include <math.h>
#include <stdio.h>

#include "base/statistics.h"
#include "lab/evaluation/evaluation.h"

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
