// Shared by scores and the noise floor: the validation measures, their spread, and the probes of a step.
#ifndef VIEWWORTH_VALUE_MEASURE_H
#define VIEWWORTH_VALUE_MEASURE_H

#include <stddef.h>
#include <stdint.h>

#include "viewworth/value.h"

// The offsets of a validation measure in a step record and in a probe.
struct vw_measure {
    size_t in_record, in_probe;
};
extern const struct vw_measure vw_measure_psnr, vw_measure_l1;

double vw_measure_of_record(const struct vw_measure *measure, const struct vw_step_record *record);
double vw_measure_of_probe(const struct vw_measure *measure, const struct vw_probe *probe);

// The spread of values. Mean and squares by Welford's recurrence, which avoids cancellation.
struct vw_spread {
    uint64_t count;
    double mean, squared_deviations;
};
void vw_spread_add(struct vw_spread *spread, double value);
double vw_spread_variance(const struct vw_spread *spread); // sample variance (n - 1); NaN below two values

// The probes of one step.
struct vw_step_probes {
    const struct vw_probe *probes;
    uint64_t count;
};
// Returns the probes of `step`. Call it for ascending steps; `*taken` counts the probes used so far and begins with 0.
struct vw_step_probes vw_step_probes_take(const struct vw_value_input *input, uint64_t step, uint64_t *taken);

// Returns the variance of a step's delta that pixel sampling alone causes: the variance of the measure over the
// resampled steps and the step itself, which all start from the same state. NaN below two values.
double vw_step_sampling_variance(const struct vw_measure *measure, const struct vw_step_record *record,
                                 struct vw_step_probes probes);

// The mean of the variances of several steps, without those that are NaN.
struct vw_mean_variance {
    double sum;
    uint64_t count;
};
void vw_mean_variance_add(struct vw_mean_variance *mean, double variance);
double vw_mean_variance_result(const struct vw_mean_variance *mean); // NaN: no variance was added

#endif
