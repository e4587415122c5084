// The validation measures that scores are computed from, and the spread of values.
#ifndef VIEWWORTH_VALUE_MEASURE_H
#define VIEWWORTH_VALUE_MEASURE_H

#include <stddef.h>
#include <stdint.h>

#include "viewworth/types.h"

// The offset of a validation measure in a step record.
struct vw_measure {
    size_t in_record;
};
extern const struct vw_measure vw_measure_psnr, vw_measure_l1;

double vw_measure_of_record(const struct vw_measure *measure, const struct vw_step_record *record);

// The spread of values. Mean and squares by Welford's recurrence, which avoids cancellation.
struct vw_spread {
    uint64_t count;
    double mean, squared_deviations;
};
void vw_spread_add(struct vw_spread *spread, double value);
double vw_spread_variance(const struct vw_spread *spread); // sample variance (n - 1); NaN below two values

#endif
