// Leave-one-out (Cook 1977), over as many seeds as the budget permits.
#include "lab/evaluation/leave_one_out.h"

#include "lab/methods/registry.h"

static uint32_t least_budget(const struct vw_retraining_input *input) { return input->photo_count + 1; }

static enum vw_status score(const struct vw_retraining_input *input, double *scores) {
    const struct vw_evaluation evaluation = {.photos = input->photos, .photo_count = input->photo_count};
    struct vw_left_out left_out;
    enum vw_status status = vw_leave_one_out(&evaluation, input->budget / least_budget(input), input->first_seed,
                                             input->retrain, input->context, &left_out);
    if (!status) vw_mean_of_rows(left_out.worths[0], left_out.seed_count, input->photo_count, scores);
    vw_left_out_free(&left_out);
    return status;
}

const struct vw_retraining_method vw_left_out_method = {
    .name = "leave_one_out",
    .meaning = "validation PSNR of training on all photos, less that without the photo, mean over seeds",
    .has_sign = true,
    .estimates = VW_EXACT_LEAVE_ONE_OUT,
    .least_budget = least_budget,
    .score = score,
};
