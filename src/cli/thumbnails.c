#include "cli/thumbnails.h"

#include <stdlib.h>
#include <string.h>

#include "cli/imported.h"
#include "cli/open.h"
#include "viewworth/file.h"
#include "viewworth/image.h"
#include "viewworth/memory.h"

enum { THUMBNAIL_HEIGHT_PX = 96 }; // twice what the page shows, for screens of fine pixels

enum vw_status vw_thumbnails_make(const struct vw_scene *scene, struct vw_report_picture **pictures) {
    struct vw_report_picture *made = vw_allocate(scene->view_count, sizeof *made);
    enum vw_status status = made ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < scene->view_count && !status; i++) {
        const struct vw_image *image = &scene->views[i].image;
        if (scene->views[i].split == VW_SPLIT_EXCLUDED || !image->pixels) continue;
        status = vw_image_make_thumbnail(image, THUMBNAIL_HEIGHT_PX, scene->background, &made[i].data, &made[i].size_bytes);
    }
    if (status) vw_thumbnails_free(made, scene->view_count);
    else *pictures = made;
    return status;
}

// Only recipes, which are files, may need a device; a folder of photos is looked at without one.
static enum vw_status reopen(const struct vw_recorded_run *run, const char *device, struct vw_gpu **gpu, struct vw_scene **scene) {
    const char *path = run->row.scene_path, *options = run->row.scene_options_json;
    if (!vw_reopen_scene(path, options, NULL, scene)) return VW_OK;
    if (!vw_file_exists(path)) return vw_fail_context(VW_ERROR_INPUT, "%s", run->out);
    enum vw_status status = vw_open_gpu(device, false, gpu);
    return status ? status : vw_reopen_scene(path, options, *gpu, scene);
}

enum vw_status vw_thumbnails_make_again(const struct vw_recorded_run *run, const char *device, struct vw_report_picture **pictures) {
    struct vw_gpu *gpu = NULL;
    struct vw_scene *scene = NULL;
    char hash[VW_HASH_HEX_BYTES];
    if (vw_is_imported(&run->row)) return vw_fail(VW_ERROR_INPUT, "%s: was imported and has no photos", run->out);
    enum vw_status status = reopen(run, device, &gpu, &scene);
    if (!status) vw_hash_to_hex(scene->hash, hash);
    if (!status && strcmp(hash, run->row.scene_hash) != 0)
        status = vw_fail(VW_ERROR_INPUT, "%s: no longer the scene that %s was trained on", run->row.scene_path, run->out);
    if (!status) status = vw_thumbnails_make(scene, pictures);
    vw_scene_close(&scene);
    (void)vw_gpu_close(&gpu); // reports only what validation layers said, which are off here
    return status;
}

void vw_thumbnails_free(struct vw_report_picture *pictures, uint32_t count) {
    for (uint32_t i = 0; pictures && i < count; i++) free(pictures[i].data);
    free(pictures);
}
