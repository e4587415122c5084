// Overlap of photos, from the places that they see: the points of structure from motion, or, in a scene that has none,
// places on rays of its train and validation photos, as far away as the middle of the box.
#ifndef VIEWWORTH_LAB_METHODS_PHOTO_SIGHTINGS_H
#define VIEWWORTH_LAB_METHODS_PHOTO_SIGHTINGS_H

#include "viewworth/scene.h"
#include "viewworth/status.h"

// Sightings of one photo. NaN: unknown.
struct vw_photo_sightings {
    uint32_t points;      // SfM points that it sees: its tracks
    double overlap_train; // mean over its places of the share of the other train photos that see them; 0: sees none
    double overlap_val;   // the same with the validation photos
    double coverage;      // sum over its places that validation photos see of 1 / (train photos that see them),
                          // divided by all places that validation photos see: parts of the share that is covered
    double reprojection_mean_px;   // distance of its tracks from where its camera projects their points, at most the
    double reprojection_median_px; // photo's diagonal; NaN without tracks
};

// Fills one entry of `sightings` for each of these train photos (scene indices, ascending). Only they count as train
// photos.
enum vw_status vw_photo_sightings_find(const struct vw_scene *scene, const uint32_t *photos, uint32_t photo_count,
                                       struct vw_photo_sightings *sightings);

// Projects a place in world coordinates into a view; returns false when it lies behind the camera or outside the photo.
// `depth_world` (NULL: not wanted) is along the axis.
bool vw_view_project(const struct vw_view *view, const double position_world[3], double *x_px, double *y_px,
                     double *depth_world);

#endif
