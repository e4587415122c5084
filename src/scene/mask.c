#include "scene/mask.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "image/image.h"
#include "image/pixel.h"
#include "scene/builder.h"
#include "viewworth/scene.h"

enum vw_status vw_mask_probe(const char *folder, const char *path, uint32_t photo_width_px, uint32_t photo_height_px,
                             struct vw_image_header *header) {
    struct vw_image_header found;
    int descriptor = -1;
    enum vw_status status = vw_scene_file_open(folder, path, &descriptor);
    if (!status) status = vw_image_probe(path, descriptor, &found);
    if (status) return status;
    if ((uint64_t)found.width_px * photo_height_px != (uint64_t)found.height_px * photo_width_px)
        return vw_fail(VW_ERROR_INPUT,
                       "%s: the mask has %u x %u pixels but its photo %u x %u; give both the same shape", path,
                       found.width_px, found.height_px, photo_width_px, photo_height_px);
    *header = found;
    return VW_OK;
}

// ---- Reading ----

// A mask file, and the sizes of the photo.
struct masking {
    const struct vw_image *file;
    uint32_t photo_width_px, photo_height_px; // before --downscale
    uint32_t width_px, height_px;             // after --downscale
};

// Returns the pixel of `to_px` that contains the centre of pixel `at` of `from_px`.
static uint32_t nearest(uint32_t at, uint32_t from_px, uint32_t to_px) {
    return (uint32_t)((2 * (uint64_t)at + 1) * to_px / (2 * (uint64_t)from_px));
}

static bool keeps_photo_pixel(const struct masking *masking, uint32_t x_px, uint32_t y_px) {
    float rgba[4];
    vw_image_pixel(masking->file, nearest(x_px, masking->photo_width_px, masking->file->width_px),
                   nearest(y_px, masking->photo_height_px, masking->file->height_px), rgba);
    return (rgba[0] + rgba[1] + rgba[2]) * rgba[3] >= 1.5f;
}

// Bounds the photo pixels [first, end) that pixel `at` of the downscaled photo covers at least in part.
static uint32_t first_covered(uint32_t at, uint32_t photo_px, uint32_t small_px) {
    return (uint32_t)((uint64_t)at * photo_px / small_px);
}
static uint32_t end_covered(uint32_t at, uint32_t photo_px, uint32_t small_px) {
    return (uint32_t)((((uint64_t)at + 1) * photo_px + small_px - 1) / small_px);
}

static bool keeps(const struct masking *masking, uint32_t x_px, uint32_t y_px) {
    uint32_t end_x = end_covered(x_px, masking->photo_width_px, masking->width_px);
    uint32_t end_y = end_covered(y_px, masking->photo_height_px, masking->height_px);
    for (uint32_t y = first_covered(y_px, masking->photo_height_px, masking->height_px); y < end_y; y++)
        for (uint32_t x = first_covered(x_px, masking->photo_width_px, masking->width_px); x < end_x; x++)
            if (!keeps_photo_pixel(masking, x, y)) return false;
    return true;
}

enum vw_status vw_mask_make(const char *path, const struct vw_image *file, uint32_t photo_width_px,
                            uint32_t photo_height_px, uint32_t downscale, uint8_t **mask) {
    const struct masking masking = {
        .file = file,
        .photo_width_px = photo_width_px,
        .photo_height_px = photo_height_px,
        .width_px = vw_downscaled_px(photo_width_px, downscale),
        .height_px = vw_downscaled_px(photo_height_px, downscale),
    };
    uint64_t kept_count = 0;
    uint8_t *made = vw_allocate((size_t)masking.width_px * masking.height_px, 1);
    if (!made) return VW_ERROR_MEMORY;
    for (uint32_t y = 0; y < masking.height_px; y++) {
        for (uint32_t x = 0; x < masking.width_px; x++) {
            bool kept = keeps(&masking, x, y);
            made[(size_t)y * masking.width_px + x] = kept ? VW_MASK_KEEP : VW_MASK_HIDE;
            kept_count += kept;
        }
    }
    if (kept_count) {
        *mask = made;
        return VW_OK;
    }
    free(made);
    return vw_fail(
        VW_ERROR_INPUT,
        "%s: the mask hides the whole photo, because white keeps and black hides; invert it, or leave the photo out",
        path);
}

static double distance_of(const struct vw_camera *camera, double x_px, double y_px) {
    return hypot((x_px - camera->centre_x_px) / camera->focal_x_px, (y_px - camera->centre_y_px) / camera->focal_y_px);
}

// Returns the distance from the principal point to the farthest pixel, which is in a corner.
static double farthest(const struct vw_camera *camera) {
    double distance = 0;
    for (int corner = 0; corner < 4; corner++)
        distance = fmax(distance, distance_of(camera, corner & 1 ? camera->width_px - 0.5 : 0.5,
                                              corner & 2 ? camera->height_px - 0.5 : 0.5));
    return distance;
}

enum vw_status vw_lens_mask(struct vw_view *view, uint64_t *hidden_count) {
    const struct vw_camera *camera = &view->camera;
    double reach = vw_camera_reach(camera);
    if (farthest(camera) < reach) return VW_OK;
    size_t pixel_count = (size_t)camera->width_px * camera->height_px;
    if (!view->mask) {
        view->mask = vw_allocate(pixel_count, 1);
        if (!view->mask) return VW_ERROR_MEMORY;
        memset(view->mask, VW_MASK_KEEP, pixel_count);
    }
    for (size_t i = 0; i < pixel_count; i++) {
        if (distance_of(camera, (double)(i % camera->width_px) + 0.5, (double)(i / camera->width_px) + 0.5) < reach)
            continue;
        view->mask[i] = VW_MASK_BEYOND_LENS;
        ++*hidden_count;
    }
    return VW_OK;
}

bool vw_view_keeps(const struct vw_view *view, uint32_t x_px, uint32_t y_px) {
    size_t pixel = (size_t)y_px * view->image.width_px + x_px;
    return (!view->mask || view->mask[pixel] == VW_MASK_KEEP) &&
           (!view->image.unusable || !view->image.unusable[pixel]);
}
