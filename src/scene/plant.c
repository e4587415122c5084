// Defects of recipes in photos of any scene. The numbers are keyed by a photo's name, so that a list that leaves others out, or another
// order of the scene file, draws the same for it.
#include <stdlib.h>
#include <string.h>

#include "scene/draft.h"
#include "scene/recipe_private.h"
#include "viewworth/hash.h"
#include "viewworth/memory.h"

static const double BLUR_WIDTHS = 1.0 / 25;
static const struct vw_recipe_defect kinds[] = {
    {VW_DEFECT_NOISE, 0.2, 0},    {VW_DEFECT_BLUR, 0, 0},       {VW_DEFECT_OCCLUDER, 0.4, 0}, {VW_DEFECT_EXPOSURE, 0.45, 0},
    {VW_DEFECT_WRONG_POSE, 8, 0}, {VW_DEFECT_NOISE, 0.2, 0},    {VW_DEFECT_BLUR, 0, 0},       {VW_DEFECT_OCCLUDER, 0.4, 0},
    {VW_DEFECT_EXPOSURE, 1.9, 0}, {VW_DEFECT_WRONG_POSE, 8, 0},
};

static uint64_t number_of(const struct vw_view *view) {
    uint8_t hash[32];
    uint64_t number;
    vw_sha256(view->name, strlen(view->name), hash);
    memcpy(&number, hash, sizeof number); // the same on all machines that SPIR-V and our buffers know: little-endian
    return number;
}

// The clean train view with the smallest number; NULL when there is none.
static struct vw_view *draw_view(const struct vw_scene *scene, const struct vw_recipe *recipe) {
    struct vw_view *drawn = NULL;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        struct vw_view *view = &scene->views[v];
        if (view->split != VW_SPLIT_TRAIN || recipe->defects[v].kind) continue;
        if (!drawn || number_of(view) < number_of(drawn)) drawn = view;
    }
    return drawn;
}

static enum vw_status spoil_pixels(const struct vw_recipe *recipe, uint32_t index, struct vw_view *view) {
    size_t count = (size_t)view->image.width_px * view->image.height_px;
    struct vw_recipe_photo photo = {
        .width_px = view->image.width_px, .height_px = view->image.height_px, .pixels = vw_allocate(count, sizeof *photo.pixels)};
    if (!photo.pixels) return VW_ERROR_MEMORY;
    for (size_t i = 0; i < count; i++) {
        float rgba[4];
        vw_image_pixel(&view->image, (uint32_t)(i % photo.width_px), (uint32_t)(i / photo.width_px), rgba);
        photo.pixels[i].rgba = (vw_float4){rgba[0], rgba[1], rgba[2], rgba[3]};
    }
    struct vw_image before = view->image;
    enum vw_status status = vw_recipe_spoil_photo(recipe, index, &photo);
    if (!status) status = vw_recipe_store_photo(&photo, view);
    if (!status) {
        free(before.pixels);
        view->image.unusable = before.unusable;
        view->image.masked_count = before.masked_count;
    }
    free(photo.pixels);
    return status;
}

static enum vw_status spoil(const struct vw_recipe *recipe, uint32_t index, struct vw_view *view) {
    vw_recipe_spoil_pose(recipe, index, view->camera_to_world);
    if (recipe->defects[index].kind == VW_DEFECT_WRONG_POSE || !view->image.pixels) return VW_OK; // a scene of headers alone has none
    return spoil_pixels(recipe, index, view);
}

static enum vw_status plant(const struct vw_scene_params *params, struct vw_recipe *recipe, struct vw_scene *scene) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < params->plant; i++) {
        struct vw_view *view = draw_view(scene, recipe);
        if (!view)
            return vw_fail(VW_ERROR_USAGE, "--plant %u: only %u photos are trained on; plant fewer", params->plant,
                           scene->split_count[VW_SPLIT_TRAIN]);
        struct vw_recipe_defect *defect = &recipe->defects[view - scene->views];
        *defect = kinds[i % VW_ARRAY_COUNT(kinds)];
        if (defect->kind == VW_DEFECT_BLUR) defect->strength = BLUR_WIDTHS * view->camera.width_px;
        status = spoil(recipe, (uint32_t)(view - scene->views), view);
    }
    for (uint32_t v = 0; !status && v < scene->view_count; v++) {
        scene->views[v].truth = vw_copy_text(vw_recipe_truths[recipe->defects[v].kind]);
        if (!scene->views[v].truth) status = VW_ERROR_MEMORY;
    }
    return status;
}

enum vw_status vw_defects_plant(const struct vw_scene_params *params, struct vw_scene *scene) {
    if (!strcmp(scene->format, "recipe"))
        return vw_fail(VW_ERROR_USAGE, "--plant: %s is a recipe, which names its own defects; write them there", params->path);
    struct vw_recipe *recipe = vw_allocate(1, sizeof *recipe);
    if (!recipe) return VW_ERROR_MEMORY;
    recipe->defects = vw_allocate(scene->view_count, sizeof *recipe->defects);
    enum vw_status status = recipe->defects ? plant(params, recipe, scene) : VW_ERROR_MEMORY;
    free(recipe->defects);
    free(recipe);
    return status;
}
