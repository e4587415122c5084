// Writes the photos and the COLMAP model of a recipe, for scripts/lab/benchmark_large:
//
//     make_large_scene RECIPE DENSE    photos DENSE/images/00000000.jpg, ...; the model DENSE/sparse
//
// Photos are four times as wide and high as the recipe says: tracing them small is 16 times as fast, and what a large
// scene takes does not depend on what its photos show.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/memory.h"
#include "image/image.h"
#include "image/photo_formats.h"
#include "scene/builder.h"
#include "scene/formats/scene_copy.h"
#include "viewworth/gpu.h"
#include "viewworth/scene.h"

enum { ENLARGED = 4 };

static enum vw_status write_photo(const struct vw_image *image, const char *path) {
    uint32_t width_px = ENLARGED * image->width_px, height_px = ENLARGED * image->height_px;
    size_t pixel_count = (size_t)width_px * height_px, size_bytes = 0;
    struct vw_image_encoding encoding = {
        .width_px = width_px, .height_px = height_px, .channels = 3, .eight_bit = true, .compression = "jpeg:90"};
    float *rgb = vw_allocate(pixel_count, 3 * sizeof *rgb), rgba[4];
    void *file = NULL;
    enum vw_status status = rgb && vw_photo_format_of_name(path, &encoding.format) ? VW_OK : VW_ERROR_MEMORY;
    for (size_t i = 0; !status && i < pixel_count; i++) {
        vw_image_pixel(image, (uint32_t)(i % width_px) / ENLARGED, (uint32_t)(i / width_px) / ENLARGED, rgba);
        memcpy(rgb + 3 * i, rgba, 3 * sizeof *rgb);
    }
    if (!status) status = vw_image_encode(&encoding, rgb, &file, &size_bytes);
    if (!status) status = vw_file_write(path, file, size_bytes);
    free(file);
    free(rgb);
    return status;
}

// Writes the photo of a view, and names and enlarges the view as the model has it.
static enum vw_status write_view(struct vw_view *view, const char *dense, uint32_t number) {
    char *path = vw_format_text("%s/images/%08u.jpg", dense, number);
    enum vw_status status = path ? write_photo(&view->image, path) : VW_ERROR_MEMORY;
    free(view->name);
    view->name = path ? vw_copy_text(strrchr(path, '/') + 1) : NULL;
    vw_camera_resize(ENLARGED * view->camera.width_px, ENLARGED * view->camera.height_px, &view->camera);
    free(path);
    return status || view->name ? status : VW_ERROR_MEMORY;
}

static enum vw_status write_scene(struct vw_scene *scene, const char *dense) {
    enum vw_status status = VW_OK;
    for (uint32_t v = 0; !status && v < scene->view_count; v++) status = write_view(&scene->views[v], dense, v);
    for (uint32_t t = 0; t < scene->track_count; t++) {
        scene->tracks[t].x_px *= ENLARGED;
        scene->tracks[t].y_px *= ENLARGED;
    }
    char *model = vw_path_join(dense, "sparse");
    if (!status) status = model ? vw_colmap_write(scene, model) : VW_ERROR_MEMORY;
    free(model);
    return status;
}

int main(int argc, char **argv) {
    if (argc != 3) {
        fprintf(stderr, "usage: make_large_scene RECIPE DENSE\n");
        return 2;
    }
    struct vw_gpu *gpu = NULL;
    struct vw_scene *scene = NULL;
    enum vw_status status = vw_gpu_open(&(struct vw_gpu_params){0}, &gpu);
    if (!status) status = vw_scene_open(&(struct vw_scene_params){.path = argv[1], .gpu = gpu}, &scene);
    if (!status) status = write_scene(scene, argv[2]);
    if (status) fprintf(stderr, "make_large_scene: %s\n", vw_error_message());
    vw_scene_close(&scene);
    (void)vw_gpu_close(&gpu);
    return status != VW_OK;
}
