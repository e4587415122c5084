#include "run/outputs/thumbnails.h"

#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/memory.h"
#include "image/image.h"
#include "run/devices.h"

enum { THUMBNAIL_HEIGHT_PX = 96, LARGE_HEIGHT_PX = 240, LARGE_AT_MOST = 200 }; // larger where a page can hold them

static enum vw_status make_one(const struct vw_scene *scene, uint32_t view, struct vw_thumbnails *made) {
    const struct vw_image *image = &scene->views[view].image;
    struct vw_report_picture *picture = &made->pictures[view];
    made->names[view] = vw_copy_text(scene->views[view].name);
    if (!made->names[view]) return VW_ERROR_MEMORY;
    if (scene->views[view].split == VW_SPLIT_EXCLUDED || !image->pixels) return VW_OK;
    return vw_image_make_thumbnail(image, scene->view_count > LARGE_AT_MOST ? THUMBNAIL_HEIGHT_PX : LARGE_HEIGHT_PX,
                                   scene->background, &picture->data, &picture->size_bytes);
}

double vw_thumbnails_estimate_s(const struct vw_scene *scene) {
    double started_s = 0;
    uint32_t made = 0;
    for (uint32_t v = 0; v < scene->view_count && made < 2; v++) { // the first also loads the library
        const struct vw_image *image = &scene->views[v].image;
        void *data = NULL;
        size_t size_bytes = 0;
        if (scene->views[v].split == VW_SPLIT_EXCLUDED || vw_scene_decode(scene, &v, 1) || !image->pixels) continue;
        started_s = vw_now_s();
        (void)vw_image_make_thumbnail(image, THUMBNAIL_HEIGHT_PX, scene->background, &data,
                                      &size_bytes); // that fails again, in its place
        free(data);
        made++;
    }
    return made ? (vw_now_s() - started_s) * scene->view_count : 0;
}

enum vw_status vw_thumbnails_make(const struct vw_scene *scene, struct vw_thumbnails *thumbnails) {
    struct vw_thumbnails made = {.names = vw_allocate(scene->view_count, sizeof *made.names),
                                 .pictures = vw_allocate(scene->view_count, sizeof *made.pictures)};
    enum vw_status status = made.names && made.pictures ? VW_OK : VW_ERROR_MEMORY;
    if (!status) made.count = scene->view_count;
    if (!status) status = vw_scene_decode_all(scene);
    for (uint32_t i = 0; i < made.count && !status; i++) status = make_one(scene, i, &made);
    if (status) vw_thumbnails_free(&made);
    else *thumbnails = made;
    return status;
}

// Opens the scene again; only recipes, which are files, may need a device.
static enum vw_status reopen(const struct vw_recorded_scene *recorded, const char *device, struct vw_gpu **gpu,
                             struct vw_scene **scene) {
    if (!vw_reopen_scene(recorded->path, recorded->options_json, NULL, scene)) return VW_OK;
    if (!vw_file_exists(recorded->path)) return vw_fail_context(VW_ERROR_INPUT, "%s", recorded->out);
    enum vw_status status = vw_open_gpu(device, false, gpu);
    return status ? status : vw_reopen_scene(recorded->path, recorded->options_json, *gpu, scene);
}

enum vw_status vw_thumbnails_make_again(const struct vw_recorded_scene *recorded, const char *device,
                                        struct vw_thumbnails *thumbnails) {
    struct vw_gpu *gpu = NULL;
    struct vw_scene *scene = NULL;
    char hash[VW_HASH_HEX_BYTES];
    enum vw_status status = reopen(recorded, device, &gpu, &scene);
    if (!status) vw_hash_to_hex(scene->hash, hash);
    if (!status && strcmp(hash, recorded->hash) != 0)
        status = vw_fail(VW_ERROR_INPUT, "%s: no longer the scene that %s was made of", recorded->path, recorded->out);
    if (!status) status = vw_thumbnails_make(scene, thumbnails);
    vw_scene_close(&scene);
    (void)vw_gpu_close(&gpu); // reports only what validation layers said, which are off here
    return status;
}

void vw_thumbnails_free(struct vw_thumbnails *thumbnails) {
    for (uint32_t i = 0; i < thumbnails->count; i++) {
        free(thumbnails->names[i]);
        free(thumbnails->pictures[i].data);
    }
    free(thumbnails->names);
    free(thumbnails->pictures);
    *thumbnails = (struct vw_thumbnails){0};
}
