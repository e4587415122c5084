// The evidence that a scene gives before any training: facts in its files, and what points of structure from motion
// tell of exposures and of the scene's extent. Facts are exact, one number per scene; photos of the splits train and
// val count, for lenses all photos.
#ifndef VIEWWORTH_DETECT_EVIDENCE_H
#define VIEWWORTH_DETECT_EVIDENCE_H

#include "viewworth/scene.h"
#include "viewworth/status.h"

// Returns the largest shift of a photo's corner by its lens, in pixels, over all photos. No photo resolves a hundredth
// of a pixel.
double vw_fact_distortion(const struct vw_scene *scene);
// Returns the share of photos that have transparent pixels.
double vw_fact_background(const struct vw_scene *scene);
// Returns the share of photos that have a mask file. Any share calls for the effect.
double vw_fact_masks(const struct vw_scene *scene);

// The differences between photos in the points that they share: the mean reduction of their squared errors by exposures
// (vw_scene_estimate_exposures), as a gain in PSNR at the level of a default run, PHOTOMETRIC_LEVEL_DB. The photos are
// all there are, so the standard error is that of their observations.
struct vw_photometric_evidence {
    double gain_db, stderr_db, low_db; // low: end of a one-sided 95 % interval; NaN where no photo tells
    uint32_t photo_count;              // train photos that tell
    uint64_t observation_count;        // theirs
};
enum { PHOTOMETRIC_LEVEL_DB = 22 };
enum vw_status vw_photometric_measure(const struct vw_scene *scene, struct vw_photometric_evidence *evidence);

// The extent of a scene as points show it.
struct vw_point_evidence {
    double outside_share; // observations of points outside the scene's box, of all
    double bare_share;    // area of train photos without a point near (sky, or nothing to match), of all
    double inner_share;   // extent of the inner region of the effect unbounded, of the box's extent
    bool known;           // there are points
};
enum vw_status vw_point_evidence_find(const struct vw_scene *scene, struct vw_point_evidence *evidence);

#endif
