// Reads photos when a scene is opened: masks, --downscale, file hashes, transparency, notes on repaired pixels, and the
// pixels of photos that cannot wait.
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/memory.h"
#include "base/text.h"
#include "image/image.h"
#include "image/pixel.h"
#include "scene/builder.h"
#include "scene/photo_source.h"
#include "viewworth/scene.h"

// ---- Masks ---------------------------------------------------------------------------------------------------------

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

// ---- Masks, from their headers ----

char *vw_mask_name(const char *photo) {
    const char *name = vw_view_name_of(photo);
    return vw_format_text("%s.png", strncmp(name, "images/", 7) ? name : name + 7);
}

// Finds the mask of a photo in params->masks, or else in the scene.
static enum vw_status find_mask(const struct vw_scene_builder *builder, struct vw_view *view,
                                struct vw_scene_builder_photo *photo) {
    const char *masks = builder->params->masks;
    char *name = masks ? vw_mask_name(view->name) : NULL, *path = name ? vw_path_join(masks, name) : NULL;
    enum vw_status status = masks && !path ? VW_ERROR_MEMORY : VW_OK;
    if (path && vw_file_exists(path)) {
        free(photo->mask_path);
        photo->mask_path = path;
        photo->mask_folder = vw_copy_text(masks);
        path = NULL;
        if (!photo->mask_folder) status = VW_ERROR_MEMORY;
        view->mask_is_given = true;
    }
    if (!status && !photo->mask_path)
        status = vw_scene_find_beside(builder->folder, photo->image_path, "masks", ".png", true, &photo->mask_path);
    free(name);
    free(path);
    return status;
}

static enum vw_status find_masks(struct vw_scene_builder *builder) {
    struct vw_scene *scene = builder->scene;
    uint32_t given = 0;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        struct vw_scene_builder_photo *photo = &builder->photos[v];
        struct vw_view *view = &scene->views[v];
        if (view->split == VW_SPLIT_EXCLUDED) continue;
        enum vw_status status = find_mask(builder, view, photo);
        if (!status && photo->mask_path)
            status = vw_mask_probe(photo->mask_folder ? photo->mask_folder : builder->folder, photo->mask_path,
                                   photo->image_header.width_px, photo->image_header.height_px, &photo->mask_header);
        if (status) return status;
        view->has_mask = photo->mask_path != NULL;
        scene->masked_view_count += view->has_mask;
        given += view->mask_is_given;
    }
    if (builder->params->masks && !given && !builder->params->headers_only)
        return vw_fail(VW_ERROR_USAGE, "--masks %s: has no mask of a photo; that of images/1.jpg is 1.jpg.png",
                       builder->params->masks);
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

// ---- Pixels ----

struct repairs {
    uint32_t clamped_views, bad_views;
    uint64_t clamped_values, bad_pixels, unseen_pixels, value_count;
};

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
    uint32_t factor = builder->params->downscale;
    enum vw_status status = find_masks(builder);
    if (!status) status = vw_features_find(builder);
    if (status) return status;
    status = vw_photo_source_create(builder);
    if (status) return status;
    downscale_tracks(scene, factor);
    for (uint32_t v = 0; v < scene->view_count; v++) {
        struct vw_camera *camera = &scene->views[v].camera;
        vw_camera_resize(vw_downscaled_px(camera->width_px, factor), vw_downscaled_px(camera->height_px, factor),
                         camera);
    }
    if (!builder->params->headers_only) status = read_files(scene, &repairs);
    if (status) return status;
    for (int c = 0; c < 3; c++) scene->background[c] = scene->has_alpha ? 1 : 0; // white is Blender's convention
    return note_repairs(scene, &repairs);
}
