// Proposes where the next photos of a finished run should be taken.
//
// Depth maps of 24 x 18 pixels describe the world (depth_maps.h): a ray ends at a transmittance of one half. Poses are
// made (candidate_poses.h) and filtered (candidates.h), or read from a file; some of them are chosen, one after another
// (farthest.h); reasons are found after that and change no choice (reasons.h). The same OUT has the
// same proposals on the same device, bit for bit. next.json decides nothing, so no hash binds it: the report checks it
// as a stranger's file (proposals_json.h).
#ifndef VIEWWORTH_RUN_NEXT_NEXT_H
#define VIEWWORTH_RUN_NEXT_NEXT_H

#include "run/next/proposals.h"

struct vw_next_params {
    const char *out;    // the folder of the run
    const char *among;  // file of poses to choose among; NULL: places that are made
    const char *to;     // .json or .ply: a file for other programs; NULL: none
    const char *device; // NULL: the preferred one
    uint32_t count;     // proposals; fewer where there are fewer places
};

// Makes proposals and writes them: next.json and renders in OUT, and `to`. VW_ERROR_USAGE if `to` exists. Free the
// proposals also after a failure.
enum vw_status vw_next_make(const struct vw_next_params *params, struct vw_next *next);
void vw_next_free(struct vw_next *next);

#endif
