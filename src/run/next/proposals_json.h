// next.json: the proposals of a run, so that a report can show them without scene and device.
#ifndef VIEWWORTH_RUN_NEXT_PROPOSALS_JSON_H
#define VIEWWORTH_RUN_NEXT_PROPOSALS_JSON_H

#include <jansson.h>

#include "run/next/proposals.h"

enum { VW_NEXT_PICTURES_MOST = 20 };        // so that pages stay small
#define VW_NEXT_RENDER_NAME "next_%02u.png" // in OUT, the first is 1

// Makes {"scene_hash": hex, "proposals": [...]}. A proposal has its position and unit direction of view
// in world coordinates, camera_to_world, the gain, reasons (words of run/next/reasons.h), how many known photos see
// what it would see (seen_by), the nearest known photo and its distance (1 is usual between neighbours), the way there
// from the nearest position of a known photo (move), its render, and its name in the file that it was chosen from
// (null: none). NULL when memory is short.
json_t *vw_proposals_to_json(const struct vw_next *next);

// Checks such a file of a stranger, for a page. It may also have "pictures": renders of the first proposals, at
// most VW_NEXT_PICTURES_MOST WebP files in base64. VW_ERROR_INPUT names the file and what is wrong; `path` is for
// messages.
enum vw_status vw_proposals_check(const char *path, json_t *file, const char *scene_hash, uint32_t image_count);

// Leaves the pictures out of the checked text of such a file, which it replaces, after a failure by NULL.
enum vw_status vw_proposals_drop_pictures(char **text);

#endif
