// Places that are proposed for the next photos.
#ifndef VIEWWORTH_RUN_NEXT_PROPOSALS_H
#define VIEWWORTH_RUN_NEXT_PROPOSALS_H

#include "base/hash.h"
#include "scene/camera_path.h"

struct vw_proposal {
    const struct vw_view *pose; // a candidate; its name is that in the file it was read from, NULL: it was made
    double gain;                // its gain beside the proposals before it (farthest.h)
    uint32_t reasons;           // bits by enum vw_next_reason
    double seen_by;             // known photos that see a point that it would see: the median
    uint32_t nearest_view;      // scene index of the nearest known photo
    char *nearest;              // owned; its name
    double apart;               // its distance; 1 is usual between neighbours
    char *move; // owned; the way from the photo of the nearest position, in its own axes: "NAME: 1.9 right, ..."
};

struct vw_next {
    uint32_t photo_count; // known photos
    char scene_hash[VW_HASH_HEX_BYTES];
    struct vw_camera_path candidates; // owned
    double *first_gains;              // owned; by candidate: the gain of that one alone
    struct vw_proposal *proposals;    // owned; in order
    uint32_t proposal_count;
};

#endif
