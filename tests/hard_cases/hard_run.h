// Whole training runs on a scene, through the trainer's public functions; the last validation can be held against the
// reference.
#ifndef VIEWWORTH_TESTS_SUPPORT_HARD_RUN_H
#define VIEWWORTH_TESTS_SUPPORT_HARD_RUN_H

#include "hard_cases/hard_case.h"
#include "viewworth/scene.h"
#include "viewworth/train.h"
#include "viewworth/types.h"

enum { HARD_VIEWS_MAX = 4 };

struct hard_run {
    uint32_t steps, flagged_steps;
    struct vw_step_record first, last;          // step 0 and the last step; `views` NULL
    struct vw_view_error views[HARD_VIEWS_MAX]; // errors of the last step
    uint32_t view_count;
    bool still; // the params are those of before the first step
};

// Returns a small field and few rays, in the sizes that all runs of the hard cases share.
struct vw_config hard_run_config(void);
// Trains and validates. Fails the case unless every record is either finite or flagged without values, and the params
// are finite.
struct hard_run hard_train(struct hard_finding *finding, const struct vw_scene *scene, const struct vw_config *config);
// Trains and validates likewise. Fails the case also when a step is flagged, and when the errors of the last step's
// views are not those that the reference renders from the params.
struct hard_run hard_train_well(struct hard_finding *finding, const struct vw_scene *scene,
                                const struct vw_config *config);
#endif
