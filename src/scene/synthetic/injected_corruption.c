// Injects the defects of recipes into photos of any scene. All random numbers are keyed by a photo's name, so that the
// order of the scene file does not matter. The photos, sorted by these numbers, get the kinds of defects in turn:
// without one of them, the next photo gets its kind.
#include <stdlib.h>
#include <string.h>

#include "base/hash.h"
#include "base/memory.h"
#include "image/image.h"
#include "scene/builder.h"
#include "scene/synthetic/recipe_private.h"

static const double BLUR_WIDTHS = 1.0 / 25;
static const struct vw_recipe_defect kinds[] = {
    {VW_DEFECT_NOISE, 0.2, 0},     {VW_DEFECT_BLUR, 0, 0},       {VW_DEFECT_OCCLUDER, 0.4, 0},
    {VW_DEFECT_EXPOSURE, 0.45, 0}, {VW_DEFECT_WRONG_POSE, 8, 0}, {VW_DEFECT_NOISE, 0.2, 0},
    {VW_DEFECT_BLUR, 0, 0},        {VW_DEFECT_OCCLUDER, 0.4, 0}, {VW_DEFECT_EXPOSURE, 1.9, 0},
    {VW_DEFECT_WRONG_POSE, 8, 0},
};

static uint64_t number_of(const struct vw_view *view) {
    uint8_t hash[VW_HASH_BYTES];
    uint64_t number;
    vw_sha256(view->name, strlen(view->name), hash);
    memcpy(&number, hash, sizeof number); // the same on all machines that SPIR-V and our buffers know: little-endian
    return number;
}

// A view that may be corrupted.
struct candidate {
    uint64_t number;
    struct vw_view *view;
};

static int compare_candidates(const void *a, const void *b) {
    uint64_t left = ((const struct candidate *)a)->number, right = ((const struct candidate *)b)->number;
    return (left > right) - (left < right);
}

// Lists the train views, smallest number first; returns their number.
static uint32_t list_candidates(const struct vw_scene *scene, struct candidate *candidates) {
    uint32_t count = 0;
    for (uint32_t v = 0; v < scene->view_count; v++)
        if (scene->views[v].split == VW_SPLIT_TRAIN)
            candidates[count++] = (struct candidate){number_of(&scene->views[v]), &scene->views[v]};
    if (count) qsort(candidates, count, sizeof *candidates, compare_candidates);
    return count;
}

static enum vw_status corrupt_pixels(const struct vw_recipe *recipe, struct vw_view *view) {
    size_t count = (size_t)view->image.width_px * view->image.height_px;
    struct vw_recipe_photo photo = {.width_px = view->image.width_px,
                                    .height_px = view->image.height_px,
                                    .pixels = vw_allocate(count, sizeof *photo.pixels)};
    if (!photo.pixels) return VW_ERROR_MEMORY;
    for (size_t i = 0; i < count; i++) {
        float rgba[4];
        vw_image_pixel(&view->image, (uint32_t)(i % photo.width_px), (uint32_t)(i / photo.width_px), rgba);
        photo.pixels[i].rgba = (vw_float4){rgba[0], rgba[1], rgba[2], rgba[3]};
    }
    struct vw_image before = view->image;
    enum vw_status status = vw_corrupt_photo(recipe, 0, &photo);
    if (!status) status = vw_recipe_store_photo(&photo, view);
    if (!status) {
        if (!before.lent) free(before.pixels);
        view->image.unusable = before.unusable;
        view->image.masked_count = before.masked_count;
    }
    free(photo.pixels);
    return status;
}

// Corrupts a view as the only one of a recipe.
static enum vw_status corrupt_view(const struct candidate *candidate, struct vw_recipe_defect defect,
                                   struct vw_recipe *recipe) {
    struct vw_view *view = candidate->view;
    if (defect.kind == VW_DEFECT_BLUR) defect.strength = BLUR_WIDTHS * view->camera.width_px;
    recipe->seed = candidate->number;
    recipe->defects = &defect;
    vw_corrupt_pose(recipe, 0, view->camera_to_world);
    bool turned = defect.kind == VW_DEFECT_WRONG_POSE;
    enum vw_status status =
        turned || !view->image.pixels ? VW_OK : corrupt_pixels(recipe, view); // with headers_only there are no pixels
    recipe->defects = NULL;
    view->ground_truth = vw_copy_text(vw_recipe_ground_truths[defect.kind]);
    return status || view->ground_truth ? status : VW_ERROR_MEMORY;
}

static enum vw_status decode(const struct vw_scene *scene, const struct candidate *candidates, uint32_t count) {
    uint32_t *views = vw_allocate(count, sizeof *views);
    if (!views) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < count; i++) views[i] = (uint32_t)(candidates[i].view - scene->views);
    enum vw_status status = vw_scene_decode(scene, views, count);
    free(views);
    return status;
}

static enum vw_status corrupt(const struct vw_scene_params *params, struct vw_scene *scene,
                              struct candidate *candidates, struct vw_recipe *recipe) {
    uint32_t count = list_candidates(scene, candidates);
    if (params->corrupt > count)
        return vw_fail(VW_ERROR_USAGE, "--corrupt %u: there are only %u train photos; use a smaller number",
                       params->corrupt, count);
    enum vw_status status = decode(scene, candidates, params->corrupt);
    for (uint32_t i = 0; !status && i < params->corrupt; i++)
        status = corrupt_view(&candidates[i], kinds[i % VW_ARRAY_COUNT(kinds)], recipe);
    for (uint32_t v = 0; !status && v < scene->view_count; v++) {
        struct vw_view *view = &scene->views[v];
        if (!view->ground_truth && !(view->ground_truth = vw_copy_text(vw_recipe_ground_truths[VW_DEFECT_NONE])))
            status = VW_ERROR_MEMORY;
    }
    return status;
}

enum vw_status vw_inject_corruption(const struct vw_scene_params *params, struct vw_scene *scene) {
    if (!strcmp(scene->format, "recipe"))
        return vw_fail(VW_ERROR_USAGE, "--corrupt: %s is a recipe, which has its own defects; add them there",
                       params->path);
    struct vw_recipe *recipe = vw_allocate(1, sizeof *recipe);
    struct candidate *candidates = vw_allocate(scene->view_count, sizeof *candidates);
    enum vw_status status = recipe && candidates ? corrupt(params, scene, candidates, recipe) : VW_ERROR_MEMORY;
    free(candidates);
    free(recipe);
    return status;
}
