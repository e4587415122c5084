// Reads photos: pixels, masks, --downscale, file hashes, transparency, and notes on repaired pixels.
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <unistd.h>

#include "image/decoder.h"
#include "image/downscale.h"
#include "scene/camera_fit.h"
#include "scene/builder.h"
#include "scene/lens_mask.h"
#include "scene/mask.h"
#include "scene/safe_path.h"
#include "image/image.h"
#include "base/hash.h"
#include "base/memory.h"

static const uint64_t TOTAL_LIMIT_BYTES = UINT64_C(1) << 36; // of a scene's photos
static const uint64_t AHEAD_LIMIT_BYTES = UINT64_C(1) << 30; // of photos that are decoded before it is their turn

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

// All photos are in memory at once. The limit is also that of the machine, which would otherwise stall.
static enum vw_status check_total(const struct vw_scene_builder *builder) {
    const struct vw_scene *scene = builder->scene;
    uint64_t total_bytes = 0, most_bytes = TOTAL_LIMIT_BYTES;
    uint64_t machine_bytes = (uint64_t)sysconf(_SC_PHYS_PAGES) * (uint64_t)sysconf(_SC_PAGESIZE);
    if (!builder->params->headers_only && machine_bytes < most_bytes) most_bytes = machine_bytes;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        if (scene->views[v].split == VW_SPLIT_EXCLUDED) continue;
        total_bytes += vw_image_loaded_bytes(&builder->photos[v].image_header, builder->params->downscale);
        if (total_bytes > most_bytes)
            return vw_fail(VW_ERROR_INPUT,
                           "%s: with this one, the photos are more than the limit of %.1f GiB in memory; use "
                           "--downscale, or fewer photos",
                           builder->photos[v].image_path, ldexp((double)most_bytes, -30));
    }
    return VW_OK;
}

// ---- Decoding ahead ----

// Several photos are decoded at once, by other processes; they are finished in their order, so that neither the scene
// nor the first error depends on timing.
struct reading {
    struct vw_scene_builder *builder;
    struct loads {
        struct vw_image_load *image, *mask;
    } * loads;      // owned; per view
    uint32_t begun; // views whose loads have begun
    uint64_t decoded_ahead_bytes;
    struct repairs repairs;
};

static uint64_t decoded_bytes(const struct reading *reading, uint32_t index) {
    const struct vw_image_header *header = &reading->builder->photos[index].image_header;
    return (uint64_t)header->width_px * header->height_px * header->channels * sizeof(float);
}

static enum vw_status begin_load(const struct vw_scene_builder *builder, const char *path,
                                 const struct vw_image_header *header, uint32_t downscale,
                                 struct vw_image_load **load) {
    int descriptor = -1;
    enum vw_status status = vw_scene_file_open(builder->folder, path, &descriptor);
    return status ? status : vw_image_load_begin(path, descriptor, header, downscale, load);
}

static enum vw_status begin_view(struct reading *reading, uint32_t index) {
    const struct vw_scene_builder *builder = reading->builder;
    const struct vw_scene_builder_photo *photo = &builder->photos[index];
    struct loads *loads = &reading->loads[index];
    if (builder->scene->views[index].split == VW_SPLIT_EXCLUDED) { // it is not decoded
        reading->begun = index + 1;
        return VW_OK;
    }
    enum vw_status status =
        begin_load(builder, photo->image_path, &photo->image_header, builder->params->downscale, &loads->image);
    if (!status && photo->mask_path)
        status = begin_load(builder, photo->mask_path, &photo->mask_header, 1, &loads->mask);
    if (status) {
        vw_image_load_cancel(&loads->image);
        return status;
    }
    reading->begun = index + 1;
    reading->decoded_ahead_bytes += decoded_bytes(reading, index);
    return VW_OK;
}

// Begins the view that is next, and some after it. What fails there fails again when it is its turn.
static enum vw_status begin_ahead(struct reading *reading, uint32_t next) {
    uint32_t ahead = vw_decoder_parallel_count() + 1;
    enum vw_status status = reading->begun > next ? VW_OK : begin_view(reading, next);
    while (!status && reading->begun < reading->builder->scene->view_count && reading->begun < next + ahead &&
           reading->decoded_ahead_bytes < AHEAD_LIMIT_BYTES)
        if (begin_view(reading, reading->begun)) break;
    return status;
}

// ---- Pixels ----

static enum vw_status finish_mask(struct reading *reading, uint32_t index) {
    const struct vw_scene_builder_photo *photo = &reading->builder->photos[index];
    struct vw_image file = {0};
    if (!reading->loads[index].mask) return VW_OK;
    enum vw_status status = vw_image_load_finish(&reading->loads[index].mask, NULL, &file);
    if (!status)
        status = vw_mask_make(photo->mask_path, &file, photo->image_header.width_px, photo->image_header.height_px,
                              reading->builder->params->downscale, &reading->builder->scene->views[index].mask);
    vw_image_clear(&file);
    return status;
}

static enum vw_status hash_file(const char *folder, const char *path, uint8_t sha256[VW_HASH_BYTES]) {
    int descriptor = -1;
    enum vw_status status = vw_scene_file_open(folder, path, &descriptor);
    if (status) return status;
    status = vw_sha256_descriptor(descriptor, path, sha256);
    close(descriptor);
    return status;
}

static enum vw_status finish_view(struct reading *reading, uint32_t index) {
    const struct vw_scene_builder_photo *photo = &reading->builder->photos[index];
    struct vw_view *view = &reading->builder->scene->views[index];
    struct repairs *repairs = &reading->repairs;
    if (view->split == VW_SPLIT_EXCLUDED) return hash_file(reading->builder->folder, photo->image_path, view->sha256);
    enum vw_status status = vw_image_load_finish(&reading->loads[index].image, view->sha256, &view->image);
    reading->decoded_ahead_bytes -= decoded_bytes(reading, index);
    if (status) return status;
    reading->builder->scene->has_alpha |= view->image.has_alpha;
    repairs->clamped_views += view->image.clamped_count > 0;
    repairs->bad_views += view->image.masked_count > 0;
    repairs->clamped_values += view->image.clamped_count;
    repairs->bad_pixels += view->image.masked_count;
    repairs->value_count += (uint64_t)photo->image_header.width_px * photo->image_header.height_px * 4;
    status = finish_mask(reading, index);
    return status ? status : vw_lens_mask(view, &repairs->unseen_pixels);
}

static enum vw_status read_pixels(struct vw_scene_builder *builder, struct repairs *repairs) {
    uint32_t view_count = builder->scene->view_count;
    struct reading reading = {.builder = builder, .loads = vw_allocate(view_count, sizeof *reading.loads)};
    enum vw_status status = reading.loads ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t v = 0; v < view_count && !status; v++) {
        status = begin_ahead(&reading, v);
        if (!status) status = finish_view(&reading, v);
    }
    for (uint32_t v = 0; reading.loads && v < view_count; v++) {
        vw_image_load_cancel(&reading.loads[v].image);
        vw_image_load_cancel(&reading.loads[v].mask);
    }
    free(reading.loads);
    *repairs = reading.repairs;
    return status;
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
    status = check_total(builder);
    if (status) return status;
    downscale_tracks(scene, builder->params->downscale);
    for (uint32_t v = 0; v < scene->view_count; v++)
        downscale_camera(&scene->views[v].camera, builder->params->downscale);
    if (!builder->params->headers_only) status = read_pixels(builder, &repairs);
    if (status) return status;
    for (int c = 0; c < 3; c++) scene->background[c] = scene->has_alpha ? 1 : 0; // white is Blender's convention
    return note_repairs(scene, &repairs);
}
