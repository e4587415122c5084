#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "base/memory.h"
#include "image/image.h"

enum { WINDOW = VW_SSIM_WINDOW_PX };
static const double SIGMA_PX = 1.5;
static const double C1 = 0.01 * 0.01, C2 = 0.03 * 0.03;

// The moments of a window: weighted means of the values, their squares and their product.
struct moments {
    double a, b, aa, bb, ab;
};

struct images {
    const float *a, *b;
    const uint8_t *usable;
    uint32_t width_px, height_px, columns; // columns: positions of a window along a row
};

// Weights along one axis, with sum 1. The window's weights are their products.
static void make_weights(double weights[WINDOW]) {
    double sum = 0;
    for (int i = 0; i < WINDOW; i++) {
        double distance = (i - WINDOW / 2) / SIGMA_PX;
        sum += weights[i] = exp(-distance * distance / 2);
    }
    for (int i = 0; i < WINDOW; i++) weights[i] /= sum;
}

static void add(struct moments *sum, double weight, const struct moments *moments) {
    sum->a += weight * moments->a;
    sum->b += weight * moments->b;
    sum->aa += weight * moments->aa;
    sum->bb += weight * moments->bb;
    sum->ab += weight * moments->ab;
}

// Computes the moments along a row, for every position of a window.
static void filter_row(const struct images *images, uint32_t y_px, uint32_t channel, const double weights[WINDOW],
                       struct moments *row) {
    for (uint32_t x = 0; x < images->columns; x++) {
        row[x] = (struct moments){0};
        for (uint32_t i = 0; i < WINDOW; i++) {
            size_t value = 3 * ((size_t)y_px * images->width_px + x + i) + channel;
            double a = images->a[value], b = images->b[value];
            add(&row[x], weights[i], &(struct moments){a, b, a * a, b * b, a * b});
        }
    }
}

static double evaluate(const struct moments *mean) {
    double variances = mean->aa - mean->a * mean->a + mean->bb - mean->b * mean->b,
           covariance = mean->ab - mean->a * mean->b;
    double squares = mean->a * mean->a + mean->b * mean->b;
    return (2 * mean->a * mean->b + C1) * (2 * covariance + C2) / ((squares + C1) * (variances + C2));
}

// Counts, for every position of a window along a row, the consecutive rows up to this one whose pixels there are all
// usable.
static void count_usable_rows(const struct images *images, uint32_t y_px, uint32_t *heights) {
    uint32_t run = 0;
    for (uint32_t x = 0; x < images->width_px; x++) {
        run = images->usable && !images->usable[(size_t)y_px * images->width_px + x] ? 0 : run + 1;
        if (x + 1 < WINDOW) continue;
        uint32_t *height = &heights[x + 1 - WINDOW];
        *height = run >= WINDOW ? *height + 1 : 0;
    }
}

// Sums over one channel. `rows` contains the moments of the last rows, by row modulo WINDOW; `heights` is zero.
static void sum_channel(const struct images *images, uint32_t channel, struct moments *rows, uint32_t *heights,
                        double *sum, uint64_t *count) {
    double weights[WINDOW];
    make_weights(weights);
    for (uint32_t y = 0; y < images->height_px; y++) {
        filter_row(images, y, channel, weights, rows + (size_t)(y % WINDOW) * images->columns);
        count_usable_rows(images, y, heights);
        for (uint32_t x = 0; x < images->columns; x++) {
            if (heights[x] < WINDOW) continue;
            struct moments mean = {0};
            for (uint32_t i = 0; i < WINDOW; i++)
                add(&mean, weights[i], &rows[(size_t)((y + 1 + i) % WINDOW) * images->columns + x]);
            *sum += evaluate(&mean);
            ++*count;
        }
    }
}

enum vw_status vw_ssim(const float *a, const float *b, const uint8_t *usable, uint32_t width_px, uint32_t height_px,
                       double *ssim) {
    double sum = 0;
    uint64_t count = 0;
    *ssim = NAN;
    if (width_px < WINDOW || height_px < WINDOW) return VW_OK;
    const struct images images = {a, b, usable, width_px, height_px, width_px - WINDOW + 1};
    struct moments *rows = vw_allocate((size_t)WINDOW * images.columns, sizeof *rows);
    uint32_t *heights = vw_allocate(3 * (size_t)images.columns, sizeof *heights);
    enum vw_status status = rows && heights ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t channel = 0; !status && channel < 3; channel++)
        sum_channel(&images, channel, rows, heights + (size_t)channel * images.columns, &sum, &count);
    if (!status && count) *ssim = sum / (double)count;
    free(rows);
    free(heights);
    return status;
}
