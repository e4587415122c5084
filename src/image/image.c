#include "image/image.h"

#include <assert.h>
#include <stdlib.h>

void vw_image_clear(struct vw_image *image) {
    if (!image) return;
    if (!image->lent) free(image->pixels);
    free(image->unusable);
    *image = (struct vw_image){0};
}

void vw_image_pixel(const struct vw_image *image, uint32_t x_px, uint32_t y_px, float rgba[4]) {
    assert(image->pixels && "whoever reads a photo of a scene calls vw_scene_decode() before");
    size_t first = ((size_t)y_px * image->width_px + x_px) * 4;
    for (size_t c = 0; c < 4; c++) rgba[c] = vw_pixel_get(image->format, image->pixels, first + c);
}

double vw_luminance_of(const float rgb[3]) { return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]; }

double vw_image_luminance(const struct vw_image *image, uint32_t x_px, uint32_t y_px, const float background[3]) {
    float rgba[4];
    vw_image_pixel(image, x_px, y_px, rgba);
    for (int c = 0; c < 3; c++) rgba[c] = rgba[3] * rgba[c] + (1 - rgba[3]) * background[c];
    return vw_luminance_of(rgba);
}
