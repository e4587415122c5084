// Baselines: scores without retraining, most of them a feature of the photos (methods/photo_features.h).
#ifndef VIEWWORTH_LAB_BASELINES_H
#define VIEWWORTH_LAB_BASELINES_H

#include <stdint.h>

#include "lab/methods/photo_features.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"

// Inputs of the baselines.
struct vw_baseline_input {
    const struct vw_scene *scene;
    const uint32_t *photos; // scene indices
    const struct vw_photo_features *features;
    uint32_t valued; // the valued seed, as features count them
    uint64_t seed;   // seed of that run
};

// `score` fills in a score per photo, more = better; NULL: the score is `sign` times the feature.
struct vw_baseline {
    const char *name, *meaning;
    void (*score)(const struct vw_baseline_input *input, double *scores);
    enum vw_feature feature;
    double sign;
    uint32_t trainings; // that its scores take
};

extern const struct vw_baseline vw_baselines[];
extern const uint32_t vw_baseline_count;

// Fills in a score per photo. NaN: unknown; but a photo on which the run took no step has the score 0.
void vw_baseline_score(const struct vw_baseline *baseline, const struct vw_baseline_input *input, double *scores);

#endif
