// Proposes where the next photos of a finished run should be taken.
#ifndef VIEWWORTH_RUN_NEXT_NEXT_H
#define VIEWWORTH_RUN_NEXT_NEXT_H

#include "run/next/candidates.h"

struct vw_next_params {
    const char *out;    // the folder of the run
    const char *among;  // file of poses to choose among
    const char *method; // name of the score; NULL: the default
    const char *device; // NULL: the preferred one
    uint32_t count;     // proposals; fewer where there are fewer places
};

struct vw_proposal {
    uint32_t candidate;
    double gain; // by the method, beside the proposals before it
};

struct vw_next {
    const char *method;              // static
    struct vw_candidate *candidates; // owned
    double *first_gains;             // owned; by candidate: the gain of that one alone
    uint32_t candidate_count;
    struct vw_proposal *proposals; // owned; in order
    uint32_t proposal_count;
};

// Makes proposals; writes no file. Free them also after a failure.
enum vw_status vw_next_make(const struct vw_next_params *params, struct vw_next *next);
void vw_next_free(struct vw_next *next);

#endif
