// Candidates for next photos around the cameras of known ones, without poses inside matter, copies of photos, and poses
// whose photo could not be registered.
#ifndef VIEWWORTH_RUN_NEXT_CANDIDATES_H
#define VIEWWORTH_RUN_NEXT_CANDIDATES_H

#include "run/next/known_photos.h"
#include "scene/camera_path.h"

// Makes up to 400 candidates of poses as candidate_poses.h draws them, 20 per known photo, at least 200 and at most
// 2,000 in all. It keeps those that are
//   new              a quarter of a usual distance or more away from all photos of the scene,
//   outside matter   nothing is on the line from the nearest known camera to the pose and a quarter beyond it, and
//                    nothing is nearer to the pose than half of the least distance of that camera to matter,
//   inside the seen  they see half as much as the median known photo or more, and two known photos see half of that or
//                    more, from the same side, so that structure from motion can register a photo from there.
// VW_ERROR_INPUT when none is left. Free the candidates also after a failure (vw_camera_path_free).
enum vw_status vw_next_candidates_make(const struct vw_known_photos *known, struct vw_camera_path *candidates);

#endif
