// Agreement of scores with values of the photos from retrainings: worths by leave-one-out, exact Shapley values.
#ifndef VIEWWORTH_LAB_EVALUATION_PHOTO_VALUES_H
#define VIEWWORTH_LAB_EVALUATION_PHOTO_VALUES_H

#include "lab/evaluation/evaluation.h"
#include "value/evaluation/outcomes.h"

struct vw_photo_values {
    const char *group, *name; // names of the rows: <group>/<name>
    const double *values;     // [seed][photo]
    uint32_t seed_count;      // number of retraining seeds
};

// Rows, each with the middle 95 % over resampled photos; none where a value is not finite.
// - <group>/<name>: Spearman's correlation over the photos between scores and the mean values of all retraining seeds;
//   the mean over the valued seeds.
// - <group>_mean/<name>: that of the mean scores of the valued seeds.
// - <group>_pearson/<name>: Pearson's correlation instead, without interval.
// - <group>/<name> of "noise ceiling" and "chance", agreement_<group>/<name> (outcomes.h).
enum vw_status vw_evaluate_photo_values(const struct vw_evaluation *evaluation, const struct vw_photo_values *values,
                                        struct vw_metrics *metrics);

#endif
