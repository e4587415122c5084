// Trainings on random subsets of the photos, which scores should predict.
#ifndef VIEWWORTH_VALUE_EVALUATION_SUBSETS_H
#define VIEWWORTH_VALUE_EVALUATION_SUBSETS_H

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

#endif
