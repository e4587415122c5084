// Leave-one-out: trainings without each photo in turn, as a truth that scores should agree with.
#ifndef VIEWWORTH_LAB_EVALUATION_LEAVE_ONE_OUT_H
#define VIEWWORTH_LAB_EVALUATION_LEAVE_ONE_OUT_H

#include "lab/evaluation/evaluation.h"
#include "value/evaluation/outcomes.h"

struct vw_left_out {
    uint32_t seed_count, photo_count;
    double *worths[VW_TRUTH_COUNT]; // owned; [seed][photo], dB: training on all photos less that without the photo,
                                    // with the same seed; NaN where one of both has no value
};

// Trains on all photos and without each photo in turn, with seed_count seeds from `first_seed` on. Free the result also
// after a failure.
enum vw_status vw_leave_one_out(const struct vw_evaluation *evaluation, uint32_t seed_count, uint64_t first_seed,
                                vw_retrain_function *retrain, void *context, struct vw_left_out *left_out);
void vw_left_out_free(struct vw_left_out *left_out);

// Adds rows of the group leave_one_out, for val_psnr and test_psnr (photo_values.h).
enum vw_status vw_evaluate_leave_one_out(const struct vw_evaluation *evaluation, const struct vw_left_out *left_out,
                                         struct vw_metrics *metrics);

#endif
