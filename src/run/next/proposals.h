// Places that are proposed for the next photos.
#ifndef VIEWWORTH_RUN_NEXT_PROPOSALS_H
#define VIEWWORTH_RUN_NEXT_PROPOSALS_H

#include "base/hash.h"
#include "run/next/candidates.h"

struct vw_proposal {
    uint32_t candidate;
    double gain;           // by the method, beside the proposals before it
    uint32_t reasons;      // bits by enum vw_next_reason
    double seen_by;        // known photos that see what it would see: the median of its pixels
    uint32_t nearest_view; // scene index of the nearest known photo
    char *nearest;         // owned; its name
    double apart;          // its distance; 1 is usual between neighbours
    char *move; // owned; the way from the photo of the nearest position, in its own axes: "NAME: 1.9 right, ..."
};

struct vw_next {
    const char *method, *summary; // static; of the score
    uint32_t photo_count;         // known photos
    char scene_hash[VW_HASH_HEX_BYTES];
    struct vw_candidate *candidates; // owned
    double *first_gains;             // owned; by candidate: the gain of that one alone
    uint32_t candidate_count;
    struct vw_proposal *proposals; // owned; in order
    uint32_t proposal_count;
};

#endif
