// Near-duplicates among the photos of a scene.
#ifndef VIEWWORTH_SCENE_DUPLICATES_H
#define VIEWWORTH_SCENE_DUPLICATES_H

#include "base/duplicate.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"

// Finds groups of near-duplicates among train and validation photos. Each photo of a group is a near-duplicate of the
// group's first, so that a group does not grow along a video. Two photos are near-duplicates if their files are equal,
// or if
// - their cameras are within 2 degrees of each other, seen from the nearest thing in front of them, and their
// directions
//   differ by at most 2 degrees, roll included, and
// - the luminances of their 16 x 16 cells have a correlation of at least 0.98, which ignores gain and offset.
// So views a few degrees apart are not near-duplicates, but a resized, compressed or brightened copy is. `*duplicates`,
// sorted by group and then by view, is owned by the caller (free).
enum vw_status vw_scene_find_duplicates(const struct vw_scene *scene, struct vw_duplicate **duplicates,
                                        uint32_t *count);

#endif
