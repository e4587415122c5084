// The scores of each provider's photos together, from score rows alone, and of near-duplicates by group.
#ifndef VIEWWORTH_VALUE_PROVIDERS_H
#define VIEWWORTH_VALUE_PROVIDERS_H

#include <stdint.h>

#include "base/duplicate.h"
#include "viewworth/ledger.h"
#include "viewworth/status.h"

struct vw_provider_score {
    const char *provider;      // borrowed from the images; "": all photos without a provider
    const char *method, *unit; // borrowed from the scores
    double value;              // sum of the photos' scores
    double standard_error;     // root of the sum of squares of the photos' standard errors; NaN if a photo has none
    uint32_t photo_count;
    uint32_t rank; // 1: the most valuable by its method
};

// Sums scores into one row per method and provider: methods in the order of the scores, the most valuable provider
// first, ties by name. Methods whose scores do not add up over photos, such as quality, are left out
// (vw_value_method.additive).
// `*groups` is owned by the caller (free).
//
// The standard error assumes that the photos' errors are independent, because that is what score rows allow. Photos of
// one run are not quite independent: one may gain what another has prepared. In four runs of 22 photos and 29 epochs,
// for random groups of 6, it was 0.81 to 1.04 times (medians) the error from the group's own sums per epoch.
enum vw_status vw_providers_score(const struct vw_ledger_score *scores, uint32_t score_count,
                                  const struct vw_ledger_image *images, uint32_t image_count,
                                  struct vw_provider_score **groups, uint32_t *group_count);

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
