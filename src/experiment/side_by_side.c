#include "experiment/side_by_side.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "image/image.h"

struct strip {
    float *pixels; // owned; rgb
    uint32_t width_px, height_px, column_px;
};

static void copy_column(const struct vw_image *picture, uint32_t from_px, uint32_t column, struct strip *strip) {
    for (uint32_t y = 0; y < strip->height_px; y++)
        for (uint32_t x = 0; x < strip->column_px; x++) {
            float rgba[4];
            vw_image_pixel(picture, from_px + x, y, rgba);
            memcpy(strip->pixels + 3 * ((size_t)y * strip->width_px + (size_t)column * strip->column_px + x), rgba,
                   3 * sizeof *rgba);
        }
}

// Begins the strip; the first picture sets the size of all.
static enum vw_status begin(const struct vw_image *picture, uint32_t columns, struct strip *strip) {
    strip->column_px = picture->width_px / 2;
    strip->width_px = columns * strip->column_px;
    strip->height_px = picture->height_px;
    strip->pixels = vw_allocate((size_t)strip->width_px * strip->height_px, 3 * sizeof *strip->pixels);
    if (!strip->pixels) return VW_ERROR_MEMORY;
    copy_column(picture, 0, 0, strip);
    return VW_OK;
}

static enum vw_status add(const char *path, uint32_t place, uint32_t count, struct strip *strip) {
    struct vw_image picture = {0};
    enum vw_status status = vw_image_load(path, 1, &picture);
    if (!status && !place) status = begin(&picture, 1 + count, strip);
    if (!status && (picture.width_px != 2 * strip->column_px || picture.height_px != strip->height_px))
        status = vw_fail(VW_ERROR_INPUT,
                         "%s: has another size than the other lists' pictures; delete it, and it is made again", path);
    if (!status) copy_column(&picture, strip->column_px, 1 + place, strip);
    vw_image_clear(&picture);
    return status;
}

enum vw_status vw_side_by_side_write(const char *to, char *const *pictures, uint32_t count) {
    struct strip strip = {0};
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < count; i++) status = add(pictures[i], i, count, &strip);
    if (!status) status = vw_image_save(to, strip.width_px, strip.height_px, 3, strip.pixels);
    free(strip.pixels);
    return status;
}
