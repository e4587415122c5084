// Outcomes of retrainings: means over seeds, differences between trainings with the same seed, so that the seed's noise
// cancels where both share it, and the outcomes of many subsets of photos.
#ifndef VIEWWORTH_VALUE_EVALUATION_OUTCOMES_H
#define VIEWWORTH_VALUE_EVALUATION_OUTCOMES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ledger/retraining.h"

enum {
    VW_SUBSETS_LOWEST_PERCENT = 40, // smallest share of the photos in a subset of random size
};

// Subsets begin ... end - 1.
struct vw_subset_range {
    uint32_t begin, end;
};

struct vw_subsets {
    uint32_t count, photo_count, seed_count;
    struct vw_subset_range halves; // half the photos, rounded down
    struct vw_subset_range sizes; // random sizes; among all subsets those of 40 to 100 % of the photos, halves included
    uint32_t *offsets;            // owned; [count + 1]: subset i has places[offsets[i]] ... places[offsets[i + 1] - 1]
    uint32_t *places;             // owned; members of subset after subset, ascending: which of the photos
    struct vw_retrain_result *results; // owned; [subset][seed]
};

static inline uint32_t vw_subset_size(const struct vw_subsets *subsets, uint32_t subset) {
    return subsets->offsets[subset + 1] - subsets->offsets[subset];
}

struct vw_subsets_params {
    uint32_t photo_count;          // at least 2
    uint32_t halves, random_sizes; // how many to draw of each
    uint32_t seed_count;           // trainings of each subset
    uint64_t key;                  // other keys draw others; 0: the subsets that judge scores in benchmarks
};
// Draws different subsets: halves, then subsets whose size is uniform on 40 to 100 % of the photos; fewer where there
// are no more. The same for every seed of trainings, so that benchmarks of the same photos compare. Free them also
// after a failure.
enum vw_status vw_subsets_draw(const struct vw_subsets_params *params, struct vw_subsets *subsets);
// Begins a list with room for `most` subsets of together `members` members; the functions below do it themselves.
enum vw_status vw_subsets_allocate(uint32_t photo_count, uint32_t most, uint32_t seed_count, size_t members,
                                   struct vw_subsets *subsets);
// Appends a subset. `places` ascend.
void vw_subsets_add(struct vw_subsets *subsets, const uint32_t *places, uint32_t size);
// Returns the smallest number of photos of a subset of random size.
uint32_t vw_subsets_smallest(uint32_t photo_count);
void vw_subsets_free(struct vw_subsets *subsets);

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
