#include "run/outputs/reconstruction.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/json.h"
#include "base/statistics.h"
#include "image/image.h"
#include "run/session.h"
#include "scene/view_distance.h"

// ---- Trivial predictions -------------------------------------------------------------------------------------------

// A PSNR that only a copy of the photo has: JPEG files of one picture at a quality of 90 differ by less.
static const double TWIN_DB = 40;

// Computes the PSNR of the photo's own mean colour.
static double mean_colour_db(const struct vw_whole_view *whole) {
    double squared_error = 0;
    uint64_t count = 0, pixels = (uint64_t)whole->width_px * whole->height_px;
    for (int c = 0; c < 3; c++) {
        double sum = 0, squares = 0;
        for (uint64_t i = count = 0; i < pixels; i++) {
            if (!whole->counts[i]) continue;
            double value = whole->photo[3 * i + (uint64_t)c];
            sum += value, squares += value * value, count++;
        }
        squared_error += squares - sum * sum / (double)count;
    }
    return vw_psnr_db(squared_error / 3 / (double)count);
}

// Computes the PSNR of another photo's pixels at the same places, which are scaled if its size is another.
static double other_photo_db(const struct vw_scene *scene, const struct vw_whole_view *whole, uint32_t other) {
    const struct vw_image *image = &scene->views[other].image;
    double squared_error = 0;
    uint64_t count = 0, pixels = (uint64_t)whole->width_px * whole->height_px;
    for (uint64_t i = 0; i < pixels; i++) {
        uint64_t x = i % whole->width_px, y = i / whole->width_px;
        float rgba[4];
        if (!whole->counts[i]) continue;
        vw_image_pixel(image, (uint32_t)(x * image->width_px / whole->width_px),
                       (uint32_t)(y * image->height_px / whole->height_px), rgba);
        for (uint64_t c = 0; c < 3; c++) {
            double error = rgba[3] * rgba[c] + (1 - rgba[3]) * scene->background[c] - whole->photo[3 * i + c];
            squared_error += error * error;
        }
        count++;
    }
    return vw_psnr_db(squared_error / 3 / (double)count);
}

// ---- Measuring -----------------------------------------------------------------------------------------------------

enum number { PSNR, SSIM, MEAN_COLOUR, NEAREST_PHOTO, NUMBER_COUNT };

struct measuring {
    const struct vw_reconstruction_params *params;
    const struct vw_scene *sized;       // the scene at the size that is measured
    struct vw_view_distance *distances; // one per photo that may be measured, in scene order
    uint32_t count;
    double numbers[NUMBER_COUNT][VW_RECONSTRUCTION_VIEWS_MAX];
    uint32_t ssim_count; // photos that have an SSIM: some window of it has no hidden pixel
    struct vw_reconstruction made;
};

uint32_t vw_reconstruction_downscale(const struct vw_scene *scene, uint32_t trained_downscale) {
    uint32_t longest_px = 0;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        const struct vw_camera *camera = &scene->views[v].camera;
        uint32_t longer_px = camera->width_px > camera->height_px ? camera->width_px : camera->height_px;
        if (scene->views[v].split != VW_SPLIT_EXCLUDED && longer_px > longest_px) longest_px = longer_px;
    }
    uint64_t stored_px = (uint64_t)longest_px * trained_downscale;
    return (uint32_t)((stored_px + VW_RECONSTRUCTION_SIDE_PX - 1) / VW_RECONSTRUCTION_SIDE_PX);
}

double vw_reconstruction_rays(const struct vw_scene *scene, uint32_t trained_downscale) {
    double pixels = 0, larger = (double)trained_downscale / vw_reconstruction_downscale(scene, trained_downscale);
    for (uint32_t v = 0; v < scene->view_count; v++) {
        const struct vw_camera *camera = &scene->views[v].camera;
        pixels = fmax(pixels, larger * larger * camera->width_px * camera->height_px);
    }
    uint32_t tests = scene->split_count[VW_SPLIT_TEST], views = tests ? tests : scene->split_count[VW_SPLIT_VAL];
    return pixels * (views < VW_RECONSTRUCTION_VIEWS_MAX ? views : VW_RECONSTRUCTION_VIEWS_MAX);
}

// Keeps the numbers of a photo, unless it is a twin.
static void keep(struct measuring *measuring, const struct vw_view_distance *distance,
                 const struct vw_whole_view *whole, double ssim) {
    const struct vw_camera *trained = &measuring->params->scene->views[distance->view].camera;
    double nearest_db = other_photo_db(measuring->sized, whole, distance->nearest);
    struct vw_reconstruction *made = &measuring->made;
    if (nearest_db >= TWIN_DB) return;
    measuring->numbers[PSNR][made->view_count] = vw_psnr_db(whole->error.mse);
    measuring->numbers[MEAN_COLOUR][made->view_count] = mean_colour_db(whole);
    measuring->numbers[NEAREST_PHOTO][made->view_count++] = nearest_db;
    if (isfinite(ssim)) measuring->numbers[SSIM][measuring->ssim_count++] = ssim;
    made->trained_px[0] = trained->width_px, made->trained_px[1] = trained->height_px;
    made->measured_px[0] = whole->width_px, made->measured_px[1] = whole->height_px;
}

static enum vw_status measure_view(struct measuring *measuring, const struct vw_view_distance *distance) {
    struct vw_whole_view whole;
    double ssim = NAN;
    enum vw_status status =
        vw_trainer_measure_whole(measuring->params->trainer, measuring->sized, distance->view, &whole);
    if (status) return status;
    status = vw_scene_decode(measuring->sized, &distance->nearest, 1);
    if (!status) status = vw_ssim(whole.rendered, whole.photo, whole.counts, whole.width_px, whole.height_px, &ssim);
    if (!status && isfinite(whole.error.mse)) keep(measuring, distance, &whole, ssim);
    vw_whole_view_free(&whole);
    return status;
}

static enum vw_status measure(struct measuring *measuring) {
    uint32_t views = measuring->count < VW_RECONSTRUCTION_VIEWS_MAX ? measuring->count : VW_RECONSTRUCTION_VIEWS_MAX;
    struct vw_reconstruction *made = &measuring->made;
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < views; i++)
        status = measure_view(measuring, &measuring->distances[(uint64_t)i * measuring->count / views]);
    made->psnr_db = vw_median(measuring->numbers[PSNR], made->view_count);
    made->ssim = vw_median(measuring->numbers[SSIM], measuring->ssim_count);
    made->mean_colour_db = vw_median(measuring->numbers[MEAN_COLOUR], made->view_count);
    made->nearest_photo_db = vw_median(measuring->numbers[NEAREST_PHOTO], made->view_count);
    return status;
}

// Refuses a scene that is no longer the one trained on.
static enum vw_status check_same(const struct vw_scene *trained, const struct vw_scene *sized) {
    bool same = trained->view_count == sized->view_count;
    for (uint32_t v = 0; same && v < trained->view_count; v++)
        same = strcmp(trained->views[v].name, sized->views[v].name) == 0 &&
               trained->views[v].split == sized->views[v].split;
    return same ? VW_OK
                : vw_fail(VW_ERROR_INPUT,
                          "%s: its photos have changed meanwhile; restore them, and run the same command again, with "
                          "--resume if it has trained",
                          trained->path);
}

enum vw_status vw_reconstruction_open_scene(const struct vw_reconstruction_params *params, struct vw_scene **sized) {
    struct vw_scene_params options;
    json_t *texts = NULL;
    enum vw_status status = vw_scene_options_from_json(params->scene_options_json, &texts, &options);
    if (status) return status;
    uint32_t downscale = vw_reconstruction_downscale(params->scene, options.downscale);
    if (downscale != options.downscale) {
        options.path = params->scene->path;
        options.gpu = params->gpu;
        options.downscale = downscale;
        status = vw_scene_open(&options, sized);
        if (!status) status = check_same(params->scene, *sized);
    }
    json_decref(texts);
    return status;
}

enum vw_status vw_reconstruction_measure(const struct vw_reconstruction_params *params,
                                         struct vw_reconstruction *reconstruction) {
    struct vw_scene *opened = NULL;
    struct measuring measuring = {.params = params, .sized = params->scene, .made = vw_reconstruction_unknown};
    measuring.made.of_test = params->scene->split_count[VW_SPLIT_TEST] > 0;
    enum vw_split split = measuring.made.of_test ? VW_SPLIT_TEST : VW_SPLIT_VAL;
    enum vw_status status = vw_scene_view_distances(params->scene, split, &measuring.distances, &measuring.count);
    if (!status && measuring.count) status = vw_reconstruction_open_scene(params, &opened);
    if (opened) measuring.sized = opened;
    if (!status) status = measure(&measuring);
    free(measuring.distances);
    vw_scene_close(&opened);
    if (!status) *reconstruction = measuring.made;
    return status;
}
