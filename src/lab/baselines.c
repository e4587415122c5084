#include "lab/baselines.h"

#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "base/random.h"

static const uint64_t RANDOM_BASELINE_SEED = 0x636f6e74726f6c; // plus the run's: other numbers for every valued seed

static void score_randomly(const struct vw_baseline_input *input, double *scores) {
    for (uint32_t i = 0; i < input->features->photo_count; i++) {
        uint32_t words[4];
        vw_random_words(RANDOM_BASELINE_SEED + input->seed, VW_RANDOM_ORDER, 0, input->photos[i], 0, words);
        scores[i] = vw_random_unit(words[0]);
    }
}

static void score_ground_truth(const struct vw_baseline_input *input, double *scores) {
    for (uint32_t i = 0; i < input->features->photo_count; i++) {
        const char *ground_truth = input->scene->views[input->photos[i]].ground_truth;
        scores[i] = !ground_truth || !strcmp(ground_truth, "clean");
    }
}

void vw_baseline_score(const struct vw_baseline *baseline, const struct vw_baseline_input *input, double *scores) {
    if (baseline->score) baseline->score(input, scores);
    for (uint32_t i = 0; !baseline->score && i < input->features->photo_count; i++) {
        double value = vw_photo_feature(input->features, input->valued, i, baseline->feature);
        scores[i] = isnan(value) && vw_features[baseline->feature].of_run ? 0 : baseline->sign * value;
    }
}

const struct vw_baseline vw_baselines[] = {
    {"ground_truth", "whether the photo is clean", score_ground_truth, 0, 0, 0},
    {"random", "a random number", score_randomly, 0, 0, 0},
    {"train_loss", "the photo's training loss at its last step, negated", NULL, VW_FEATURE_LOSS_LAST, -1, 1},
    {"loss_change", "mean absolute change of its training loss from step to step, a stand-in for its gradient norm",
     NULL, VW_FEATURE_LOSS_CHANGE, 1, 1},
    {"sharpness", "variance of the Laplacian of its luminance", NULL, VW_FEATURE_SHARPNESS, 1, 0},
    {"exposure", "distance of its mean luminance from the median photo's, negated", NULL, VW_FEATURE_EXPOSURE, -1, 0},
    {"sfm_points", "number of SfM points that it sees", NULL, VW_FEATURE_SFM_POINTS, 1, 0},
    {"sfm_coverage", "its part of the places that validation photos see", NULL, VW_FEATURE_SFM_COVERAGE, 1, 0},
    {"lava", "calibrated gradient of the transport from train to validation photos, negated", NULL,
     VW_FEATURE_TRANSPORT, -1, 0},
};
const uint32_t vw_baseline_count = VW_ARRAY_COUNT(vw_baselines);
