#include "lab/methods/predicted_worth.h"

#include <math.h>

#include "base/memory.h"
#include "lab/methods/predicted_worth_weights.h"

static const double DEVIATION_MOST = 3; // scripts/lab/train_predictor has the same

const uint32_t vw_predictor_count = VW_ARRAY_COUNT(vw_predictor);

static void add_feature(const struct vw_photo_features *features, uint32_t seed, enum vw_feature feature, double weight,
                        double *scores) {
    double sum = 0, squares = 0;
    uint32_t count = 0;
    for (uint32_t i = 0; i < features->photo_count; i++) {
        double value = vw_photo_feature(features, seed, i, feature);
        if (!isfinite(value)) continue;
        sum += value;
        count++;
    }
    double mean = sum / count;
    for (uint32_t i = 0; i < features->photo_count; i++) {
        double value = vw_photo_feature(features, seed, i, feature);
        if (isfinite(value)) squares += (value - mean) * (value - mean);
    }
    double deviation = sqrt(squares / count);
    for (uint32_t i = 0; i < features->photo_count; i++) {
        double value = vw_photo_feature(features, seed, i, feature);
        if (!isfinite(value) || !(deviation > 1e-12 * fabs(mean))) continue;
        scores[i] += weight * fmax(fmin((value - mean) / deviation, DEVIATION_MOST), -DEVIATION_MOST);
    }
}

void vw_predict_worth(const struct vw_photo_features *features, uint32_t seed, double *scores) {
    for (uint32_t i = 0; i < features->photo_count; i++) scores[i] = 0;
    for (uint32_t i = 0; i < vw_predictor_count; i++) {
        enum vw_feature feature;
        if (vw_feature_find(vw_predictor[i].feature, &feature))
            add_feature(features, seed, feature, vw_predictor[i].weight, scores);
    }
}
