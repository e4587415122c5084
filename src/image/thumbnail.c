#include <stdlib.h>

#include "base/memory.h"
#include "image/image.h"

// A thumbnail's pixel is the mean of this many samples along each axis, evenly spread over the photo pixels that it
// covers. So the time does not grow with the photo, and is a tenth of that of a proper filter.
enum { SEEN_PER_SIDE = 4, WIDEST = 4 };

// Returns the position of the `place`-th of `count` evenly spread samples along a side.
static uint32_t place_on(uint32_t side_px, uint64_t place, uint64_t count) {
    return (uint32_t)((2 * place + 1) * side_px / (2 * count));
}

static void average(const struct vw_image *image, const uint32_t small_px[2], uint32_t x_px, uint32_t y_px,
                    const float background[3], float *rgb) {
    float sum[3] = {0};
    for (uint32_t i = 0; i < SEEN_PER_SIDE * SEEN_PER_SIDE; i++) {
        uint64_t x = (uint64_t)x_px * SEEN_PER_SIDE + i % SEEN_PER_SIDE,
                 y = (uint64_t)y_px * SEEN_PER_SIDE + i / SEEN_PER_SIDE;
        float rgba[4];
        vw_image_pixel(image, place_on(image->width_px, x, (uint64_t)small_px[0] * SEEN_PER_SIDE),
                       place_on(image->height_px, y, (uint64_t)small_px[1] * SEEN_PER_SIDE), rgba);
        for (int c = 0; c < 3; c++) sum[c] += rgba[3] * rgba[c] + (1 - rgba[3]) * background[c];
    }
    for (int c = 0; c < 3; c++) rgb[c] = sum[c] / (SEEN_PER_SIDE * SEEN_PER_SIDE);
}

enum vw_status vw_image_make_thumbnail(const struct vw_image *image, uint32_t height_px, const float background[3],
                                       void **data, size_t *size_bytes) {
    uint32_t small_height_px = image->height_px < height_px ? image->height_px : height_px;
    uint64_t width_px = ((uint64_t)image->width_px * small_height_px + image->height_px / 2) / image->height_px;
    uint32_t widest_px = WIDEST * height_px, small_width_px = width_px < widest_px ? (uint32_t)width_px : widest_px;
    const uint32_t small_px[2] = {small_width_px ? small_width_px : 1, small_height_px};
    float *pixels = vw_allocate((size_t)small_px[0] * small_px[1], 3 * sizeof *pixels);
    if (!pixels) return VW_ERROR_MEMORY;
    for (uint32_t y = 0; y < small_px[1]; y++)
        for (uint32_t x = 0; x < small_px[0]; x++)
            average(image, small_px, x, y, background, pixels + 3 * ((size_t)y * small_px[0] + x));
    enum vw_status status = vw_image_encode_webp(small_px[0], small_px[1], "webp:70", pixels, data, size_bytes);
    free(pixels);
    return status ? vw_fail_context(status, "thumbnail") : VW_OK;
}
