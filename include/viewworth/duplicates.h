// Photos of a scene that show all but the same, and what they are worth together: a copy shares the credit of its original.
#ifndef VIEWWORTH_DUPLICATES_H
#define VIEWWORTH_DUPLICATES_H

#include <stdint.h>

#include "viewworth/ledger.h"
#include "viewworth/status.h"

struct vw_scene;

struct vw_duplicate {
    uint32_t group;    // 0, 1, ...
    uint32_t view;     // index in vw_scene.views
    double similarity; // to the first of its group, -1 to 1: see vw_scene_find_duplicates; 1 for files of equal bytes and for the first
};

// Finds groups of near-duplicates among the photos that train or validate: each photo of a group is a near-duplicate of the group's first,
// so that groups do not grow along a film. Two photos are near-duplicates when their files have equal bytes, or when
// - their cameras stand within 2 degrees of each other, as seen from what lies nearest before them, and point the same way within 2
//   degrees, roll included, and
// - the luminances of their 16 x 16 cells correlate to at least 0.98, whatever the exposure: gain and offset drop out.
// Views a few degrees apart have much in common and are each worth their own; a copy that was resized, compressed or brightened has not
// moved. `*duplicates`, group by group and then by view, is owned by the caller (free).
enum vw_status vw_scene_find_duplicates(const struct vw_scene *scene, struct vw_duplicate **duplicates, uint32_t *count);

// A duplicate beside its score.
struct vw_duplicate_score {
    uint32_t group;
    double similarity;
    const struct vw_ledger_image *image; // borrowed
    const struct vw_ledger_score *score; // borrowed; NULL for a photo that is not valued, such as one that validates
    double group_value;                  // sum of the group's scores
    uint32_t provider_count;             // different ones in the group; photos without one are not counted
    uint32_t validation_count;           // photos of the group that validate: those that train are scored on what they have seen
};

// One per duplicate, in the same order, with the scores of one method. Of groups none of whose photos has a score none is left. `*rows` is
// owned by the caller (free) and borrows from images and scores.
enum vw_status vw_duplicates_score(const struct vw_duplicate *duplicates, uint32_t duplicate_count, const char *method,
                                   const struct vw_ledger_score *scores, uint32_t score_count, const struct vw_ledger_image *images,
                                   uint32_t image_count, struct vw_duplicate_score **rows, uint32_t *row_count);

#endif
