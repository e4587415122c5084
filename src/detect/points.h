// The extent of a scene as points of structure from motion show it, before any training.
#ifndef VIEWWORTH_DETECT_POINTS_H
#define VIEWWORTH_DETECT_POINTS_H

#include "viewworth/scene.h"
#include "viewworth/status.h"

struct vw_point_evidence {
    double outside_share; // observations of points outside the scene's box, of all
    double bare_share;    // area of train photos without a point near (sky, or nothing to match), of all
    double inner_share;   // extent of the inner region of the effect unbounded, of the box's extent
    bool known;           // there are points
};
enum vw_status vw_point_evidence_find(const struct vw_scene *scene, struct vw_point_evidence *evidence);

#endif
