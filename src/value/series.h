// Series of visits: the change that each step after burn-in made, by one measure and one form of the delta.
#ifndef VIEWWORTH_VALUE_SERIES_H
#define VIEWWORTH_VALUE_SERIES_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/status.h"
#include "viewworth/types.h"
#include "viewworth/value.h"

enum vw_measure { VW_MEASURE_PSNR, VW_MEASURE_L1 };

enum vw_form {
    VW_FORM_STEP,    // the measure after the step minus the last value before it
    VW_FORM_REVISIT, // the measure after the step minus the one after the photo's previous visit; over all visits these
                     // add up to the last measure minus the first
    VW_FORM_DECONVOLVED, // the step form without the mixing by momentum b: (d(t) - b d(t - 1)) / (1 - b), where t - 1
                         // is the step before, on whatever photo. This inverts d(t) = sum over k of (1 - b) b^k c(t -
                         // k), which is how Adam's first moment (Kingma and Ba, ICLR 2015) spreads the credits c
};

// A step on a photo after burn-in.
struct vw_visit {
    uint32_t image;    // index in vw_value_input.images
    uint32_t epoch;    // counts from 0 at the end of burn-in
    double delta;      // positive = better; NaN if the step has no value, or no visit before it to start from
    double train_loss; // loss of the step; NaN if it was flagged
};

struct vw_series {
    struct vw_visit *visits; // owned; in the order of the steps, so that the visits of an epoch are neighbours
    uint64_t count;
    uint32_t epoch_count; // 0 if there is no visit after burn-in
};

// Collects the deltas. VW_ERROR_INPUT for a step on a photo that is not in the images, VW_ERROR_MEMORY. Free the series
// also after a failure.
enum vw_status vw_series_make(const struct vw_value_input *input, enum vw_measure measure, enum vw_form form,
                              struct vw_series *series);
void vw_series_free(struct vw_series *series);

// Sorts the visits by photo, and within a photo by step, which is the order in which scores are summed. `starts` has
// image_count + 1 entries: the index of each photo's first visit. VW_ERROR_MEMORY.
enum vw_status vw_series_sort_by_photo(struct vw_series *series, uint32_t image_count, uint64_t *starts);

// ---- Statistics of steps --------------------------------------------------------------------------------------------

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
