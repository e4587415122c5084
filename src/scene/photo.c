// Reads photos when a scene is opened: masks, --downscale, file hashes, transparency, notes on repaired pixels, and the
// pixels of photos that cannot wait.
#include <inttypes.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/text.h"
#include "image/image.h"
#include "image/pixel.h"
#include "scene/builder.h"
#include "scene/mask.h"
#include "scene/photo_source.h"

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
        enum vw_status status = photo->mask_path ? VW_OK
                                                 : vw_scene_find_beside(builder->folder, photo->image_path, "masks",
                                                                        ".png", true, &photo->mask_path);
        if (!status && photo->mask_path)
            status = vw_mask_probe(builder->folder, photo->mask_path, photo->image_header.width_px,
                                   photo->image_header.height_px, &photo->mask_header);
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

static enum vw_status finish_mask(struct vw_photo_reading *reading, struct vw_scene *scene, uint32_t index) {
    const struct vw_scene_builder_photo *photo = &scene->source->photos[index];
    struct vw_image file = {0};
    if (!reading->loads[index].mask) return VW_OK;
    enum vw_status status = vw_image_load_finish(&reading->loads[index].mask, NULL, NULL, &file);
    if (!status)
        status = vw_mask_make(photo->mask_path, &file, photo->image_header.width_px, photo->image_header.height_px,
                              scene->source->downscale, &scene->views[index].mask);
    vw_image_clear(&file);
    return status;
}

static void count_repairs(const struct vw_image *image, const struct vw_image_header *header, struct repairs *repairs) {
    repairs->clamped_views += image->clamped_count > 0;
    repairs->bad_views += image->masked_count > 0;
    repairs->clamped_values += image->clamped_count;
    repairs->bad_pixels += image->masked_count;
    repairs->value_count += (uint64_t)header->width_px * header->height_px * 4;
}

static enum vw_status finish_view(struct vw_photo_reading *reading, struct vw_scene *scene, uint32_t index,
                                  struct repairs *repairs) {
    const struct vw_image_header *header = &scene->source->photos[index].image_header;
    struct vw_image_header loaded = vw_image_loaded_header(header, scene->source->downscale);
    struct vw_view *view = &scene->views[index];
    struct vw_image image = {.width_px = loaded.width_px, .height_px = loaded.height_px, .format = loaded.format};
    enum vw_status status = vw_photo_reading_finish(reading, index, view->sha256, &image);
    if (status || view->split == VW_SPLIT_EXCLUDED) return status;
    view->image = image;
    scene->has_alpha |= image.has_alpha;
    count_repairs(&image, header, repairs);
    status = finish_mask(reading, scene, index);
    return status ? status : vw_lens_mask(view, &repairs->unseen_pixels);
}

static enum vw_status read_files(struct vw_scene *scene, struct repairs *repairs) {
    struct vw_photo_reading reading = {0};
    uint32_t *all = vw_allocate(scene->view_count, sizeof *all);
    if (!all) return VW_ERROR_MEMORY;
    for (uint32_t v = 0; v < scene->view_count; v++) all[v] = v;
    enum vw_status status = vw_photo_reading_begin(scene, all, scene->view_count, true, &reading);
    for (uint32_t v = 0; v < scene->view_count && !status; v++) {
        status = vw_photo_reading_advance(&reading, v);
        if (!status) status = finish_view(&reading, scene, v, repairs);
    }
    vw_photo_reading_end(&reading);
    free(all);
    return status;
}

static enum vw_status note_repairs(struct vw_scene *scene, const struct repairs *repairs) {
    enum vw_status status = VW_OK;
    if (repairs->clamped_views)
        status = vw_scene_note(scene, "%u photo%s: %.2g %% of all pixel values are above 1 and were clamped",
                               repairs->clamped_views, vw_plural(repairs->clamped_views),
                               100.0 * (double)repairs->clamped_values / (double)repairs->value_count);
    if (!status && repairs->bad_views)
        status = vw_scene_note(scene, "%u photo%s: %" PRIu64 " pixels are NaN, infinite or negative and were masked",
                               repairs->bad_views, vw_plural(repairs->bad_views), repairs->bad_pixels);
    if (!status && repairs->unseen_pixels)
        status = vw_scene_note(scene, "%" PRIu64 " pixels are masked because the lens model has no inverse there",
                               repairs->unseen_pixels);
    return status;
}

enum vw_status vw_photos_read(struct vw_scene_builder *builder) {
    struct vw_scene *scene = builder->scene;
    struct repairs repairs = {0};
    enum vw_status status = find_masks(builder);
    if (!status) status = vw_features_find(builder);
    if (status) return status;
    status = vw_photo_source_create(builder);
    if (status) return status;
    downscale_tracks(scene, builder->params->downscale);
    for (uint32_t v = 0; v < scene->view_count; v++)
        downscale_camera(&scene->views[v].camera, builder->params->downscale);
    if (!builder->params->headers_only) status = read_files(scene, &repairs);
    if (status) return status;
    for (int c = 0; c < 3; c++) scene->background[c] = scene->has_alpha ? 1 : 0; // white is Blender's convention
    return note_repairs(scene, &repairs);
}
