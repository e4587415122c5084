// Verified selection: whether a list of photos reconstructs better than all photos, by trainings. Every list list
// is trained on at equal steps, with the same seeds, and judged on validation photos whose scores did not select it.
#ifndef VIEWWORTH_EXPERIMENT_VERIFIED_SELECTION_H
#define VIEWWORTH_EXPERIMENT_VERIFIED_SELECTION_H

#include <stdbool.h>
#include <stdint.h>

#include "base/interrupt.h"
#include "experiment/verified_lists.h"
#include "run/recorded/scored_run.h"
#include "run/session.h"
#include "value/evaluation/gains.h"

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
// and for a run without scores. Free the result also after a failure.
enum vw_status vw_verified_selection_make(const struct vw_verified_selection_params *params,
                                          struct vw_verified_selection *result);
void vw_verified_selection_free(struct vw_verified_selection *result);

#endif
