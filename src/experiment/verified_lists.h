// The lists of photos that a verified selection tries: rules, each applied to the scores of either half of the
// validation photos and to those of all of them, and lists of the same sizes without scores.
#ifndef VIEWWORTH_EXPERIMENT_VERIFIED_LISTS_H
#define VIEWWORTH_EXPERIMENT_VERIFIED_LISTS_H

#include <stdint.h>

#include "value/halves.h"
#include "viewworth/selection.h"
#include "viewworth/status.h"

enum { VW_VERIFIED_LISTS_MAX = 20, VW_HALF_BOTH = VW_HALVES, VW_SCORINGS };

// The scores by half A, by half B, and by all validation photos (VW_HALF_BOTH).
struct vw_scorings {
    const struct vw_ledger_image *images;
    uint32_t image_count;
    uint64_t seed;                               // draws the random lists
    struct vw_ledger_score *scores[VW_SCORINGS]; // owned by the caller
    uint32_t score_counts[VW_SCORINGS];
};

struct vw_verified_list {
    const char *name;   // static: "all", "without-outliers", "top:75%:dv_psnr", ...
    const char *method; // likewise; whose scores select: "dv_psnr"; "none" of all photos
    char *same_as;      // owned: names of the rules with the same lists, with commas between; NULL: none
    struct vw_selection selections[VW_SCORINGS]; // owned; by the scores of each half and of both
};

struct vw_verified_lists {
    struct vw_verified_list of[VW_VERIFIED_LISTS_MAX]; // the first one is all photos
    uint32_t count;
};

// Makes the lists. No rule leaves out a lone view (viewworth/selection.h). Rules by a score that one of the scorings
// lacks are left out. Rules whose lists are all equal become one; a rule that keeps fewer than
// two photos by any of the scorings is left out, with a line of the log. Free them also after a failure. VW_ERROR_INPUT
// where there are no scores.
enum vw_status vw_verified_lists_make(const struct vw_scorings *scorings, struct vw_verified_lists *lists);
void vw_verified_lists_free(struct vw_verified_lists *lists);

#endif
