// What a run's recorded steps add up to, for messages and for giving up.
#ifndef VIEWWORTH_TALLY_H
#define VIEWWORTH_TALLY_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/step_record.h"

struct vw_tally {
    uint64_t steps;                             // number of the last one
    uint64_t nonfinite, floored, clamped;       // steps, steps, gradient contributions
    double first_val_psnr_db, last_val_psnr_db; // of the untrained field and of the newest one that has a value; NaN without validation
};

struct vw_tally vw_tally_begin(void);
void vw_tally_add(struct vw_tally *tally, const struct vw_step_record *record);

// Whether so many steps were not finite that going on would only waste time: more than this share, the first few being left to chance.
// A function of the steps alone, so that a run gives up at the same step however it is batched or resumed.
extern const double vw_tally_nonfinite_share;
bool vw_tally_is_hopeless(const struct vw_tally *tally);

#endif
