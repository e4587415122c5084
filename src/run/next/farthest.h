// The choice among candidates: one after another, the one that is farthest from the photos trained on, where the field
// errs.
//
// This is farthest view sampling of NeRF Director (Xiao et al., CVPR 2024), weighted by errors. The gain of a candidate
// is its distance to the nearest view that is known or chosen (vw_view_apart() in scene/view_distance.h), times the
// root of the field's squared error there: of the mean over validation photos, weighted by 1 / (d^2 + 1/4), d being the
// candidate's distance from each. That root is at least 1e-6, and 1 without validation photos. Coverage, Fisher
// information and nearest errors proposed no better photos (src/lab/results/next_photos.md).
#ifndef VIEWWORTH_RUN_NEXT_FARTHEST_H
#define VIEWWORTH_RUN_NEXT_FARTHEST_H

#include "run/next/known_photos.h"
#include "run/next/proposals.h"

// Fills in first_gains, and the pose and the gain of up to `wanted` proposals, among the candidates; of equal ones the
// first is proposed first.
enum vw_status vw_farthest_pick(const struct vw_known_photos *known, uint32_t wanted, struct vw_next *next);

#endif
