// Near-duplicates among the photos of a scene.
#ifndef VIEWWORTH_SCENE_DUPLICATES_H
#define VIEWWORTH_SCENE_DUPLICATES_H

#include "base/duplicate.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"

// Finds groups of near-duplicates among all photos that are not excluded. Each photo of a group is a near-duplicate of
// the group's first, so that a group does not grow along a video; a photo that is more like a later one leaves its
// group and leads another. Two photos are near-duplicates if their files are equal, or if their luminances correlate,
// which ignores gain and offset:
// - by at least 0.95 if the cameras are together: within 2 degrees of each other, seen from the nearest thing in front
//   of them, with directions that differ by at most 2 degrees, roll included;
// - by at least 0.995 wherever they are, since who copies a photo chooses its pose.
// The correlation is the largest over frames: one photo, or its mirror image, may be shifted, cut off or bordered at
// each edge, by 14 % of the side if the cameras are together and otherwise by 5 %. It is taken over what both photos
// have, which is neither masked nor transparent: 256 points or fewer, at least 8 and half of those of the photo that
// has fewer. So views a few degrees apart are not near-duplicates if they show details. `*duplicates`, sorted by group
// and then by view, is owned by the caller (free).
enum vw_status vw_scene_find_duplicates(const struct vw_scene *scene, struct vw_duplicate **duplicates,
                                        uint32_t *count);

// Finds for each of `views` (scene indices) the photo among `others` that it is most like: matches[i], UINT32_MAX if it
// is a near-duplicate of none. Decodes no further photos, and makes count * other_count comparisons.
enum vw_status vw_scene_match_duplicates(const struct vw_scene *scene, const uint32_t *views, uint32_t count,
                                         const uint32_t *others, uint32_t other_count, uint32_t *matches);

#endif
