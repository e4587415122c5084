// The scores of near-duplicates, by group.
#ifndef VIEWWORTH_VALUE_DUPLICATE_SCORES_H
#define VIEWWORTH_VALUE_DUPLICATE_SCORES_H

#include <stdint.h>

#include "base/duplicate.h"
#include "viewworth/ledger.h"
#include "viewworth/status.h"

// A duplicate and its score.
struct vw_duplicate_score {
    uint32_t group;
    double similarity;
    const struct vw_ledger_image *image; // borrowed
    const struct vw_ledger_score *score; // borrowed; NULL for a photo without a score, for example a validation photo
    double group_value;                  // sum of the group's scores
    uint32_t provider_count;             // different providers in the group; photos without a provider are not counted
    uint32_t validation_count; // validation photos in the group: the train photos of the group are scored on a view
                               // that they show
};

// Writes one row per duplicate, in the same order, with the scores of one method. Groups without any score are left
// out. `*rows` is owned by the caller (free) and borrows from images and scores.
enum vw_status vw_duplicates_score(const struct vw_duplicate *duplicates, uint32_t duplicate_count, const char *method,
                                   const struct vw_ledger_score *scores, uint32_t score_count,
                                   const struct vw_ledger_image *images, uint32_t image_count,
                                   struct vw_duplicate_score **rows, uint32_t *row_count);

#endif
