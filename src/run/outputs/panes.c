#include "run/outputs/panes.h"

#include <stdlib.h>

#include "base/memory.h"
#include "image/image.h"

enum { WIDEST = 4 };

void vw_panes_choose_size(const struct vw_image *image, uint32_t height_px, uint32_t size_px[2]) {
    size_px[1] = image->height_px < height_px ? image->height_px : height_px;
    uint64_t width_px = (uint64_t)image->width_px * size_px[1] / image->height_px;
    size_px[0] = width_px < 1 ? 1 : width_px > WIDEST * size_px[1] ? WIDEST * size_px[1] : (uint32_t)width_px;
}

static void read_photo(const struct vw_panes_params *params, uint32_t view, struct vw_panes *panes) {
    const struct vw_view *of_view = &params->scene->views[view];
    const struct vw_image *image = &of_view->image;
    for (uint32_t y = 0, pixel = 0; y < panes->size_px[1]; y++)
        for (uint32_t x = 0; x < panes->size_px[0]; x++, pixel++) {
            uint32_t column = (uint32_t)((2 * (uint64_t)x + 1) * image->width_px / (2 * (uint64_t)panes->size_px[0])),
                     row = (uint32_t)((2 * (uint64_t)y + 1) * image->height_px / (2 * (uint64_t)panes->size_px[1]));
            float rgba[4];
            vw_image_pixel(image, column, row, rgba);
            float alpha = params->on_background ? rgba[3] : 1;
            for (int c = 0; c < 3; c++)
                panes->photo[3 * pixel + c] = alpha * rgba[c] + (1 - alpha) * params->scene->background[c];
            panes->counts[pixel] = vw_view_keeps(of_view, column, row);
        }
}

// Fits the gain and bias of a channel that bring the render nearest to the photo (least squares).
static void fit_channel(struct vw_panes *panes, int channel) {
    double n = 0, sum_r = 0, sum_p = 0, sum_rr = 0, sum_rp = 0;
    uint32_t pixels = panes->size_px[0] * panes->size_px[1];
    for (uint32_t i = 0; i < pixels; i++) {
        double r = panes->render[3 * i + channel], p = panes->photo[3 * i + channel];
        if (!panes->counts[i]) continue;
        n++, sum_r += r, sum_p += p, sum_rr += r * r, sum_rp += r * p;
    }
    double variance = n * sum_rr - sum_r * sum_r, gain = variance > 0 ? (n * sum_rp - sum_r * sum_p) / variance : 1;
    double bias = n > 0 ? (sum_p - gain * sum_r) / n : 0;
    for (uint32_t i = 0; i < pixels; i++)
        panes->render[3 * i + channel] = (float)(gain * panes->render[3 * i + channel] + bias);
}

enum vw_status vw_panes_make(const struct vw_panes_params *params, uint32_t view, uint32_t height_px,
                             struct vw_panes *panes) {
    vw_panes_choose_size(&params->scene->views[view].image, height_px, panes->size_px);
    size_t pixels = (size_t)panes->size_px[0] * panes->size_px[1];
    panes->photo = vw_allocate(pixels, 3 * sizeof *panes->photo);
    panes->counts = vw_allocate(pixels, 1);
    enum vw_status status = panes->photo && panes->counts
                                ? vw_trainer_render_small(params->trainer, view, panes->size_px, &panes->render)
                                : VW_ERROR_MEMORY;
    if (!status) read_photo(params, view, panes);
    for (int c = 0; c < 3 && !status && params->fitted; c++) fit_channel(panes, c);
    return status;
}

void vw_panes_free(struct vw_panes *panes) {
    free(panes->photo);
    free(panes->render);
    free(panes->counts);
    *panes = (struct vw_panes){0};
}
