// Predicted worth: a ridge regression from the features of photos to their worth in retrainings, which was fitted on
// generated scenes (scripts/lab/train_predictor). It needs a valued run, and no retraining.
#ifndef VIEWWORTH_LAB_METHODS_PREDICTED_WORTH_H
#define VIEWWORTH_LAB_METHODS_PREDICTED_WORTH_H

#include "lab/methods/photo_features.h"

struct vw_feature_weight {
    const char *feature; // as in vw_features
    double weight;       // standard deviations of worth per standard deviation of the feature, within a scene
};
extern const struct vw_feature_weight vw_predictor[];
extern const uint32_t vw_predictor_count;

// The sum over the weights of the features, each less its mean over the photos and divided by its standard deviation,
// cut to +-3. A feature that is unknown of a photo, or the same of all, adds 0. In standard deviations of worth within
// the scene: it ranks the photos, and its zero is their mean.
void vw_predict_worth(const struct vw_photo_features *features, uint32_t seed, double *scores);

#endif
