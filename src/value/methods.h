// The table of methods that need nothing but the steps of a ledger: what each does with the series of visits, step by
// step.
#ifndef VIEWWORTH_VALUE_METHODS_H
#define VIEWWORTH_VALUE_METHODS_H

#include <stdbool.h>
#include <stdint.h>

#include "value/series.h"
#include "viewworth/status.h"

// What is done to the deltas before they are summed, in place: their kind in relation to the others of their epoch,
// say.
typedef enum vw_status vw_treatment(struct vw_series *series);
// Fills the weights of the epochs after burn-in; a visit in an epoch of weight 0 does not count. `epoch_count` > 0.
typedef void vw_weighting(double *weights, uint32_t epoch_count);

// What becomes of the sum of a photo's weighted, treated deltas.
enum vw_aggregate {
    VW_AGGREGATE_SUM,       // it is the score
    VW_AGGREGATE_MEAN,      // it is divided by the visits
    VW_AGGREGATE_CUBE_ROOT, // its cube root, which keeps the sign
};

struct vw_method {
    const struct vw_measure *measure;
    double sign; // of the measure: +1 where more is better
    enum vw_form form;
    vw_treatment *treatment;
    vw_weighting *weighting;
    enum vw_aggregate outcome;
};

// The methods behind the first entries of vw_value_methods(), in the same order.
extern const struct vw_method vw_methods[];
extern const uint32_t vw_method_count;

// Whether the score is a weighted sum of step deltas, so that what sampling does to these says what it does to the
// score.
bool vw_method_is_sum_of_steps(const struct vw_method *method);

#endif
