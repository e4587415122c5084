// Data Banzhaf (Wang and Jia, AISTATS 2023) by maximum sample reuse: every retraining tells of every photo.
#include <math.h>

#include "base/random.h"
#include "lab/methods/trained_sets.h"

enum { DRAW = 0x62 }; // other random numbers than other methods

static uint32_t least_budget(const struct vw_retraining_input *input) {
    (void)input;
    return 2;
}

// Draws a set that contains each photo with probability 1/2.
static void draw_set(const struct vw_retraining_input *input, uint32_t set, struct vw_trained_sets *sets) {
    for (uint32_t i = 0; i < input->photo_count; i++) {
        uint32_t words[4];
        vw_random_words(input->key, VW_RANDOM_ORDER, set, i, DRAW, words);
        sets->has[(size_t)set * input->photo_count + i] = vw_random_below(words[0], 2);
    }
    sets->retrainings[set].seed = input->first_seed + set;
}

// Returns the mean with the photo less the mean without it; 0 if only one of them exists, since nothing tells of the
// photo.
static double score_photo(const struct vw_trained_sets *sets, uint32_t photo) {
    double sums[2] = {0};
    uint32_t counts[2] = {0};
    for (uint32_t set = 0; set < sets->count; set++) {
        bool with = sets->has[(size_t)set * sets->photo_count + photo];
        if (!isfinite(sets->results[set].val_psnr)) continue;
        sums[with] += sets->results[set].val_psnr;
        counts[with]++;
    }
    return counts[0] && counts[1] ? sums[1] / counts[1] - sums[0] / counts[0] : 0;
}

static enum vw_status score(const struct vw_retraining_input *input, double *scores) {
    struct vw_trained_sets sets;
    enum vw_status status = vw_trained_sets_allocate(input, input->budget, &sets);
    for (uint32_t set = 0; !status && set < sets.count; set++) draw_set(input, set, &sets);
    if (!status) status = vw_trained_sets_train(input, &sets);
    for (uint32_t i = 0; !status && i < input->photo_count; i++) scores[i] = score_photo(&sets, i);
    vw_trained_sets_free(&sets);
    return status;
}

const struct vw_retraining_method vw_data_banzhaf = {
    .name = "data_banzhaf",
    .meaning = "mean validation PSNR of trainings on random subsets with the photo, less that of those without it",
    .has_sign = true,
    .estimates = VW_EXACT_BANZHAF,
    .least_budget = least_budget,
    .score = score,
};
