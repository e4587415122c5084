// Places for a next photo.
#ifndef VIEWWORTH_RUN_NEXT_CANDIDATES_H
#define VIEWWORTH_RUN_NEXT_CANDIDATES_H

#include "viewworth/scene.h"
#include "viewworth/status.h"

struct vw_candidate {
    struct vw_view pose; // camera without a lens, camera_to_world and range of depths; nothing else is set
    char *name;          // owned; of a pose from a file its file_path; NULL: none
};

// Reads the poses of a file (vw_camera_path_read() in scene/camera_path.h), which may lack a size or a focal length:
// they are then those of `view`. The caller frees them.
enum vw_status vw_next_candidates_read(const struct vw_scene *scene, const char *file, uint32_t view,
                                       struct vw_candidate **candidates, uint32_t *count);
void vw_next_candidates_free(struct vw_candidate **candidates, uint32_t count);

#endif
