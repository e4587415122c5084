#include "lab/methods/photo_pixels.h"

enum { SEEN_PER_SIDE = 4 }; // pixels of a thumbnail's cell, along each axis

// Returns the position of the `place`-th of `count` evenly spread pixels along a side.
static uint32_t place_on(uint32_t side_px, uint32_t place, uint32_t count) {
    return (uint32_t)((2 * (uint64_t)place + 1) * side_px / (2 * (uint64_t)count));
}

static void make_thumbnail(const struct vw_scene *scene, const struct vw_image *image, float *thumbnail) {
    enum { COLUMNS = VW_THUMBNAIL_COLUMNS * SEEN_PER_SIDE, ROWS = VW_THUMBNAIL_ROWS * SEEN_PER_SIDE };
    for (uint32_t i = 0; i < VW_THUMBNAIL_VALUES; i++) thumbnail[i] = 0;
    for (uint32_t y = 0; y < ROWS; y++)
        for (uint32_t x = 0; x < COLUMNS; x++) {
            float rgba[4];
            float *cell = thumbnail + 3 * (y / SEEN_PER_SIDE * VW_THUMBNAIL_COLUMNS + x / SEEN_PER_SIDE);
            vw_image_pixel(image, place_on(image->width_px, x, COLUMNS), place_on(image->height_px, y, ROWS), rgba);
            for (int c = 0; c < 3; c++)
                cell[c] += (rgba[3] * rgba[c] + (1 - rgba[3]) * scene->background[c]) / (SEEN_PER_SIDE * SEEN_PER_SIDE);
        }
}

enum vw_status vw_photo_pixels_measure(const struct vw_scene *scene, uint32_t view, struct vw_photo_pixels *pixels) {
    const struct vw_image *image = &scene->views[view].image;
    make_thumbnail(scene, image, pixels->thumbnail);
    return vw_image_measure_luminance(image, scene->background, &pixels->luminance);
}
