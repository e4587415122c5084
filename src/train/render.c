#include "train/render.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "train/evaluator.h"
#include "train/pixels.h"

enum { TILE_RAYS = 8192 };

// Returns the photo's pixel in the middle of the `place`-th of `count` parts of a side.
static uint32_t middle_of(uint32_t side_px, uint64_t place, uint32_t count) {
    return (uint32_t)((2 * place + 1) * side_px / (2 * (uint64_t)count));
}

static enum vw_status render_tiles(const struct vw_scene *scene, uint32_t view, const uint32_t size_px[2],
                                   struct vw_evaluator *evaluator, struct vw_pixel *pixels, vw_float4 *colours,
                                   float *rgb) {
    const struct vw_image *image = &scene->views[view].image;
    uint64_t total = (uint64_t)size_px[0] * size_px[1];
    for (uint64_t first = 0; first < total; first += TILE_RAYS) {
        uint32_t count = total - first < TILE_RAYS ? (uint32_t)(total - first) : TILE_RAYS;
        for (uint32_t i = 0; i < count; i++)
            pixels[i] = vw_pixels_at(scene, view, middle_of(image->width_px, (first + i) % size_px[0], size_px[0]),
                                     middle_of(image->height_px, (first + i) / size_px[0], size_px[1]));
        enum vw_status status = vw_evaluator_render(evaluator, pixels, count, colours);
        if (status) return status;
        for (uint32_t i = 0; i < count; i++) memcpy(rgb + 3 * (first + i), &colours[i], 3 * sizeof *rgb);
    }
    return VW_OK;
}

enum vw_status vw_trainer_render_view(struct vw_radiance_field *field, const struct vw_scene *scene, uint32_t view,
                                      const uint32_t size_px[2], float **rgb) {
    struct vw_evaluator evaluator = {0};
    struct vw_pixel *pixels = vw_allocate(TILE_RAYS, sizeof *pixels);
    vw_float4 *colours = vw_allocate(TILE_RAYS, sizeof *colours);
    float *rendered = vw_allocate((size_t)size_px[0] * size_px[1], 3 * sizeof *rendered);
    enum vw_status status = pixels && colours && rendered ? vw_scene_decode(scene, &view, 1) : VW_ERROR_MEMORY;
    if (!status) status = vw_evaluator_create(field, TILE_RAYS, &evaluator);
    if (!status) status = render_tiles(scene, view, size_px, &evaluator, pixels, colours, rendered);
    vw_evaluator_destroy(&evaluator);
    free(pixels);
    free(colours);
    if (!status) *rgb = rendered;
    else free(rendered);
    return status;
}
