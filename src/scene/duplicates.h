// Photos of a scene that show all but the same.
#ifndef VIEWWORTH_SCENE_DUPLICATES_H
#define VIEWWORTH_SCENE_DUPLICATES_H

#include "base/duplicate.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"

// Finds groups of near-duplicates among the photos that train or validate: each photo of a group is a near-duplicate of
// the group's first, so that groups do not grow along a film. Two photos are near-duplicates when their files have
// equal bytes, or when
// - their cameras stand within 2 degrees of each other, as seen from what lies nearest before them, and point the same
// way within 2
//   degrees, roll included, and
// - the luminances of their 16 x 16 cells correlate to at least 0.98, whatever the exposure: gain and offset drop out.
// Views a few degrees apart have much in common and are each worth their own; a copy that was resized, compressed or
// brightened has not moved. `*duplicates`, group by group and then by view, is owned by the caller (free).
enum vw_status vw_scene_find_duplicates(const struct vw_scene *scene, struct vw_duplicate **duplicates,
                                        uint32_t *count);

#endif
