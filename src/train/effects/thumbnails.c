#include "train/effects/thumbnails.h"

#include <math.h>

#include "image/image.h"

struct part { // a part of a side, in pixels
    double begin, end;
};

static struct part part_of(uint32_t index, double side_px) {
    return (struct part){index * side_px / THUMBNAIL_SIDE, (index + 1) * side_px / THUMBNAIL_SIDE};
}

// Returns how much of a pixel lies in a part.
static double overlap(const struct part *part, uint32_t at_px) {
    return fmin(part->end, at_px + 1.0) - fmax(part->begin, at_px);
}

// Adds one pixel times its area to the sum, where the pixel counts.
static void add_pixel(const struct vw_view *view, bool masks, uint32_t x_px, uint32_t y_px, double area,
                      double sum[4]) {
    float rgba[4];
    if (!(masks ? vw_view_keeps(view, x_px, y_px) : vw_view_can_use(view, x_px, y_px))) return;
    vw_image_pixel(&view->image, x_px, y_px, rgba);
    for (int c = 0; c < 3; c++) sum[c] += area * rgba[3] * (2.0 * rgba[c] - 1.0);
    sum[3] += area * rgba[3];
}

static vw_float4 mean_of(const struct vw_view *view, const struct vw_thumbnail_choice *choice,
                         const struct part *columns, const struct part *rows) {
    double sum[4] = {0}, area = (columns->end - columns->begin) * (rows->end - rows->begin);
    for (uint32_t y = (uint32_t)rows->begin; y < rows->end && y < view->image.height_px; y++)
        for (uint32_t x = (uint32_t)columns->begin; x < columns->end && x < choice->columns.end; x++)
            add_pixel(view, choice->masks, x, y, overlap(columns, x) * overlap(rows, y), sum);
    return (vw_float4){(float)(sum[0] / area), (float)(sum[1] / area), (float)(sum[2] / area), (float)(sum[3] / area)};
}

void vw_thumbnail_make(const struct vw_view *view, const struct vw_thumbnail_choice *choice, vw_float4 *thumbnail) {
    uint32_t first = choice->columns.begin;
    for (uint32_t i = 0; i < THUMBNAIL_PIXELS; i++) {
        struct part columns = part_of(i % THUMBNAIL_SIDE, choice->columns.end - first),
                    rows = part_of(i / THUMBNAIL_SIDE, view->image.height_px);
        columns.begin += first;
        columns.end += first;
        thumbnail[i] = mean_of(view, choice, &columns, &rows);
    }
}
