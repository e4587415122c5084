// The choice among candidates: one after another, the one that is farthest from all photos where the field errs.
//
// This is farthest view sampling of NeRF Director (Xiao et al., CVPR 2024), weighted by errors. The gain of a candidate
// is its distance to the nearest view that is known or chosen (vw_view_apart() in scene/view_distance.h), times the
// root of the field's squared error there: of the mean over validation photos, weighted by 1 / (d^2 + 1/4), d being the
// candidate's distance from each. Neither it nor coverage, Fisher information or nearest errors chose better photos
// than plain farthest sampling or chance (src/lab/results/next_photos.md).
#ifndef VIEWWORTH_RUN_NEXT_FARTHEST_H
#define VIEWWORTH_RUN_NEXT_FARTHEST_H

#include "run/next/known_photos.h"
#include "scene/camera_path.h"

// Picks `wanted` <= candidates->count of them; of equal ones the first comes first. `gains` has what each pick gained
// beside those before it, and `first_gains`, by candidate, what each gains alone.
enum vw_status vw_farthest_pick(const struct vw_known_photos *known, const struct vw_camera_path *candidates,
                                uint32_t wanted, uint32_t *picks, double *gains, double *first_gains);

#endif
