// What a run's recorded steps add up to, for messages and for giving up.
#ifndef VIEWWORTH_STEP_STATISTICS_H
#define VIEWWORTH_STEP_STATISTICS_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/types.h"

struct vw_step_statistics {
    uint64_t steps;                       // number of the last one
    uint64_t nonfinite, floored, clamped; // steps, steps, gradient contributions
    double first_val_psnr_db,
        last_val_psnr_db; // of the untrained field and of the newest one that has a value; NaN without validation
};

struct vw_step_statistics vw_step_statistics_begin(void);
void vw_step_statistics_add(struct vw_step_statistics *statistics, const struct vw_step_record *record);

// Whether so many steps were not finite that going on would only waste time: more than this share, the first few being
// left to chance. A function of the steps alone, so that a run gives up at the same step however it is batched or
// resumed.
extern const double vw_step_statistics_nonfinite_max;
bool vw_step_statistics_should_abort(const struct vw_step_statistics *statistics);

#endif
