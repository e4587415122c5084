#include "run/next/candidates.h"

#include <stdlib.h>

#include "base/memory.h"
#include "scene/camera_path.h"

enum vw_status vw_next_candidates_read(const struct vw_scene *scene, const char *file, uint32_t view,
                                       struct vw_candidate **candidates, uint32_t *count) {
    struct vw_camera_path path = {0};
    enum vw_status status = vw_camera_path_read(scene, file, view, &path);
    if (status) return status;
    *candidates = vw_allocate(path.count, sizeof **candidates);
    *count = *candidates ? path.count : 0;
    for (uint32_t i = 0; i < *count; i++) {
        (*candidates)[i] = (struct vw_candidate){.pose = path.frames[i], .name = path.frames[i].name};
        (*candidates)[i].pose.name = path.frames[i].name = NULL;
    }
    vw_camera_path_free(&path);
    return *candidates ? VW_OK : VW_ERROR_MEMORY;
}

void vw_next_candidates_free(struct vw_candidate **candidates, uint32_t count) {
    for (uint32_t i = 0; *candidates && i < count; i++) free((*candidates)[i].name);
    free(*candidates);
    *candidates = NULL;
}
