// Reads photos: pixels, masks, --downscale, file hashes, transparency, and notes on repaired pixels.
#include <inttypes.h>
#include <unistd.h>

#include "image/downscale.h"
#include "scene/camera_fit.h"
#include "scene/builder.h"
#include "scene/lens_mask.h"
#include "scene/mask.h"
#include "scene/safe_path.h"
#include "image/image.h"
#include "base/hash.h"

struct repairs {
    uint32_t clamped_views, bad_views;
    uint64_t clamped_values, bad_pixels, unseen_pixels, value_count;
};

// ---- Masks, from their headers ----

static enum vw_status find_masks(struct vw_scene_builder *builder) {
    struct vw_scene *scene = builder->scene;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        struct vw_scene_builder_photo *photo = &builder->photos[v];
        struct vw_view *view = &scene->views[v];
        if (view->split == VW_SPLIT_EXCLUDED) continue;
        enum vw_status status =
            photo->mask_path ? VW_OK : vw_mask_find(builder->folder, photo->image_path, &photo->mask_path);
        if (!status && photo->mask_path)
            status = vw_mask_probe(photo->mask_path, view->camera.width_px, view->camera.height_px);
        if (status) return status;
        view->has_mask = photo->mask_path != NULL;
        scene->masked_view_count += view->has_mask;
    }
    uint32_t used_count = scene->view_count - scene->split_count[VW_SPLIT_EXCLUDED];
    if (!scene->masked_view_count || scene->masked_view_count == used_count) return VW_OK;
    return vw_scene_note(scene, "%u of %u photos have a mask; all pixels of the others are used",
                         scene->masked_view_count, used_count);
}

// ---- Sizes ----

static void downscale_tracks(struct vw_scene *scene, uint32_t factor) {
    for (uint32_t i = 0; i < scene->track_count; i++) {
        struct vw_track *track = &scene->tracks[i];
        const struct vw_camera *camera = &scene->views[track->view].camera;
        track->x_px *= (float)vw_downscaled_px(camera->width_px, factor) / (float)camera->width_px;
        track->y_px *= (float)vw_downscaled_px(camera->height_px, factor) / (float)camera->height_px;
    }
}

static void downscale_camera(struct vw_camera *camera, uint32_t factor) {
    vw_camera_resize(vw_downscaled_px(camera->width_px, factor), vw_downscaled_px(camera->height_px, factor), camera);
}

// ---- Pixels ----

static enum vw_status read_mask(const struct vw_scene_builder *builder, uint32_t index, uint32_t width_px,
                                uint32_t height_px) {
    const char *path = builder->photos[index].mask_path;
    return path
               ? vw_mask_load(path, width_px, height_px, builder->params->downscale, &builder->scene->views[index].mask)
               : VW_OK;
}

// Reads a photo and its mask; the size is that before --downscale.
static enum vw_status read_photo(const struct vw_scene_builder *builder, uint32_t index, uint32_t width_px,
                                 uint32_t height_px, struct repairs *repairs) {
    struct vw_view *view = &builder->scene->views[index];
    const char *path = builder->photos[index].image_path;
    int descriptor = -1;
    enum vw_status status = vw_scene_file_open(builder->folder, path, &descriptor);
    if (status) return status;
    status = vw_sha256_descriptor(descriptor, path, view->sha256);
    close(descriptor);
    if (status || view->split == VW_SPLIT_EXCLUDED) return status;
    status = vw_image_load(path, builder->params->downscale, &view->image);
    if (status) return status;
    if (view->image.width_px != view->camera.width_px || view->image.height_px != view->camera.height_px)
        return vw_fail(VW_ERROR_IO, "%s: the image changed its size while it was read; run the command again", path);
    builder->scene->has_alpha |= view->image.has_alpha;
    repairs->clamped_views += view->image.clamped_count > 0;
    repairs->bad_views += view->image.masked_count > 0;
    repairs->clamped_values += view->image.clamped_count;
    repairs->bad_pixels += view->image.masked_count;
    repairs->value_count += (uint64_t)width_px * height_px * 4;
    status = read_mask(builder, index, width_px, height_px);
    return status ? status : vw_lens_mask(view, &repairs->unseen_pixels);
}

static enum vw_status note_repairs(struct vw_scene *scene, const struct repairs *repairs) {
    enum vw_status status = VW_OK;
    if (repairs->clamped_views)
        status = vw_scene_note(scene, "%u photos: %.3g %% of all pixel values are above 1 and were clamped",
                               repairs->clamped_views,
                               100.0 * (double)repairs->clamped_values / (double)repairs->value_count);
    if (!status && repairs->bad_views)
        status = vw_scene_note(scene, "%u photos: %" PRIu64 " pixels are NaN, infinite or negative and were masked",
                               repairs->bad_views, repairs->bad_pixels);
    if (!status && repairs->unseen_pixels)
        status = vw_scene_note(scene, "%" PRIu64 " pixels are masked because the lens model has no inverse there",
                               repairs->unseen_pixels);
    return status;
}

enum vw_status vw_photos_read(struct vw_scene_builder *builder) {
    struct vw_scene *scene = builder->scene;
    struct repairs repairs = {0};
    enum vw_status status = find_masks(builder);
    if (status) return status;
    downscale_tracks(scene, builder->params->downscale);
    for (uint32_t v = 0; v < scene->view_count; v++) {
        struct vw_camera *camera = &scene->views[v].camera;
        uint32_t width_px = camera->width_px, height_px = camera->height_px;
        downscale_camera(camera, builder->params->downscale);
        status = builder->params->headers_only ? VW_OK : read_photo(builder, v, width_px, height_px, &repairs);
        if (status) return status;
    }
    for (int c = 0; c < 3; c++) scene->background[c] = scene->has_alpha ? 1 : 0; // white is Blender's convention
    return note_repairs(scene, &repairs);
}
