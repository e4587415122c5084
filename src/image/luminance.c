#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "image/image.h"

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

static void read_row(const struct vw_image *image, const float background[3], uint32_t y_px, double *row) {
    for (uint32_t x = 0; x < image->width_px; x++) row[x] = vw_image_luminance(image, x, y_px, background);
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
        read_row(image, background, y, rows[2]);
        for (uint32_t x = 0; x < image->width_px; x++) {
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
