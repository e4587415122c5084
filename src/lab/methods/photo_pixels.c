#include "lab/methods/photo_pixels.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "image/image.h"

enum { SEEN_PER_SIDE = 4 }; // pixels of a thumbnail's cell, along each axis

// Sums over the pixels that have all eight neighbours.
struct sums {
    double laplacian, laplacian_squares, noise;
    uint64_t count;
};

// Adds the inner pixels of a row. `rows`: three neighbouring rows of luminance.
static void add_row(double *const rows[3], uint32_t width_px, struct sums *sums) {
    for (uint32_t x = 1; x + 1 < width_px; x++, sums->count++) {
        double centre = rows[1][x], laplacian = rows[1][x - 1] + rows[1][x + 1] + rows[0][x] + rows[2][x] - 4 * centre;
        double diagonal = rows[0][x - 1] + rows[0][x + 1] + rows[2][x - 1] + rows[2][x + 1];
        sums->laplacian += laplacian;
        sums->laplacian_squares += laplacian * laplacian;
        sums->noise += fabs(diagonal - 2 * (laplacian + 4 * centre) + 4 * centre);
    }
}

static void read_row(const struct vw_scene *scene, const struct vw_image *image, uint32_t y_px, double *row) {
    for (uint32_t x = 0; x < image->width_px; x++) row[x] = vw_image_luminance(image, x, y_px, scene->background);
}

// Measures the luminance of a photo. `room`: of three rows.
static void measure_luminance(const struct vw_scene *scene, const struct vw_image *image, double *room,
                              struct vw_photo_pixels *pixels) {
    double *rows[3] = {room, room + image->width_px, room + 2 * (size_t)image->width_px};
    double sum = 0, squares = 0, pixel_count = (double)image->width_px * image->height_px;
    struct sums inner = {0};
    for (uint32_t y = 0; y < image->height_px; y++) {
        double *oldest = rows[0];
        rows[0] = rows[1];
        rows[1] = rows[2];
        rows[2] = oldest;
        read_row(scene, image, y, rows[2]);
        for (uint32_t x = 0; x < image->width_px; x++) {
            sum += rows[2][x];
            squares += rows[2][x] * rows[2][x];
        }
        if (y >= 2) add_row(rows, image->width_px, &inner);
    }
    double count = (double)inner.count;
    pixels->brightness = sum / pixel_count;
    pixels->contrast = sqrt(fmax(squares / pixel_count - pow(pixels->brightness, 2), 0));
    pixels->sharpness = inner.count ? inner.laplacian_squares / count - pow(inner.laplacian / count, 2) : 0;
    pixels->noise = inner.count ? sqrt(M_PI / 2) / 6 * inner.noise / count : 0;
}

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
    double *room = vw_allocate(image->width_px, 3 * sizeof *room);
    if (!room) return VW_ERROR_MEMORY;
    measure_luminance(scene, image, room, pixels);
    make_thumbnail(scene, image, pixels->thumbnail);
    free(room);
    return VW_OK;
}
