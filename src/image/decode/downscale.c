#include <stdlib.h>

#include "base/memory.h"
#include "image/decode/oiio_shim.h"
#include "image/decode/tasks.h"
#include "image/pixel.h"

static float clamp_unit(float value) { return value > 0 ? (value < 1 ? value : 1) : 0; }

// Multiplies colour by alpha, so that hidden colours of transparent or masked pixels do not affect their neighbours.
static float *premultiplied(const struct vw_image *image) {
    size_t pixel_count = (size_t)image->width_px * image->height_px;
    float *rgba = vw_allocate(pixel_count * 4, sizeof *rgba);
    if (!rgba) return NULL;
    for (size_t i = 0; i < pixel_count * 4; i += 4) {
        rgba[i + 3] = vw_pixel_get(image->format, image->pixels, i + 3);
        for (size_t c = 0; c < 3; c++) rgba[i + c] = vw_pixel_get(image->format, image->pixels, i + c) * rgba[i + 3];
    }
    return rgba;
}

// Converts back to straight alpha. In an image without transparency, alpha is below 1 only because of unusable pixels,
// so usable pixels become opaque.
static void straighten(const float premultiplied[4], bool has_alpha, bool unusable, float rgba[4]) {
    const float alpha_min = 0.5f / 65535.0f; // rounds to 0 in 16 bits
    float alpha = premultiplied[3];          // the filter can leave [0,1] a little, as can the colour
    bool visible = alpha >= alpha_min && !unusable;
    for (int c = 0; c < 3; c++) rgba[c] = visible ? clamp_unit(premultiplied[c] / alpha) : 0;
    rgba[3] = !visible ? 0 : has_alpha ? clamp_unit(alpha) : 1;
}

// Marks the small pixels that are at least half unusable; NULL if memory is short.
static uint8_t *downscale_unusable(const struct vw_image *image, uint32_t width_px, uint32_t height_px) {
    uint32_t *bad = vw_allocate((size_t)width_px * height_px, 2 * sizeof *bad),
             *all = bad + (size_t)width_px * height_px;
    uint8_t *unusable = vw_allocate((size_t)width_px * height_px, 1);
    for (uint32_t y = 0; bad && unusable && y < image->height_px; y++) {
        for (uint32_t x = 0; x < image->width_px; x++) {
            size_t small =
                (uint64_t)y * height_px / image->height_px * width_px + (uint64_t)x * width_px / image->width_px;
            bad[small] += image->unusable[(size_t)y * image->width_px + x];
            all[small]++;
        }
    }
    for (size_t i = 0; bad && unusable && i < (size_t)width_px * height_px; i++) unusable[i] = 2 * bad[i] >= all[i];
    if (!bad) {
        free(unusable);
        unusable = NULL;
    }
    free(bad);
    return unusable;
}

enum vw_status vw_image_downscale(struct vw_image *image, uint32_t factor) {
    uint32_t width_px = vw_downscaled_px(image->width_px, factor);
    uint32_t height_px = vw_downscaled_px(image->height_px, factor);
    enum vw_pixel_format format = image->format == VW_PIXEL_FLOAT32 ? VW_PIXEL_FLOAT32 : VW_PIXEL_UINT16;
    size_t value_count = (size_t)width_px * height_px * 4;
    void *pixels = vw_allocate(value_count, vw_pixel_channel_bytes(format));
    uint8_t *unusable = image->unusable ? downscale_unusable(image, width_px, height_px) : NULL;
    float *large = pixels && (unusable || !image->unusable) ? premultiplied(image) : NULL;
    if (!large) {
        free(pixels);
        free(unusable);
        return VW_ERROR_MEMORY;
    }
    struct vw_oiio_result small = vw_oiio_resize(large, image->width_px, image->height_px, width_px, height_px);
    free(large);
    if (small.status) {
        free(pixels);
        free(unusable);
        return vw_fail(small.status, "%s", small.message);
    }
    for (size_t i = 0; i < value_count; i += 4) {
        float rgba[4];
        straighten((const float *)small.data + i, image->has_alpha, unusable && unusable[i / 4], rgba);
        for (size_t c = 0; c < 4; c++) vw_pixel_set(format, pixels, i + c, rgba[c]);
    }
    free(small.data);
    free(image->pixels);
    free(image->unusable);
    image->pixels = pixels;
    image->unusable = unusable;
    image->format = format;
    image->width_px = width_px;
    image->height_px = height_px;
    return VW_OK;
}
