#include <stdlib.h>

#include "image/oiio_shim.h"
#include "viewworth/image.h"
#include "viewworth/memory.h"

// The filter sees every pixel of a small photo and about four by four for each of the thumbnail's: large photos take no longer.
enum { SEEN_PER_PIXEL = 4, WIDEST = 4 };

static uint32_t at_most(uint32_t value, uint32_t limit) { return value < limit ? value : limit; }

// Opaque RGBA of `width_px` x `height_px` pixels, evenly spread over the image.
static float *pick_pixels(const struct vw_image *image, uint32_t width_px, uint32_t height_px, const float background[3]) {
    float *picked = vw_allocate((size_t)width_px * height_px, 4 * sizeof *picked);
    for (uint32_t y = 0; picked && y < height_px; y++) {
        uint32_t from_y = (uint32_t)((2 * (uint64_t)y + 1) * image->height_px / (2 * (uint64_t)height_px));
        for (uint32_t x = 0; x < width_px; x++) {
            float *rgba = picked + 4 * ((size_t)y * width_px + x);
            vw_image_pixel(image, (uint32_t)((2 * (uint64_t)x + 1) * image->width_px / (2 * (uint64_t)width_px)), from_y, rgba);
            for (int c = 0; c < 3; c++) rgba[c] = rgba[3] * rgba[c] + (1 - rgba[3]) * background[c];
            rgba[3] = 1;
        }
    }
    return picked;
}

// Lanczos overshoots. Four channels become three, in place.
static void drop_alpha(float *pixels, size_t pixel_count) {
    for (size_t i = 0; i < pixel_count; i++)
        for (size_t c = 0; c < 3; c++) {
            float value = pixels[4 * i + c];
            pixels[3 * i + c] = value > 0 ? value < 1 ? value : 1 : 0;
        }
}

enum vw_status vw_image_make_thumbnail(const struct vw_image *image, uint32_t height_px, const float background[3], void **data,
                                       size_t *size_bytes) {
    uint32_t small_height_px = at_most(image->height_px, height_px);
    uint64_t width_px = ((uint64_t)image->width_px * small_height_px + image->height_px / 2) / image->height_px;
    uint32_t small_width_px = width_px < 1 ? 1 : width_px > WIDEST * height_px ? WIDEST * height_px : (uint32_t)width_px;
    uint32_t seen_width_px = at_most(image->width_px, SEEN_PER_PIXEL * small_width_px);
    uint32_t seen_height_px = at_most(image->height_px, SEEN_PER_PIXEL * small_height_px);
    float *seen = pick_pixels(image, seen_width_px, seen_height_px, background);
    if (!seen) return VW_ERROR_MEMORY;
    struct vw_oiio_result small = vw_oiio_resize(seen, seen_width_px, seen_height_px, small_width_px, small_height_px);
    free(seen);
    if (small.status) return vw_fail(small.status, "thumbnail: %s", small.message);
    drop_alpha(small.data, (size_t)small_width_px * small_height_px);
    struct vw_oiio_result file = vw_oiio_encode("thumbnail.webp", small_width_px, small_height_px, 3, true, "webp:70", small.data);
    free(small.data);
    if (file.status) return vw_fail(file.status, "thumbnail: %s", file.message);
    *data = file.data;
    *size_bytes = file.size_bytes;
    return VW_OK;
}
