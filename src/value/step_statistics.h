// Statistics of a run's recorded steps, for messages and for aborting a run.
#ifndef VIEWWORTH_VALUE_STEP_STATISTICS_H
#define VIEWWORTH_VALUE_STEP_STATISTICS_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/types.h"

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
