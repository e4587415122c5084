// A matrix of what can be told of every train photo without retraining: from the photo, its camera, the scene's points
// and the steps of a valued run. Baselines are columns of it.
#ifndef VIEWWORTH_LAB_METHODS_PHOTO_FEATURES_H
#define VIEWWORTH_LAB_METHODS_PHOTO_FEATURES_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/scene.h"
#include "viewworth/status.h"
#include "viewworth/types.h"

enum vw_feature {
    // Pixels of the photo (photo_pixels.h)
    VW_FEATURE_BRIGHTNESS,
    VW_FEATURE_CONTRAST,
    VW_FEATURE_SHARPNESS,
    VW_FEATURE_NOISE,
    VW_FEATURE_EXPOSURE,
    // View of the photo: what it sees, and from what place (photo_sightings.h, scene/view_distance.h)
    VW_FEATURE_SFM_POINTS,
    VW_FEATURE_REPROJECTION_MEAN,
    VW_FEATURE_REPROJECTION_MEDIAN,
    VW_FEATURE_SFM_COVERAGE,
    VW_FEATURE_OVERLAP_TRAIN,
    VW_FEATURE_OVERLAP_VAL,
    VW_FEATURE_NEAREST_RATIO,
    VW_FEATURE_NEAREST_ANGLE,
    VW_FEATURE_TRANSPORT,
    // Steps on the photo in a valued run
    VW_FEATURE_LOSS_FIRST,
    VW_FEATURE_LOSS_LATE,
    VW_FEATURE_LOSS_LAST,
    VW_FEATURE_LOSS_RELATIVE,
    VW_FEATURE_LOSS_SLOPE,
    VW_FEATURE_LOSS_CHANGE,
    VW_FEATURE_CREDIT_PSNR,
    VW_FEATURE_CREDIT_L1,
    VW_FEATURE_COUNT
};

struct vw_feature_about {
    const char *name, *unit, *meaning; // unit "": a plain number
    bool of_run;                       // needs the steps of a valued run
};
extern const struct vw_feature_about vw_features[VW_FEATURE_COUNT];

struct vw_photo_features {
    uint32_t photo_count, seed_count;
    double *values; // owned; [valued seed][photo][enum vw_feature]; NaN: unknown
};

// Measures the photos (train views: scene indices, ascending); what a run tells is unknown, for each of the seeds. Free
// it also after a failure.
enum vw_status vw_photo_features_make(const struct vw_scene *scene, const uint32_t *photos, uint32_t photo_count,
                                      uint32_t seed_count, struct vw_photo_features *features);
// Fills in what the run of a seed tells. A photo without a finite training loss stays unknown.
enum vw_status vw_photo_features_add_run(struct vw_photo_features *features, uint32_t seed, const uint32_t *photos,
                                         const struct vw_step_record *records, uint64_t record_count);
double vw_photo_feature(const struct vw_photo_features *features, uint32_t seed, uint32_t photo,
                        enum vw_feature feature);
void vw_photo_features_free(struct vw_photo_features *features);

#endif
