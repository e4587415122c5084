// The evidence of appearance before any training: how differently photos show the points that they share.
#ifndef VIEWWORTH_DETECT_PHOTOMETRIC_H
#define VIEWWORTH_DETECT_PHOTOMETRIC_H

#include "viewworth/scene.h"
#include "viewworth/status.h"

// The mean reduction of the photos' squared errors by exposures (vw_scene_estimate_exposures), as a gain in PSNR at the
// level of a default run, PHOTOMETRIC_LEVEL_DB. The photos are all there are, so the standard error is that of their
// observations.
struct vw_photometric_evidence {
    double gain_db, stderr_db, low_db; // low: end of a one-sided 95 % interval; NaN where no photo tells
    uint32_t photo_count;              // train photos that tell
    uint64_t observation_count;        // theirs
};
enum { PHOTOMETRIC_LEVEL_DB = 22 };
enum vw_status vw_photometric_measure(const struct vw_scene *scene, struct vw_photometric_evidence *evidence);

#endif
