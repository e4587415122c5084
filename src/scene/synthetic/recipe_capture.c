// Transient objects in front of a photo. Deterministic, like defects.
#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "base/random.h"
#include "scene/synthetic/recipe_private.h"

// Places a disc as far from the borders as possible.
static enum vw_status pass_by(const struct vw_recipe *recipe, const uint32_t words[4], uint32_t index,
                              struct vw_recipe_photo *photo, struct vw_view *view) {
    uint32_t width_px = photo->width_px, height_px = photo->height_px, colour[4];
    double radius_px = sqrt(recipe->transient_size * width_px * height_px / M_PI);
    double x_px = radius_px + vw_random_unit(words[1]) * fmax(width_px - 2 * radius_px, 0);
    double y_px = radius_px + vw_random_unit(words[2]) * fmax(height_px - 2 * radius_px, 0);
    vw_random_words(recipe->seed, VW_RANDOM_RECIPE, 1, index, VW_DRAW_TRANSIENT, colour);
    view->mask = vw_allocate((size_t)width_px * height_px, 1);
    if (!view->mask) return VW_ERROR_MEMORY;
    view->has_mask = true;
    memset(view->mask, VW_MASK_KEEP, (size_t)width_px * height_px);
    for (size_t i = 0; i < (size_t)width_px * height_px; i++) {
        if (hypot((double)(i % width_px) + 0.5 - x_px, (double)(i / width_px) + 0.5 - y_px) > radius_px) continue;
        photo->pixels[i] = (struct vw_recipe_pixel){
            .rgba = {vw_random_unit(colour[0]), vw_random_unit(colour[1]), vw_random_unit(colour[2]), 1}, .depth = 0};
        view->mask[i] = VW_MASK_HIDE;
    }
    return VW_OK;
}

enum vw_status vw_recipe_capture(const struct vw_recipe *recipe, uint32_t index, struct vw_recipe_photo *photo,
                                 struct vw_view *view) {
    uint32_t words[4];
    vw_random_words(recipe->seed, VW_RANDOM_RECIPE, 0, index, VW_DRAW_TRANSIENT, words);
    return vw_random_unit(words[0]) < recipe->transient_share ? pass_by(recipe, words, index, photo, view) : VW_OK;
}
