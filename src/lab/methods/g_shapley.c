// G-Shapley (Ghorbani and Zou, ICML 2019): one epoch from a new initialisation, in an order of its own, and what each
// step adds to validation PSNR; means over many such epochs. It is dv_psnr of runs of one epoch.
#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "lab/methods/registry.h"

static uint32_t one_epoch(uint32_t whole) {
    (void)whole;
    return 1;
}

static uint32_t least_budget(const struct vw_retraining_input *input) {
    (void)input;
    return 1;
}

static void list_epochs(const struct vw_retraining_input *input, uint32_t count, struct vw_retrain_view *gains,
                        struct vw_retrain_params *epochs) {
    for (size_t i = 0; i < (size_t)count * input->photo_count; i++)
        gains[i].image_id = input->photos[i % input->photo_count];
    for (uint32_t i = 0; i < count; i++)
        epochs[i] = (struct vw_retrain_params){.views = input->photos,
                                               .view_count = input->photo_count,
                                               .seed = input->first_seed + i,
                                               .epochs = one_epoch(input->epochs),
                                               .photos = gains + (size_t)i * input->photo_count,
                                               .photo_count = input->photo_count,
                                               .photos_of = VW_RETRAIN_PHOTOS_GAINS};
}

static double mean_gain(const struct vw_retrain_view *gains, uint32_t photo, uint32_t photo_count, uint32_t count) {
    double sum = 0;
    uint32_t known = 0;
    for (uint32_t i = 0; i < count; i++) {
        double gain = gains[(size_t)i * photo_count + photo].psnr_db;
        if (!isfinite(gain)) continue;
        sum += gain;
        known++;
    }
    return known ? sum / known : NAN;
}

static enum vw_status score(const struct vw_retraining_input *input, double *scores) {
    uint32_t count = input->budget * input->epochs, photos = input->photo_count;
    struct vw_retrain_view *gains = vw_allocate((size_t)count * photos, sizeof *gains);
    struct vw_retrain_params *epochs = vw_allocate(count, sizeof *epochs);
    struct vw_retrain_result *results = vw_allocate(count, sizeof *results);
    enum vw_status status = gains && epochs && results ? VW_OK : VW_ERROR_MEMORY;
    if (!status) list_epochs(input, count, gains, epochs);
    if (!status) status = input->retrain(input->context, epochs, count, results);
    for (uint32_t i = 0; !status && i < photos; i++) scores[i] = mean_gain(gains, i, photos, count);
    free(gains);
    free(epochs);
    free(results);
    return status;
}

const struct vw_retraining_method vw_g_shapley = {
    .name = "g_shapley",
    .meaning = "what a step on the photo adds to validation PSNR in the first epoch, mean over initialisations",
    .has_sign = true,
    .estimates = VW_EXACT_COUNT,
    .least_budget = least_budget,
    .epochs = one_epoch,
    .score = score,
};
