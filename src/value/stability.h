// The test whether scores have settled (`value --until-stable R`): a pure function of the recorded steps.
//
// n is the number of epochs that count: those from burn-in on in which the step of every train photo is recorded. The
// scores after n epochs are compared with the scores after the first n / 2 (rounded down), by Spearman's rank
// correlation over the train photos. The smallest of the correlations after n, n - 1 and n - 2 epochs counts, so that
// chance alone does not end a run. Photos that differ only by noise reach about 0.7 at any n, since half of the sum is
// shared; a fixed lag of some epochs would reach 1 as n grows. This says nothing about other seeds: the part
// of a score that all epochs of a run share is in both sides.
#ifndef VIEWWORTH_VALUE_STABILITY_H
#define VIEWWORTH_VALUE_STABILITY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "viewworth/types.h"
#include "viewworth/value.h"

enum {
    VW_STABILITY_EPOCHS_MIN = 10, // epochs that count: half of fewer says too little
    VW_STABILITY_ENDS = 3,        // number of last epochs over which the smallest correlation is taken
};

struct vw_stability {
    uint32_t epochs;         // n: epochs that count
    uint32_t earlier_epochs; // epochs before the scores that those after n are compared with
    double correlation; // the smallest; NaN below VW_STABILITY_EPOCHS_MIN, and where the scores of either do not differ
};

// The scores of vw_value_default_method (a plain sum of step deltas of val_psnr) after every epoch, kept while the
// records pass by: one double per photo and epoch that counts.
struct vw_stability_watch {
    uint32_t *photos; // owned; image_ids of the train photos, ascending
    uint32_t photo_count, burn_in_epochs;
    double *sums; // owned; [epoch that counts * photo_count + photo]: the score after that epoch; NaN without a visit
    size_t epoch_count, capacity;
    double last_psnr; // the last finite val_psnr; NaN: none yet
    uint64_t last_step;
};

// Begins a watch. `watch` is zero before; `photos` (ascending) are copied. VW_ERROR_MEMORY. End it also after a
// failure.
enum vw_status vw_stability_watch_begin(const uint32_t *photos, uint32_t photo_count, uint32_t burn_in_epochs,
                                        struct vw_stability_watch *watch);
// Takes the next record; all of a run in order, from step 0 on. VW_ERROR_INPUT for a step on another photo.
enum vw_status vw_stability_watch_add(struct vw_stability_watch *watch, const struct vw_step_record *record);
// Measures the steps so far; those of an incomplete epoch are left out. VW_ERROR_MEMORY.
enum vw_status vw_stability_watch_measure(const struct vw_stability_watch *watch, struct vw_stability *stability);
void vw_stability_watch_end(struct vw_stability_watch *watch);
// Returns whether the correlation reaches `wanted`.
bool vw_stability_reaches(const struct vw_stability *stability, double wanted);

// Statistics of a run's recorded steps, for messages and for aborting a run.
struct vw_step_statistics {
    uint64_t steps;                       // number of the last one
    uint64_t finite;                      // steps from the first one on
    uint64_t nonfinite, floored, clamped; // steps, steps, gradient contributions
    double first_val_psnr_db,
        last_val_psnr_db; // values of the untrained field and of the newest step that has one; NaN without validation
};

struct vw_step_statistics vw_step_statistics_begin(void);
void vw_step_statistics_add(struct vw_step_statistics *statistics, const struct vw_step_record *record);

// The share of non-finite steps, apart from the first few, above which a run is aborted. It depends only on the steps,
// so that a run aborts at the same step however it is submitted or resumed.
extern const double vw_step_statistics_nonfinite_max;
bool vw_step_statistics_should_abort(const struct vw_step_statistics *statistics);
// Returns whether there are steps, and none is finite: then there is no result, however short the run is.
bool vw_step_statistics_are_void(const struct vw_step_statistics *statistics);

#endif
