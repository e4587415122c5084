// All subsets of a few photos, and trainings on subsets.
#ifndef VIEWWORTH_LAB_EVALUATION_SUBSET_TRAININGS_H
#define VIEWWORTH_LAB_EVALUATION_SUBSET_TRAININGS_H

#include "value/evaluation/outcomes.h"

enum { VW_SUBSETS_ALL_PHOTOS_MAX = 10 }; // photos of which all subsets can be listed

// Lists all 2^photo_count subsets, the empty one included, of at most VW_SUBSETS_ALL_PHOTOS_MAX photos.
enum vw_status vw_subsets_list_all(uint32_t photo_count, uint32_t seed_count, struct vw_subsets *subsets);
// Trains on every subset with seed_count seeds from `first_seed` on, which no run should have whose scores are
// evaluated by it. `photos`: the image_id of each photo.
enum vw_status vw_subsets_retrain(struct vw_subsets *subsets, const uint32_t *photos, uint64_t first_seed,
                                  vw_retrain_function *retrain, void *context);

#endif
