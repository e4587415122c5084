#include "scene/synthetic/recipe.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/hash.h"
#include "base/json.h"
#include "base/memory.h"
#include "scene/synthetic/recipe_private.h"

static const uint64_t PIXELS_MAX = UINT64_C(1) << 28; // for all views together: 1 GiB of photos

static enum vw_status parse_file(const char *path, json_t **root) {
    void *text = NULL;
    size_t size_bytes = 0;
    enum vw_status status = vw_file_read(path, VW_RECIPE_LIMIT_BYTES, &text, &size_bytes);
    if (!status) status = vw_json_parse(path, text, size_bytes, root);
    free(text);
    return status;
}

static enum vw_status read_recipe(struct vw_recipe *recipe, struct vw_scene *scene) {
    json_t *root = NULL;
    struct vw_json_reader reader = {.path = recipe->path, .status = parse_file(recipe->path, &root)};
    vw_recipe_read_world(&reader, root, recipe, &scene->box);
    vw_recipe_read_cameras(&reader, root, recipe, scene);
    vw_recipe_read_defects(&reader, root, recipe, scene);
    json_decref(root);
    if ((uint64_t)recipe->width_px * recipe->height_px * scene->view_count > PIXELS_MAX)
        vw_json_refuse(&reader, "image",
                       "all photos together have more than %" PRIu64
                       " pixels; use fewer or smaller ones, or --downscale",
                       PIXELS_MAX);
    return reader.status;
}

enum vw_status vw_recipe_store_photo(const struct vw_recipe_photo *photo, struct vw_view *view) {
    size_t pixel_count = (size_t)photo->width_px * photo->height_px;
    uint8_t *bytes = vw_allocate(pixel_count, 4);
    if (!bytes) return VW_ERROR_MEMORY;
    view->image = (struct vw_image){
        .width_px = photo->width_px, .height_px = photo->height_px, .format = VW_PIXEL_UINT8, .pixels = bytes};
    for (size_t i = 0; i < pixel_count; i++) {
        const vw_float4 *p = &photo->pixels[i].rgba;
        const float channels[4] = {p->x, p->y, p->z, p->w};
        for (int c = 0; c < 4; c++) bytes[4 * i + c] = (uint8_t)(channels[c] * 255 + 0.5f);
        view->image.has_alpha |= bytes[4 * i + 3] < 255;
    }
    vw_sha256(bytes, 4 * pixel_count, view->sha256);
    return VW_OK;
}

static enum vw_status make_photo(struct vw_recipe_tracer *tracer, const struct vw_recipe *recipe, uint32_t view,
                                 struct vw_scene *scene, struct vw_recipe_photo *photo, float *depths) {
    enum vw_status status = vw_recipe_trace(tracer, view, photo);
    if (!status) status = vw_recipe_capture(recipe, view, photo, &scene->views[view]);
    if (!status) status = vw_corrupt_photo(recipe, view, photo);
    if (!status) status = vw_recipe_store_photo(photo, &scene->views[view]);
    for (size_t i = 0; !status && i < (size_t)photo->width_px * photo->height_px; i++)
        depths[i] = photo->pixels[i].depth;
    return status;
}

// Photos, then points: both are made with the true poses.
static enum vw_status make_photos(struct vw_gpu *gpu, const struct vw_recipe *recipe, struct vw_scene *scene) {
    size_t pixel_count = (size_t)recipe->width_px * recipe->height_px;
    struct vw_recipe_tracer *tracer = NULL;
    struct vw_recipe_photo photo = {.width_px = recipe->width_px,
                                    .height_px = recipe->height_px,
                                    .pixels = vw_allocate(pixel_count, sizeof *photo.pixels)};
    float *depths = vw_allocate(scene->view_count * pixel_count, sizeof *depths);
    enum vw_status status =
        photo.pixels && depths ? vw_recipe_tracer_create(gpu, recipe, scene, &tracer) : VW_ERROR_MEMORY;
    for (uint32_t v = 0; !status && v < scene->view_count; v++)
        status = make_photo(tracer, recipe, v, scene, &photo, depths + v * pixel_count);
    if (!status && recipe->points == 0) status = vw_recipe_make_points(recipe, depths, scene);
    vw_recipe_tracer_destroy(&tracer);
    free(photo.pixels);
    free(depths);
    return status;
}

enum vw_status vw_recipe_load(const struct vw_scene_params *params, struct vw_scene *scene) {
    if (!params->gpu && !params->headers_only)
        return vw_fail(VW_ERROR_USAGE, "%s: a recipe needs a Vulkan device, but none is open; use --device",
                       params->path);
    struct vw_recipe *recipe = vw_allocate(1, sizeof *recipe);
    if (!recipe) return VW_ERROR_MEMORY;
    recipe->path = params->path;
    recipe->downscale = params->downscale ? params->downscale : 1;
    enum vw_status status = read_recipe(recipe, scene);
    if (!status && !params->headers_only) status = make_photos(params->gpu, recipe, scene);
    for (uint32_t v = 0; v < scene->view_count; v++)
        scene->masked_view_count += scene->views[v].has_mask && scene->views[v].split != VW_SPLIT_EXCLUDED;
    for (uint32_t v = 0; !status && v < scene->view_count; v++)
        vw_corrupt_pose(recipe, v, scene->views[v].camera_to_world);
    scene->has_alpha = recipe->background == BACKGROUND_TRANSPARENT;
    for (int c = 0; c < 3; c++) scene->background[c] = scene->has_alpha ? 1 : 0; // white, as for photos with alpha
    scene->box_source = vw_copy_text("recipe");
    if (!status && !scene->box_source) status = VW_ERROR_MEMORY;
    free(recipe->defects);
    free(recipe);
    return status;
}
