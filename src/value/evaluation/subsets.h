// Trainings on random halves of the photos, each with two seeds, which scores should predict.
#ifndef VIEWWORTH_VALUE_SUBSETS_H
#define VIEWWORTH_VALUE_SUBSETS_H

#include <stdint.h>

#include "ledger/retraining.h"

enum { VW_SUBSET_SEEDS = 2 };

struct vw_subsets {
    uint32_t count, size;              // subsets, and photos in each: half of all, rounded down
    uint32_t *places;                  // owned; [subset][member], ascending: which of the photos
    struct vw_retrain_result *results; // owned; [subset][seed]
};

// Draws up to `count` different halves of `photo_count` photos (at least 2); fewer where there are no more. The same
// for every seed of trainings, so that benchmarks of the same photos compare. Free them also after a failure.
enum vw_status vw_subsets_draw(uint32_t photo_count, uint32_t count, struct vw_subsets *subsets);
// Trains on every subset with seeds `first_seed` and the one after it, which no run should have whose scores are
// evaluated by it. `photos`: the image_id of each photo.
enum vw_status vw_subsets_retrain(struct vw_subsets *subsets, const uint32_t *photos, uint64_t first_seed,
                                  vw_retrain_function *retrain, void *context);
void vw_subsets_free(struct vw_subsets *subsets);

#endif
