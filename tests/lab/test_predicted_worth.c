// Predicted worth against a plain computation, for the weights that the program has.
#include "support/cmocka_test.h"

#include <math.h>

#include "base/random.h"
#include "lab/methods/predicted_worth.h"

enum { TRAIN = 8 };

static double draw(uint32_t a, uint32_t b) { // uniform in [-1, 1)
    uint32_t words[4];
    vw_random_words(7, VW_RANDOM_JITTER, 3, a, b, words);
    return 2 * vw_random_unit(words[0]) - 1;
}

TEST(worth_is_predicted) {
    double values[TRAIN * VW_FEATURE_COUNT], scores[TRAIN], expected[TRAIN] = {0};
    const struct vw_photo_features features = {TRAIN, 1, values};
    for (uint32_t i = 0; i < TRAIN * VW_FEATURE_COUNT; i++) values[i] = draw(i, 40);
    for (uint32_t w = 0; w < vw_predictor_count; w++) {
        enum vw_feature which;
        if (!vw_feature_find(vw_predictor[w].feature, &which)) fail_msg("%s is no feature", vw_predictor[w].feature);
        if (w == 0) values[which] = NAN; // of photo 0
        double mean = 0, square = 0, known = w == 0 ? TRAIN - 1 : TRAIN;
        for (uint32_t i = w == 0; i < TRAIN; i++) mean += values[i * VW_FEATURE_COUNT + which] / known;
        for (uint32_t i = w == 0; i < TRAIN; i++) square += pow(values[i * VW_FEATURE_COUNT + which] - mean, 2) / known;
        for (uint32_t i = w == 0; i < TRAIN; i++)
            expected[i] += vw_predictor[w].weight * (values[i * VW_FEATURE_COUNT + which] - mean) / sqrt(square);
    }
    vw_predict_worth(&features, 0, scores);
    for (uint32_t i = 0; i < TRAIN; i++) assert_near(scores[i], expected[i], 1e-12);
    for (uint32_t i = 0; i < TRAIN * VW_FEATURE_COUNT; i++) values[i] = 0.1; // nothing tells the photos apart
    vw_predict_worth(&features, 0, scores);
    for (uint32_t i = 0; i < TRAIN; i++) assert_near(scores[i], 0, 0);
}
