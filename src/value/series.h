// From step records to series of visits: what each step after burn-in changed, seen through one measure and in one form
// of the delta.
#ifndef VIEWWORTH_VALUE_SERIES_H
#define VIEWWORTH_VALUE_SERIES_H

#include <stdbool.h>
#include <stdint.h>

#include "value/measure.h"
#include "viewworth/status.h"
#include "viewworth/value.h"

// What a delta is the change from, and of what.
enum vw_form {
    VW_FORM_STEP,    // the measure after the step minus the one before it: the last value there is
    VW_FORM_REVISIT, // minus the one after this photo's visit before; of all its visits they add up to the last minus
                     // the first
    VW_FORM_DECONVOLVED, // the step form d freed from what momentum b mixed into it: (d(t) - b d(t - 1)) / (1 - b), see
                         // value.h
};

// A step on a photo after burn-in.
struct vw_visit {
    uint32_t image;           // index in vw_value_input.images
    uint32_t epoch;           // counts from 0 at the end of burn-in
    double delta;             // positive = helps; NaN where the step has no value, or no visit before it to start from
    double sampling_variance; // vw_step_sampling_variance
};

struct vw_series {
    struct vw_visit *visits; // in the order of the steps, so that those of an epoch are neighbours; owned
    uint64_t count;
    uint32_t epoch_count; // 0 when there is no visit after burn-in
};

// `sign` is +1 where more of the measure is better, -1 where less is. VW_ERROR_INPUT for a step on a photo that the
// images lack, VW_ERROR_MEMORY. Free it also after a failure.
enum vw_status vw_series_make(const struct vw_value_input *input, const struct vw_measure *measure, double sign,
                              enum vw_form form, struct vw_series *series);
void vw_series_free(struct vw_series *series);

// Reorders the visits photo by photo, each photo's in the order of the steps, as scores are summed. `starts` has
// image_count + 1 entries and becomes where each photo's visits begin. VW_ERROR_MEMORY.
enum vw_status vw_series_sort_by_photo(struct vw_series *series, uint32_t image_count, uint64_t *starts);

#endif
