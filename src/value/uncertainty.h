// How far a run's scores may be from those of other seeds.
#ifndef VIEWWORTH_VALUE_UNCERTAINTY_H
#define VIEWWORTH_VALUE_UNCERTAINTY_H

#include <stdint.h>

#include "viewworth/ledger.h"
#include "viewworth/status.h"

// Of a sum. All NaN where it is unknown: below two visits.
struct vw_interval {
    double standard_error, low, high; // low, high: 95 %
};

// The intervals of all photos' scores of one method, each a sum of what the photo's visits contribute: by_epoch[photo * epochs + epoch] in
// the order of the epochs, NaN where there was no visit.
enum vw_status vw_intervals_of_sums(const double *by_epoch, uint32_t photos, uint32_t epochs, struct vw_interval *intervals);

// Fills rank_low and rank_high of the scores of one method.
enum vw_status vw_rank_intervals(struct vw_ledger_score *scores, uint32_t count);

#endif
