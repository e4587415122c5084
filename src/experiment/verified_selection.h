// Verified selection: whether a list of photos reconstructs better than all photos, by trainings. Every list
// is trained on at equal steps, with the same seeds, and judged on validation photos whose scores did not select it.
#ifndef VIEWWORTH_EXPERIMENT_VERIFIED_SELECTION_H
#define VIEWWORTH_EXPERIMENT_VERIFIED_SELECTION_H

#include <stdbool.h>
#include <stdint.h>

#include "base/interrupt.h"
#include "run/recorded/scored_run.h"
#include "run/session.h"
#include "value/evaluation/gains.h"
#include "value/halves.h"
#include "viewworth/selection.h"
#include "viewworth/status.h"

// ---- Lists ----------------------------------------------------------------------------------------------------------

// The lists of photos that a verified selection tries: rules, each applied to the scores of either half of the
// validation photos and to those of all of them, and lists of the same sizes without scores.

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

// ---- The selection --------------------------------------------------------------------------------------------------

enum { VW_VERIFIED_SELECTION_SEEDS = 2 }; // fewer than elsewhere, because many lists are trained on

// Scene and config are those of the run.
struct vw_verified_selection_params {
    struct vw_scored_run *run;       // open; its scene is opened
    struct vw_device_choice devices; // the first NULL: the run's
    uint32_t seeds;                  // trainings of every list, at least 2, with other seeds than the run's
    uint32_t together;               // trainings that take their steps together on each device; 0: by it
    struct vw_interrupt interrupt;
};

struct vw_verified_selection {
    struct vw_verified_lists lists;              // owned
    struct vw_gain gains[VW_VERIFIED_LISTS_MAX]; // over all photos, by list
    uint32_t chosen;                             // 0: all photos
    uint32_t half_sizes[VW_HALVES];              // validation photos of each half
    uint64_t first_seed;                         // seed of the first training
};

// Splits the validation photos into two halves, by the run's seed and their names. A rule, applied to the scores of one
// half, gives a list that is judged on the photos of the other half, and the other way round; so each validation photo
// judges once. The list to keep is the chosen rule's, by the scores of all validation photos. Trainings are kept in
// OUT/retrainings.db, so that the same call resumes. No training is made when all rules keep all photos.
// VW_ERROR_USAGE for an imported run, VW_ERROR_INPUT for fewer than 2 validation photos, for a scene that has changed,
// and for a run without scores. Free its lists also after a failure.
enum vw_status vw_verified_selection_make(const struct vw_verified_selection_params *params,
                                          struct vw_verified_selection *result);

#endif
