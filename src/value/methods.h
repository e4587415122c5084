// The table of methods that need only the steps of a ledger: how each turns the series of visits into a score.
#ifndef VIEWWORTH_VALUE_METHODS_H
#define VIEWWORTH_VALUE_METHODS_H

#include <stdbool.h>
#include <stdint.h>

#include "value/series.h"
#include "viewworth/status.h"

// Changes the deltas in place before they are summed, for example by clipping them.
typedef enum vw_status vw_treatment(struct vw_series *series);
// Fills the weights of the epochs after burn-in; a visit in an epoch of weight 0 does not count. `epoch_count` > 0.
typedef void vw_weighting(double *weights, uint32_t epoch_count);

// How a score results from the sum of a photo's weighted deltas.
enum vw_aggregate {
    VW_AGGREGATE_SUM,       // the score is the sum
    VW_AGGREGATE_MEAN,      // the sum divided by the number of visits
    VW_AGGREGATE_CUBE_ROOT, // the cube root of the sum, with its sign
};

struct vw_method {
    const struct vw_measure *measure;
    double sign; // of the measure: +1 where more is better
    enum vw_form form;
    vw_treatment *treatment;
    vw_weighting *weighting;
    enum vw_aggregate aggregate;
};

// The methods of the first entries of vw_value_methods(), in the same order.
extern const struct vw_method vw_methods[];
extern const uint32_t vw_method_count;

// Whether the score is a weighted sum of step deltas: then the sampling variance of the deltas gives that of the score.
bool vw_method_is_sum_of_steps(const struct vw_method *method);

#endif
