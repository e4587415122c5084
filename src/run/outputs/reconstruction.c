#include "run/outputs/reconstruction.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/statistics.h"
#include "image/image.h"
#include "scene/view_distance.h"

// ---- Trivial predictions -------------------------------------------------------------------------------------------

// Computes the PSNR of the window's own mean colour.
static double mean_colour_db(const struct vw_whole_view *window) {
    double squared_error = 0;
    uint64_t count = 0, pixels = (uint64_t)window->width_px * window->height_px;
    for (int c = 0; c < 3; c++) {
        double sum = 0, squares = 0;
        for (uint64_t i = count = 0; i < pixels; i++) {
            if (!window->counts[i]) continue;
            double value = window->photo[3 * i + (uint64_t)c];
            sum += value, squares += value * value, count++;
        }
        squared_error += squares - sum * sum / (double)count;
    }
    return vw_psnr_db(squared_error / 3 / (double)count);
}

// Computes the PSNR of another photo's pixels at the same places, which are scaled if its size is another.
static double other_photo_db(const struct vw_scene *scene, const struct vw_whole_view *window, uint32_t view,
                             uint32_t other) {
    const struct vw_image *own = &scene->views[view].image, *image = &scene->views[other].image;
    double squared_error = 0;
    uint64_t count = 0, pixels = (uint64_t)window->width_px * window->height_px;
    for (uint64_t i = 0; i < pixels; i++) {
        uint64_t x = window->left_px + i % window->width_px, y = window->top_px + i / window->width_px;
        float rgba[4];
        if (!window->counts[i]) continue;
        vw_image_pixel(image, (uint32_t)(x * image->width_px / own->width_px),
                       (uint32_t)(y * image->height_px / own->height_px), rgba);
        for (uint64_t c = 0; c < 3; c++) {
            double error = rgba[3] * rgba[c] + (1 - rgba[3]) * scene->background[c] - window->photo[3 * i + c];
            squared_error += error * error;
        }
        count++;
    }
    return vw_psnr_db(squared_error / 3 / (double)count);
}

// ---- Measuring -----------------------------------------------------------------------------------------------------

struct measuring {
    const struct vw_reconstruction_params *params;
    struct vw_view_distance *distances; // one per validation photo, in scene order
    uint32_t count;
    struct vw_reconstruction sums; // view_count: photos whose middle has a usable pixel
    uint32_t ssim_count;           // photos with an SSIM too: some window of it has no hidden pixel
};

// Returns the side of the windows: as large as the rays allow.
static uint32_t choose_side(const struct measuring *measuring, uint32_t views) {
    double side = floor(sqrt(measuring->params->rays / views));
    return side < VW_SSIM_WINDOW_PX ? VW_SSIM_WINDOW_PX : side > UINT16_MAX ? UINT16_MAX : (uint32_t)side;
}

static enum vw_status measure_view(struct measuring *measuring, const struct vw_view_distance *distance,
                                   uint32_t side_px) {
    const struct vw_scene *scene = measuring->params->scene;
    struct vw_reconstruction *sums = &measuring->sums;
    struct vw_whole_view window;
    double ssim = NAN;
    enum vw_status status = vw_trainer_measure_whole(measuring->params->trainer, distance->view, side_px, &window);
    if (status) return status;
    status = vw_scene_decode(scene, &distance->nearest, 1);
    if (!status)
        status = vw_ssim(window.rendered, window.photo, window.counts, window.width_px, window.height_px, &ssim);
    if (!status && isfinite(window.error.mse)) {
        sums->view_count++;
        measuring->ssim_count += isfinite(ssim);
        sums->psnr_db += vw_psnr_db(window.error.mse);
        sums->ssim += isfinite(ssim) ? ssim : 0;
        sums->mean_colour_db += mean_colour_db(&window);
        sums->nearest_photo_db += other_photo_db(scene, &window, distance->view, distance->nearest);
        sums->pixel_count += (uint64_t)window.width_px * window.height_px;
    }
    vw_whole_view_free(&window);
    return status;
}

static enum vw_status measure(struct measuring *measuring) {
    uint32_t views = measuring->count < VW_RECONSTRUCTION_VIEWS_MAX ? measuring->count : VW_RECONSTRUCTION_VIEWS_MAX;
    struct vw_reconstruction *sums = &measuring->sums;
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < views; i++)
        status = measure_view(measuring, &measuring->distances[(uint64_t)i * measuring->count / views],
                              choose_side(measuring, views));
    sums->psnr_db /= sums->view_count; // NaN without a view
    sums->ssim /= measuring->ssim_count;
    sums->mean_colour_db /= sums->view_count;
    sums->nearest_photo_db /= sums->view_count;
    return status;
}

enum vw_status vw_reconstruction_measure(const struct vw_reconstruction_params *params,
                                         struct vw_reconstruction *reconstruction) {
    struct measuring measuring = {.params = params};
    enum vw_status status =
        vw_scene_view_distances(params->scene, VW_SPLIT_VAL, &measuring.distances, &measuring.count);
    if (!status) status = measure(&measuring);
    free(measuring.distances);
    if (!status) *reconstruction = measuring.sums;
    return status;
}
