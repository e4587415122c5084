#include "image/image.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "base/memory.h"

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

// ---- Luminance -----------------------------------------------------------------------------------------------------

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

// Measures a photo. `room`: of three rows.
static void measure(const struct vw_image *image, const float background[3], double *room,
                    struct vw_luminance *luminance) {
    double *rows[3] = {room, room + image->width_px, room + 2 * (size_t)image->width_px};
    double sum = 0, squares = 0, pixel_count = (double)image->width_px * image->height_px;
    struct sums inner = {0};
    for (uint32_t y = 0; y < image->height_px; y++) {
        double *oldest = rows[0];
        rows[0] = rows[1];
        rows[1] = rows[2];
        rows[2] = oldest;
        for (uint32_t x = 0; x < image->width_px; x++) {
            rows[2][x] = vw_image_luminance(image, x, y, background);
            sum += rows[2][x];
            squares += rows[2][x] * rows[2][x];
        }
        if (y >= 2) add_row(rows, image->width_px, &inner);
    }
    double count = (double)inner.count;
    luminance->brightness = sum / pixel_count;
    luminance->contrast = sqrt(fmax(squares / pixel_count - pow(luminance->brightness, 2), 0));
    luminance->sharpness = inner.count ? inner.laplacian_squares / count - pow(inner.laplacian / count, 2) : 0;
    luminance->noise = inner.count ? sqrt(M_PI / 2) / 6 * inner.noise / count : 0;
}

enum vw_status vw_image_measure_luminance(const struct vw_image *image, const float background[3],
                                          struct vw_luminance *luminance) {
    double *room = vw_allocate(image->width_px, 3 * sizeof *room);
    if (!room) return VW_ERROR_MEMORY;
    measure(image, background, room, luminance);
    free(room);
    return VW_OK;
}
