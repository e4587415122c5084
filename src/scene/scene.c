#include <dirent.h>
#include <jansson.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/hash.h"
#include "base/json.h"
#include "base/memory.h"
#include "base/text.h"
#include "image/decoder.h"
#include "image/image.h"
#include "image/photo_formats.h"
#include "scene/builder.h"
#include "scene/features.h"
#include "scene/photo_source.h"
#include "scene/splits_file.h"
#include "scene/synthetic/recipe.h"
#include "viewworth/scene.h"

// ---- Formats -------------------------------------------------------------------------------------------------------

static bool probe_recipe(const char *path) {
    void *text = NULL;
    size_t size_bytes = 0;
    if (!vw_file_exists(path) || vw_file_read(path, VW_RECIPE_LIMIT_BYTES, &text, &size_bytes)) return false;
    json_t *file = vw_json_load(text, size_bytes, 0, NULL); // NULL: not JSON
    bool recipe = json_object_get(file, "viewworth_recipe") != NULL;
    json_decref(file);
    free(text);
    return recipe;
}

static enum vw_status load_recipe(struct vw_scene_builder *builder) {
    return vw_recipe_load(builder->params, builder->scene);
}

// If the loader assigns no view to val or test, splits_file.c decides the splits.
static const struct scene_format {
    const char *name; // as --format takes it
    bool (*probe)(const char *path);
    enum vw_status (*load)(struct vw_scene_builder *builder);
} formats[] = {
    // in the order in which they are tried
    {"recipe", probe_recipe, load_recipe},
    {"transforms", vw_transforms_probe, vw_transforms_load},
    {"phototourism", vw_phototourism_probe, vw_phototourism_load},
    {"colmap", vw_colmap_probe, vw_colmap_load},
};

static bool lists_pool(const struct vw_scene_params *params) { return params->pool && !strcmp(params->pool, "list"); }

static enum vw_status check_pool(const struct vw_scene_params *params, const char *format) {
    if (params->pool && strcmp(params->pool, "all") != 0 && !lists_pool(params))
        return vw_fail(VW_ERROR_USAGE, "--pool %s: unknown pool; use all or list", params->pool);
    if (lists_pool(params) && strcmp(format, "phototourism") != 0)
        return vw_fail(
            VW_ERROR_USAGE,
            "--pool list: %s has the format %s, which has no NeRF-W TSV; use --format phototourism or --train",
            params->path, format);
    return VW_OK;
}

static bool has_photos(const char *folder) {
    DIR *listing = folder ? opendir(folder) : NULL;
    bool found = false;
    uint32_t format;
    for (struct dirent *file; listing && !found && (file = readdir(listing));)
        found = vw_photo_format_of_name(file->d_name, &format);
    if (listing) closedir(listing);
    return found;
}

// Refuses a path that no format fits. Photos without poses are what most people have at first.
static enum vw_status refuse_path(const char *path) {
    if (vw_file_exists(path))
        return vw_fail(VW_ERROR_INPUT,
                       "%s: is not a scene; give the folder of a scene, or a scene file with a name in .json", path);
    if (!vw_folder_exists(path)) return vw_fail(VW_ERROR_INPUT, "%s: no such scene; check the path", path);
    if (vw_scene_has_file(path, "poses_bounds.npy"))
        return vw_fail(VW_ERROR_INPUT,
                       "%s: no scene found: LLFF's poses_bounds.npy is not read; add sparse/0, the COLMAP model that "
                       "it was made from, or find the poses again: ns-process-data images",
                       path);
    char *images = vw_path_join(path, "images");
    bool bare = has_photos(path), inside = !bare && has_photos(images);
    free(images);
    if (!bare && !inside)
        return vw_fail(VW_ERROR_INPUT,
                       "%s: no scene found; give a folder with transforms.json, with a TSV and dense/, or with "
                       "sparse/, or a recipe",
                       path);
    return vw_fail(VW_ERROR_INPUT,
                   "%s: no scene found, only photos without poses; find these first: colmap automatic_reconstructor "
                   "--workspace_path W --image_path %s%s, or ns-process-data images",
                   path, path, inside ? "/images" : "");
}

static enum vw_status find_format(const struct vw_scene_params *params, const struct scene_format **format) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(formats); i++) {
        if (params->format ? strcmp(params->format, formats[i].name) != 0 : !formats[i].probe(params->path)) continue;
        *format = &formats[i];
        return VW_OK;
    }
    if (params->format)
        return vw_fail(VW_ERROR_USAGE, "--format %s: unknown format; use recipe, transforms, phototourism or colmap",
                       params->format);
    return refuse_path(params->path);
}

// Notes which format was taken of those that fit, unless the user chose: their poses or photos may differ.
static enum vw_status note_format(struct vw_scene *scene, const struct vw_scene_params *params,
                                  const struct scene_format *taken) {
    const char *others[VW_ARRAY_COUNT(formats)] = {"", "", ""};
    size_t count = 0;
    for (size_t i = 0; i < VW_ARRAY_COUNT(formats) && !params->format; i++)
        if (&formats[i] != taken && formats[i].probe(params->path)) others[count++] = formats[i].name;
    if (!count) return VW_OK;
    return vw_scene_note(scene, "read as %s; --format %s%s%s%s%s fits, too", taken->name, others[0],
                         count > 1 ? " or " : "", others[1], count > 2 ? " or " : "", others[2]);
}

// ---- The hash ------------------------------------------------------------------------------------------------------

static void add_camera(struct vw_hasher *hasher, const struct vw_camera *camera) {
    const double values[] = {camera->focal_x_px, camera->focal_y_px, camera->centre_x_px, camera->centre_y_px,
                             camera->k1,         camera->k2,         camera->k3,          camera->k4,
                             camera->k5,         camera->k6,         camera->p1,          camera->p2};
    vw_hasher_add_integer(hasher, camera->width_px);
    vw_hasher_add_integer(hasher, camera->height_px);
    vw_hasher_add_integer(hasher, camera->lens);
    for (size_t i = 0; i < VW_ARRAY_COUNT(values); i++) vw_hasher_add_real(hasher, values[i]);
}

static void add_view(struct vw_hasher *hasher, const struct vw_view *view) {
    vw_hasher_add_text(hasher, view->name);
    vw_hasher_add_text(hasher, vw_split_name(view->split));
    vw_hasher_add_bytes(hasher, view->sha256, sizeof view->sha256);
    if (view->mask) vw_hasher_add_bytes(hasher, view->mask, (size_t)view->image.width_px * view->image.height_px);
    else vw_hasher_add_null(hasher);
    add_camera(hasher, &view->camera);
    vw_hasher_add_real(hasher, view->near_world);
    vw_hasher_add_real(hasher, view->far_world);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++) vw_hasher_add_real(hasher, view->camera_to_world[i][j]);
}

// Adds what splats begin at, and what exposures are estimated from: points, which views see them, and where.
static void add_points(struct vw_hasher *hasher, const struct vw_scene *scene) {
    vw_hasher_add_integer(hasher, scene->point_count);
    for (uint32_t i = 0; i < scene->point_count; i++) {
        const struct vw_point *point = &scene->points[i];
        for (int axis = 0; axis < 3; axis++) vw_hasher_add_real(hasher, point->position_world[axis]);
        for (int channel = 0; channel < 3; channel++) vw_hasher_add_real(hasher, point->rgb[channel]);
        vw_hasher_add_integer(hasher, point->track_count);
        for (uint32_t t = 0; t < point->track_count; t++) {
            const struct vw_track *track = &scene->tracks[point->first_track + t];
            vw_hasher_add_integer(hasher, track->view);
            vw_hasher_add_real(hasher, track->x_px);
            vw_hasher_add_real(hasher, track->y_px);
        }
    }
}

// Adds nothing when all validation photos weigh the same.
static void add_weights(struct vw_hasher *hasher, const struct vw_scene *scene) {
    if (!vw_scene_has_weights(scene)) return;
    vw_hasher_add_text(hasher, "weights");
    for (uint32_t v = 0; v < scene->view_count; v++) vw_hasher_add_real(hasher, scene->views[v].weight);
}

// Adds nothing where there are no features.
static void add_features(struct vw_hasher *hasher, const struct vw_scene *scene) {
    for (uint32_t v = 0; v < scene->view_count && scene->source; v++) {
        const struct vw_scene_builder_photo *photo = &scene->source->photos[v];
        if (!photo->features_path) continue;
        vw_hasher_add_integer(hasher, v);
        vw_hasher_add_bytes(hasher, photo->features_sha256, sizeof photo->features_sha256);
    }
}

static void hash_scene(const struct vw_scene *scene, uint32_t downscale, uint8_t hash[VW_HASH_BYTES]) {
    struct vw_hasher hasher;
    vw_hasher_begin(&hasher);
    vw_hasher_add_text(&hasher, "viewworth scene 4");
    vw_hasher_add_integer(&hasher, downscale > 1 ? downscale : 1);
    vw_hasher_add_integer(&hasher, scene->view_count);
    for (uint32_t v = 0; v < scene->view_count; v++) add_view(&hasher, &scene->views[v]);
    for (int i = 0; i < 3; i++) vw_hasher_add_real(&hasher, scene->box.centre_world[i]);
    vw_hasher_add_real(&hasher, scene->box.half_extent_world);
    for (int i = 0; i < 3; i++) vw_hasher_add_real(&hasher, scene->background[i]);
    add_points(&hasher, scene);
    add_weights(&hasher, scene);
    add_features(&hasher, scene);
    vw_hasher_end(&hasher, hash);
}

// ---- Opening -------------------------------------------------------------------------------------------------------

// Completes the opening, in the same way for all formats.
static enum vw_status finish(struct vw_scene_builder *builder) {
    const struct vw_scene_params *params = builder->params;
    struct vw_scene *scene = builder->scene;
    enum vw_status status = vw_scene_index_names(scene);
    if (!status) status = vw_splits_assign(builder);
    if (!status) status = vw_providers_read(params->providers, scene);
    if (!status && builder->photos) status = vw_photos_read(builder);
    if (!status && builder->added && !params->headers_only) status = vw_splits_join_duplicates(builder);
    if (!status && builder->added) status = vw_splits_count(params->path, scene);
    if (!status) status = vw_scene_prepare_exposures(scene);
    if (!status && !params->headers_only) status = vw_val_weights_settle(builder);
    if (!status && params->corrupt) status = vw_inject_corruption(params, scene);
    if (!status && !params->headers_only) hash_scene(scene, params->downscale, scene->hash);
    return status;
}

static enum vw_status load(struct vw_scene_builder *builder) {
    const struct vw_scene_params *params = builder->params;
    const struct scene_format *format = NULL;
    enum vw_status status = find_format(params, &format);
    if (!status) status = check_pool(params, format->name);
    if (status) return status;
    builder->folder = vw_folder_exists(params->path) ? vw_copy_text(params->path) : vw_path_folder(params->path);
    builder->scene->path = vw_copy_text(params->path);
    builder->scene->format = vw_copy_text(format->name);
    if (!builder->folder || !builder->scene->path || !builder->scene->format) return VW_ERROR_MEMORY;
    status = note_format(builder->scene, params, format);
    return status ? status : format->load(builder);
}

static void close_builder(struct vw_scene_builder *builder) {
    vw_builder_photos_free(builder->photos, builder->photo_capacity);
    free(builder->added);
    free(builder->folder);
    free(builder->missing_name);
}

// Refuses a folder of masks that is not there, and one for a recipe.
static enum vw_status check_masks(const struct vw_scene_builder *builder) {
    const char *masks = builder->params->masks;
    if (!masks) return VW_OK;
    if (!builder->photos)
        return vw_fail(VW_ERROR_USAGE, "--masks %s: a recipe has no masks; leave the option out", masks);
    return vw_folder_exists(masks) ? VW_OK : vw_fail(VW_ERROR_USAGE, "--masks %s: is not a folder", masks);
}

enum vw_status vw_scene_open(const struct vw_scene_params *params, struct vw_scene **scene) {
    struct vw_scene_builder builder = {.params = params, .scene = vw_allocate(1, sizeof *builder.scene)};
    if (!builder.scene) return VW_ERROR_MEMORY;
    vw_decoder_hold(); // until the scene is closed
    enum vw_status status =
        vw_text_is_clean(params->path)
            ? load(&builder)
            : vw_fail(VW_ERROR_USAGE, "%s: not UTF-8, or has control characters; rename it", params->path);
    if (!status) status = check_masks(&builder);
    if (!status) status = finish(&builder);
    close_builder(&builder);
    if (status) vw_scene_close(&builder.scene);
    else *scene = builder.scene;
    return status;
}

bool vw_view_can_use(const struct vw_view *view, uint32_t x_px, uint32_t y_px) {
    size_t pixel = (size_t)y_px * view->image.width_px + x_px;
    return (!view->mask || view->mask[pixel] != VW_MASK_BEYOND_LENS) &&
           (!view->image.unusable || !view->image.unusable[pixel]);
}

void vw_scene_close(struct vw_scene **scene) {
    struct vw_scene *closing = scene ? *scene : NULL;
    if (!closing) return;
    for (uint32_t v = 0; v < closing->view_count; v++) {
        free(closing->views[v].name);
        free(closing->views[v].provider);
        free(closing->views[v].ground_truth);
        free(closing->views[v].mask);
        vw_image_clear(&closing->views[v].image);
    }
    if (closing->source) vw_features_close(&closing->source->features);
    vw_photo_source_destroy(&closing->source);
    vw_scene_forget_exposures(closing);
    for (uint32_t i = 0; i < closing->note_count; i++) free(closing->notes[i]);
    if (closing->names) vw_name_index_clear(closing->names);
    free(closing->names);
    free(closing->notes);
    free(closing->views);
    free(closing->points);
    free(closing->tracks);
    free(closing->path);
    free(closing->format);
    free(closing->box_source);
    free(closing);
    vw_decoder_release();
    *scene = NULL;
}
