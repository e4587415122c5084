// The plain-C reference of splats, in double: written from the mathematics, with whole matrices where the shaders have
// short forms. A splat is `columns * 4` doubles, column by column as in shaders/interface.h.
#ifndef VIEWWORTH_TESTS_REFERENCE_SPLATS_H
#define VIEWWORTH_TESTS_REFERENCE_SPLATS_H

#include <stdbool.h>
#include <stdint.h>

#include "interface.h"

enum { REFERENCE_SPLAT_NUMBERS = 4 * 19 }; // numbers of a splat of degree 3

struct reference_splat_view {
    double axes[3][3], eye[3]; // right, down, ahead
    double focal[2], middle[2];
    double slopes[2][2];    // least, most x / z and y / z at which the map is the centre's own
    double reach;           // most of their length that is seen
    bool distorts, fisheye; // the lens
    double k[6], p[2];
    uint32_t degree;
};
struct reference_splat_view reference_splat_view_of(const struct vw_gpu_camera *camera,
                                                    const struct vw_splat_view *view,
                                                    const struct vw_splat_specialization *s, uint32_t degree);

struct reference_splat_shape {
    bool shown;
    double centre[2], covariance[3], conic[3], depth; // xx, xy, yy
    double opacity;
    double rgb[3];
};
void reference_splat_project(const struct reference_splat_view *view, const double *splat,
                             struct reference_splat_shape *shape);

// Decisions about a splat at a pixel, which finite differences hold fixed.
enum reference_splat_fate { REFERENCE_SPLAT_SKIPPED, REFERENCE_SPLAT_BLENDED, REFERENCE_SPLAT_CAPPED };

// Blends shapes, in their order, at a pixel. `fates` (one per shape) is filled in, or followed if `held`.
void reference_splat_pixel(const struct reference_splat_shape *shapes, const uint32_t *order, uint32_t count, double x,
                           double y, bool held, uint8_t *fates, double colour[3], double *left);

// Adds the sums of a pair over one pixel (struct vw_splat_seen, blend_tiles_back.comp), with what is left before the
// splat, the colours times slopes that are still to come after it, and the slopes.
struct reference_splat_sums {
    double q, qx, qy, qxx, qxy, qyy, rgb[3];
};
void reference_splat_pixel_back(const struct reference_splat_shape *shapes, const uint32_t *order, uint32_t count,
                                double x, double y, const uint8_t *fates, const double slope[4],
                                struct reference_splat_sums *sums);

// Computes 1 - SSIM of one channel for the window about each pixel of a square, times the pixel's weight; returns the
// sum of them. A window is a Gaussian of 11 x 11 pixels over those of the square that count.
struct reference_splat_square {
    double weight[VW_SPLAT_SQUARE * VW_SPLAT_SQUARE], seen[VW_SPLAT_SQUARE * VW_SPLAT_SQUARE],
        photo[VW_SPLAT_SQUARE * VW_SPLAT_SQUARE];
};
double reference_splat_windows(const struct reference_splat_square *square,
                               double losses[VW_SPLAT_SQUARE * VW_SPLAT_SQUARE]);

#endif
