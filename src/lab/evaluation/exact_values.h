// Exact values of few photos, from trainings on all of their subsets.
#ifndef VIEWWORTH_LAB_EVALUATION_EXACT_VALUES_H
#define VIEWWORTH_LAB_EVALUATION_EXACT_VALUES_H

#include "lab/evaluation/evaluation.h"
#include "value/evaluation/outcomes.h"

// Values of photo i, from its marginal contributions v(S with i) - v(S) to the subsets S of the other N - 1 photos:
enum vw_exact_value {
    VW_EXACT_SHAPLEY,       // sum with the weights |S|! (N - 1 - |S|)! / N! (Shapley 1953)
    VW_EXACT_BANZHAF,       // mean (Banzhaf 1965)
    VW_EXACT_LEAVE_ONE_OUT, // that to all other photos
    VW_EXACT_COUNT
};
const char *vw_exact_value_name(enum vw_exact_value value); // "shapley", ...

struct vw_exact_values {
    uint32_t photo_count, seed_count;
    double *values[VW_TRUTH_COUNT][VW_EXACT_COUNT]; // owned; [seed][photo], dB; NaN where a training has no value
};

// Finds the exact values. `subsets`: all of them, retrained (vw_subsets_list_all). Free the values also after a
// failure.
enum vw_status vw_exact_values_find(const struct vw_subsets *subsets, struct vw_exact_values *exact);
void vw_exact_values_free(struct vw_exact_values *exact);
// Adds rows of the groups exact_shapley, exact_banzhaf and exact_leave_one_out, for val_psnr and test_psnr
// (photo_values.h).
enum vw_status vw_evaluate_exact_values(const struct vw_evaluation *evaluation, const struct vw_exact_values *exact,
                                        struct vw_metrics *metrics);

#endif
