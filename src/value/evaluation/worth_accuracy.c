// The accuracy of worths and scores: how well they predict retrainings that they did not see.
#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "value/evaluation/resampling.h"
#include "value/evaluation/worth_regression.h"

// Subtracts the effect of size from each kept subset's outcome and from `predicted`. Returns their number.
static uint32_t take_off_size(const struct vw_worth_params *params, const struct vw_worths *worths,
                              const double *predicted, double *real, double *expected) {
    const struct vw_subsets *subsets = params->subsets;
    uint32_t count = 0;
    for (uint32_t i = 0; i < subsets->count; i++) {
        double outcome = 0;
        for (uint32_t seed = 0; seed < subsets->seed_count; seed++)
            outcome += vw_outcome_of(&subsets->results[(size_t)i * subsets->seed_count + seed], params->outcome) /
                       subsets->seed_count;
        if (vw_subset_size(subsets, i) == subsets->photo_count || !isfinite(worths->by_size[i])) continue;
        real[count] = outcome - worths->by_size[i];
        expected[count++] = predicted[i];
    }
    return count;
}

static enum vw_status find_accuracy(const double *real, const double *expected, uint32_t count,
                                    struct vw_worth_accuracy *accuracy) {
    double *values = vw_allocate(1 + VW_RESAMPLES, sizeof *values), error = 0, total = 0;
    uint16_t *times = vw_resamples_draw(count);
    enum vw_status status = values && times ? VW_OK : VW_ERROR_MEMORY;
    if (!status) status = vw_resampled_spearman_add(real, expected, times, count, 1, values);
    for (uint32_t i = 0; i < count; i++) {
        error += pow(expected[i] - real[i], 2);
        total += real[i] * real[i];
    }
    if (!status) {
        accuracy->spearman = values[0];
        vw_resampling_interval(values + 1, &accuracy->ci_low, &accuracy->ci_high);
        accuracy->r2 = total > 0 ? 1 - error / total : NAN;
        accuracy->variance = count ? total / count : NAN;
        accuracy->count = count;
    }
    free(values);
    free(times);
    return status;
}

// Compares outcomes with `predicted`, the part beyond the size, [subset].
static enum vw_status compare(const struct vw_worth_params *params, const struct vw_worths *worths,
                              const double *predicted, struct vw_worth_accuracy *accuracy) {
    double *real = vw_allocate(params->subsets->count, 2 * sizeof *real);
    *accuracy = (struct vw_worth_accuracy){NAN, NAN, NAN, NAN, 0, NAN};
    if (!real) return VW_ERROR_MEMORY;
    double *expected = real + params->subsets->count;
    uint32_t count = take_off_size(params, worths, predicted, real, expected);
    enum vw_status status = count >= 3 ? find_accuracy(real, expected, count, accuracy) : VW_OK;
    free(real);
    return status;
}

enum vw_status vw_worths_accuracy(const struct vw_worth_params *params, const struct vw_worths *worths,
                                  struct vw_worth_accuracy *accuracy) {
    double *predicted = vw_allocate(params->subsets->count, sizeof *predicted);
    if (!predicted) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < params->subsets->count; i++) predicted[i] = worths->predicted[i] - worths->by_size[i];
    enum vw_status status = compare(params, worths, predicted, accuracy);
    free(predicted);
    return status;
}

enum vw_status vw_worths_score_accuracy(const struct vw_worth_params *params, const struct vw_worths *worths,
                                        const double *scores, struct vw_worth_accuracy *accuracy) {
    const struct vw_subsets *subsets = params->subsets;
    double *predicted = vw_allocate(subsets->count, sizeof *predicted), mean = 0;
    if (!predicted) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < subsets->photo_count; i++) mean += scores[i] / subsets->photo_count;
    for (uint32_t i = 0; i < subsets->count; i++) {
        uint32_t size = vw_subset_size(subsets, i);
        for (uint32_t j = subsets->offsets[i]; j < subsets->offsets[i + 1]; j++)
            predicted[i] += (scores[subsets->places[j]] - mean) / (params->form == VW_WORTH_MEAN ? size : 1);
    }
    enum vw_status status = compare(params, worths, predicted, accuracy);
    accuracy->r2 = NAN; // a score has no scale of outcomes
    free(predicted);
    return status;
}
