// Statistics of a run's recorded steps, for messages and for aborting a run.
#ifndef VIEWWORTH_VALUE_STEP_STATISTICS_H
#define VIEWWORTH_VALUE_STEP_STATISTICS_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/types.h"

struct vw_step_statistics {
    uint64_t steps;                       // number of the last one
    uint64_t nonfinite, floored, clamped; // steps, steps, gradient contributions
    double first_val_psnr_db,
        last_val_psnr_db; // of the untrained field and of the newest step with a value; NaN without validation
};

struct vw_step_statistics vw_step_statistics_begin(void);
void vw_step_statistics_add(struct vw_step_statistics *statistics, const struct vw_step_record *record);

// Whether the run should be aborted because too many steps are non-finite: more than this share, apart from the first
// few. It depends on the steps alone, so that a run aborts at the same step however it is batched or resumed.
extern const double vw_step_statistics_nonfinite_max;
bool vw_step_statistics_should_abort(const struct vw_step_statistics *statistics);

#endif
