#include "experiment/comparison_data.h"

const struct vw_retrain_result *vw_comparison_results(const struct vw_comparison *comparison, uint32_t list) {
    return comparison->results + (size_t)list * comparison->training_count;
}

const struct vw_photo_set *vw_comparison_list(const struct vw_comparison *comparison, uint32_t list,
                                              uint32_t training) {
    uint32_t valuation = training / comparison->params->common.seeds;
    return valuation ? &comparison->other_sets[valuation - 1].lists[list] : &comparison->sets.lists[list];
}

bool vw_comparison_varies(const struct vw_comparison *comparison, uint32_t list) {
    const struct vw_photo_set *first = &comparison->sets.lists[list];
    return first->random || (first->by_scores && comparison->params->valuation_seeds);
}

// Fills in the means of the trainings of every valuation, or the trainings if the lists do not depend on valuations.
// Returns how many there are.
static uint32_t take_samples(const struct vw_comparison *comparison, uint32_t list, enum vw_quality quality,
                             double samples[]) {
    const struct vw_retrain_result *results = vw_comparison_results(comparison, list);
    uint32_t seeds = comparison->params->valuation_seeds ? comparison->params->common.seeds : 1,
             count = comparison->training_count / seeds;
    for (uint32_t i = 0; i < count; i++)
        samples[i] = vw_quality_average(&results[(size_t)i * seeds], seeds, quality).mean;
    return count;
}

struct vw_quality_mean vw_comparison_mean(const struct vw_comparison *comparison, uint32_t list,
                                          enum vw_quality quality) {
    double samples[VW_COMPARISON_SAMPLES_MAX];
    return vw_samples_average(samples, take_samples(comparison, list, quality, samples));
}

struct vw_paired_difference vw_comparison_difference(const struct vw_comparison *comparison,
                                                     const struct vw_set_pair *pair, enum vw_quality quality) {
    double samples[VW_COMPARISON_SAMPLES_MAX], against[VW_COMPARISON_SAMPLES_MAX];
    uint32_t count = take_samples(comparison, pair->list, quality, samples);
    take_samples(comparison, pair->against, quality, against);
    return vw_samples_compare(samples, against, count);
}
