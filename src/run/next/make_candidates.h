// Places for the next photos that nobody has planned: poses around the cameras, without those that no one could or
// should stand at.
#ifndef VIEWWORTH_RUN_NEXT_MAKE_CANDIDATES_H
#define VIEWWORTH_RUN_NEXT_MAKE_CANDIDATES_H

#include "run/next/candidates.h"
#include "run/next/depth_maps.h"

struct vw_candidate_params { // all borrowed
    const struct vw_scene *scene;
    const uint32_t *views; // known photos, scene indices
    uint32_t count;
    const struct vw_depth_map *maps; // theirs
    struct vw_depth_source depths;
    uint64_t seed;
};

// Makes up to 400 candidates of poses as candidate_poses.h draws them, 20 per known photo, at least 200 and at most
// 2,000 in all. It keeps those that are
//   new              a quarter of a usual distance or more away from all photos of the scene,
//   outside matter   nothing stands on the line from the nearest known camera, and a quarter beyond, or nearer to the
//                    pose than half of what is nearest to that camera,
//   inside the seen  they see half as much as the median known photo or more, and at least half of what they see, two
//                    known photos see, so that structure from motion can register a photo from there.
// VW_ERROR_INPUT when none is left. The caller frees them (vw_next_candidates_free).
enum vw_status vw_next_candidates_make(const struct vw_candidate_params *params, struct vw_candidate **candidates,
                                       uint32_t *count);

#endif
