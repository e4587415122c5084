// Places that are proposed for the next photos of a finished run, and next.json, which has them for a report.
//
// Places are made (candidates.c) or read from a file; some of them are chosen, one after another (propose.c). The same
// OUT has the same proposals on the same device, bit for bit. next.json decides nothing, so no hash binds it.
#ifndef VIEWWORTH_RUN_NEXT_NEXT_H
#define VIEWWORTH_RUN_NEXT_NEXT_H

#include <jansson.h>

#include "base/hash.h"
#include "scene/camera_path.h"

#define VW_NEXT_RENDER_NAME "next_%02u.png" // in OUT, the first is 1

enum { VW_NEXT_REASON_BYTES = 64 };

struct vw_proposal {
    const struct vw_view *pose;        // a candidate; its name is that in the file it was read from, NULL: it was made
    double gain;                       // its gain beside the proposals before it
    char reason[VW_NEXT_REASON_BYTES]; // "seen by few, high error"; "": none
    double seen_by;                    // known photos that see a point that it would see: the median
    uint32_t nearest_view;             // scene index of the nearest known photo
    char *nearest;                     // owned; its name
    double apart;                      // its distance; 1 is usual between neighbours
    char *move; // owned; the way from the photo of the nearest position, in its own axes: "NAME: 1.9 right, ..."
};

struct vw_next {
    uint32_t photo_count; // known photos
    char scene_hash[VW_HASH_HEX_BYTES];
    struct vw_camera_path candidates; // owned
    struct vw_proposal *proposals;    // owned; in order
    uint32_t proposal_count;
};

struct vw_next_params {
    const char *out;    // the folder of the run
    const char *among;  // file of poses to choose among; NULL: places that are made
    const char *to;     // .json or .ply: a file for other programs; NULL: none
    const char *device; // NULL: the preferred one
    uint32_t count;     // proposals; fewer where there are fewer places
};

// Makes proposals and writes them: `to`, a new file, then in OUT, in place of what an earlier call left, a render of
// what each pose would see, and next.json. `to` is a transforms.json of poses, each with the name of its render in OUT
// and the size of the run's photos, or cameras as pyramids, the first yellow, the last violet. VW_ERROR_USAGE if it
// exists; after a failure there is none. Free the proposals also after a failure.
enum vw_status vw_next_make(const struct vw_next_params *params, struct vw_next *next);
void vw_next_free(struct vw_next *next);

// Makes {"scene_hash": hex, "proposals": [...]}. A proposal has its members, position and unit direction of view in
// world coordinates, camera_to_world and its render. NULL when memory is short. next.json also has "pictures": renders
// of the first proposals, WebP files in base64.
json_t *vw_proposals_to_json(const struct vw_next *next);

#endif
