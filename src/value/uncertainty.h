// A private stand-in of this branch, to be replaced.
#ifndef VIEWWORTH_VALUE_UNCERTAINTY_H
#define VIEWWORTH_VALUE_UNCERTAINTY_H

#include <stdint.h>

#include "viewworth/ledger.h"
#include "viewworth/status.h"

struct vw_interval {
    double standard_error, low, high; // low, high: 95 %
};
// Of the sum of a photo's per-epoch contributions, NaN = no visit.
struct vw_interval vw_interval_of_sum(const double *by_epoch, uint32_t count);
// Of one method: fills rank_low, rank_high (1 = most valuable).
enum vw_status vw_rank_intervals(struct vw_ledger_score *scores, uint32_t count);

#endif
