#include <string.h>

#include "cli/output/print.h"
#include "cli/params.h"
#include "lab/commands/commands.h"
#include "lab/copied_photos.h"
#include "run/session.h"

// Opens the scene; a device makes the photos of a recipe.
static enum vw_status open_scene(const struct vw_options *options, struct vw_gpu **gpu, struct vw_scene **scene) {
    struct vw_scene_params params = options->scene;
    params.headers_only = true;
    enum vw_status status = vw_scene_open(&params, scene);
    bool recipe = !status && strcmp((*scene)->format, "recipe") == 0;
    vw_scene_close(scene);
    if (recipe) status = vw_open_gpu(options->device, false, gpu);
    params.headers_only = false;
    params.gpu = *gpu;
    return status ? status : vw_scene_open(&params, scene);
}

enum vw_status vw_lab_copies(const struct vw_options *options) {
    struct vw_gpu *gpu = NULL;
    struct vw_scene *scene = NULL;
    struct vw_copies_found found;
    enum vw_status status = open_scene(options, &gpu, &scene);
    if (!status) status = vw_find_copies(scene, NULL, &found);
    if (!status)
        vw_print("%s: %u photos, %u of %u pairs are near-duplicates, %.2f s\n", options->operand, found.photos,
                 found.wrong, found.pairs, found.seconds);
    for (uint32_t i = 0; !status && i < vw_copying_count; i++) {
        status = vw_find_copies(scene, &vw_copyings[i], &found);
        if (!status) vw_print("| %s | %u of %u |\n", vw_copyings[i].name, found.found, found.copies);
    }
    vw_scene_close(&scene);
    (void)vw_gpu_close(&gpu);
    return status;
}
