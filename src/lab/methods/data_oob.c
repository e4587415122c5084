// Data-OOB (Kwon and Zou, ICML 2023): how well trainings on bags without a photo do on the photo itself.
#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/random.h"
#include "lab/methods/trained_sets.h"

enum { DRAW = 0x6f }; // other random numbers than other methods

static uint32_t least_budget(const struct vw_retraining_input *input) {
    (void)input;
    return 2;
}

// Draws as many photos as there are, with replacement. An epoch trains once on each photo of the set of those that were
// drawn.
static void draw_bag(const struct vw_retraining_input *input, uint32_t bag, struct vw_retrain_view *out_of_bag,
                     struct vw_trained_sets *sets) {
    bool *has = sets->has + (size_t)bag * input->photo_count;
    struct vw_retrain_params *retraining = &sets->retrainings[bag];
    for (uint32_t i = 0; i < input->photo_count; i++) {
        uint32_t words[4];
        vw_random_words(input->key, VW_RANDOM_ORDER, bag, i, DRAW, words);
        has[vw_random_below(words[0], input->photo_count)] = true;
    }
    *retraining = (struct vw_retrain_params){.seed = input->first_seed + bag, .photos = out_of_bag};
    for (uint32_t i = 0; i < input->photo_count; i++)
        if (!has[i]) out_of_bag[retraining->photo_count++].image_id = input->photos[i];
}

// Returns the mean over the bags without the photo; NaN without such a bag.
static double score_photo(const struct vw_trained_sets *sets, uint32_t image_id) {
    double sum = 0;
    uint32_t count = 0;
    for (uint32_t bag = 0; bag < sets->count; bag++)
        for (uint32_t i = 0; i < sets->retrainings[bag].photo_count; i++) {
            const struct vw_retrain_view *view = &sets->retrainings[bag].photos[i];
            if (view->image_id != image_id || !isfinite(view->psnr_db)) continue;
            sum += view->psnr_db;
            count++;
        }
    return count ? sum / count : NAN;
}

// Sets the score of a photo that all bags contain to the mean of the others, since nothing is known of it.
static void fill_unknown(uint32_t count, double *scores) {
    double sum = 0;
    uint32_t known = 0;
    for (uint32_t i = 0; i < count; i++) {
        if (isnan(scores[i])) continue;
        sum += scores[i];
        known++;
    }
    for (uint32_t i = 0; i < count; i++)
        if (isnan(scores[i])) scores[i] = sum / known;
}

static enum vw_status score(const struct vw_retraining_input *input, double *scores) {
    struct vw_retrain_view *out_of_bag = vw_allocate((size_t)input->budget * input->photo_count, sizeof *out_of_bag);
    struct vw_trained_sets sets;
    enum vw_status status = vw_trained_sets_allocate(input, input->budget, &sets);
    if (!out_of_bag) status = VW_ERROR_MEMORY;
    for (uint32_t bag = 0; !status && bag < sets.count; bag++)
        draw_bag(input, bag, out_of_bag + (size_t)bag * input->photo_count, &sets);
    if (!status) status = vw_trained_sets_train(input, &sets);
    for (uint32_t i = 0; !status && i < input->photo_count; i++) scores[i] = score_photo(&sets, input->photos[i]);
    if (!status) fill_unknown(input->photo_count, scores);
    vw_trained_sets_free(&sets);
    free(out_of_bag);
    return status;
}

const struct vw_retraining_method vw_data_oob = {
    .name = "data_oob",
    .meaning = "PSNR on the photo itself of trainings on bags without it, mean over bags",
    .estimates = VW_EXACT_COUNT,
    .least_budget = least_budget,
    .score = score,
};
