// Proposes where the next photos of a finished run should be taken.
#ifndef VIEWWORTH_RUN_NEXT_NEXT_H
#define VIEWWORTH_RUN_NEXT_NEXT_H

#include "base/hash.h"
#include "run/next/candidates.h"

struct vw_next_params {
    const char *out;    // the folder of the run
    const char *among;  // file of poses to choose among; NULL: places that are made
    const char *to;     // .json or .ply: a file for other programs; NULL: none
    const char *method; // name of the score; NULL: the default
    const char *device; // NULL: the preferred one
    uint32_t count;     // proposals; fewer where there are fewer places
};

struct vw_proposal {
    uint32_t candidate;
    double gain;           // by the method, beside the proposals before it
    uint32_t reasons;      // bits by enum vw_next_reason
    double seen_by;        // known photos that see what it would see: the median of its pixels
    uint32_t nearest_view; // scene index of the nearest known photo
    char *nearest;         // owned; its name
    double apart;          // its distance; 1 is usual between neighbours
};

struct vw_next {
    const char *method;              // static
    char scene_hash[VW_HASH_HEX_BYTES];
    struct vw_candidate *candidates; // owned
    double *first_gains;             // owned; by candidate: the gain of that one alone
    uint32_t candidate_count;
    struct vw_proposal *proposals; // owned; in order
    uint32_t proposal_count;
};

// Makes proposals and writes them: next.json and renders in OUT, and `to`. VW_ERROR_USAGE if `to` exists. Free the
// proposals also after a failure.
enum vw_status vw_next_make(const struct vw_next_params *params, struct vw_next *next);
void vw_next_free(struct vw_next *next);

#endif
