#include "check/mend.h"

#include <stdlib.h>
#include <string.h>

#include "base/hash.h"
#include "base/memory.h"
#include "scene/formats/scene_copy.h"

// Lists all photos, and their hashes, which it writes to `hashes`.
static void list_photos(const struct vw_scene *scene, struct vw_listed_photo *photos,
                        char (*hashes)[VW_HASH_HEX_BYTES]) {
    for (uint32_t v = 0; v < scene->view_count; v++) {
        const struct vw_view *view = &scene->views[v];
        vw_hash_to_hex(view->sha256, hashes[v]);
        photos[v] = (struct vw_listed_photo){view->name, view->split, true, hashes[v]};
    }
}

// Moves photos of a scene that nobody else has, and whose hash is not used.
static uint32_t move(const struct vw_mend_params *params, struct vw_scene *copied) {
    uint32_t moved = 0;
    for (uint32_t i = 0; i < params->check->defect_count; i++) {
        const struct vw_defect *defect = &params->check->defects[i];
        if (defect->kind != VW_DEFECT_POSE) continue;
        memcpy(copied->views[defect->view].camera_to_world, params->check->evidence[defect->view].pose_found,
               sizeof copied->views[defect->view].camera_to_world);
        moved++;
    }
    return moved;
}

static enum vw_status check_same(const struct vw_mend_params *params, const struct vw_scene *copied) {
    bool same = copied->view_count == params->scene->view_count;
    for (uint32_t v = 0; same && v < copied->view_count; v++)
        same = !strcmp(copied->views[v].name, params->scene->views[v].name);
    return same ? VW_OK : vw_fail(VW_ERROR_INPUT, "%s: has changed since it was checked; check it again", copied->path);
}

enum vw_status vw_check_mend(const struct vw_mend_params *params, uint32_t *mended) {
    const struct vw_scene *scene = params->scene;
    struct vw_scene_params opened = *params->opened;
    struct vw_scene *copied = NULL;
    struct vw_listed_photo *photos = vw_allocate(scene->view_count, sizeof *photos);
    char(*hashes)[VW_HASH_HEX_BYTES] = vw_allocate(scene->view_count, sizeof *hashes);
    opened.downscale = 0; // at the size of its files
    opened.headers_only = true;
    enum vw_status status = photos && hashes ? vw_scene_open(&opened, &copied) : VW_ERROR_MEMORY;
    if (!status) status = check_same(params, copied);
    if (!status) {
        list_photos(scene, photos, hashes);
        *mended = move(params, copied);
        const struct vw_photo_list list = {
            .scene_path = opened.path, .photos = photos, .photo_count = scene->view_count, .to = params->to};
        status = vw_scene_copy(&list, copied, params->interrupt);
    }
    vw_scene_close(&copied);
    free(hashes);
    free(photos);
    return status;
}
