#include "run/outputs/photo_reasons.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/statistics.h"

// Chosen on scenes/courtyard.json and on drawn recipes, whose defects are known. Between sound and corrupted photos of
// these lie gaps, in which the limits are.
#define BRIGHT 1.5          // times as bright as the median photo, or as dark
#define BLURRED 0.5         // share of the median sharpness: sound photos had 0.66 and more, blurred ones 0.15 and less
#define NOISY 2.5           // times the median noise: sound photos had 1.5 and less, noisy ones 2.9 and more
#define OUTLIER_SPREADS 3.0 // in addition, so that nothing stands out among photos of many kinds
#define FITS_ELSEWHERE 0.7  // share of the squared error after moving: sound photos had 0.72 and more
#define REGION_ERROR 0.7    // share of the squared error in one region,
#define REGION_AREA 0.2     // which has this share of the pixels: some sound photos of coarse runs have it, but fit
#define ERROR_LEAST 0.01    // squared error of a pixel of a region,
#define TIMES_MEDIAN 2      // and beside the photo's median
enum { HEIGHT_PX = 36 };
enum { MOVES_PER_SIDE = 4 }; // renders are moved by up to a quarter of a side
enum { SMOOTH_PX = 2 };      // half a window, for an occluder whose pattern partly has the colours of the photo

// ---- Pixels --------------------------------------------------------------------------------------------------------

// Replaces values by their logarithms' distance from the median, which `spread` is that of. Unknown values stay NaN.
static void centre(double *values, uint32_t count, double *scratch, double *spread) {
    uint32_t known = 0;
    for (uint32_t i = 0; i < count; i++) {
        values[i] = log(values[i]);
        if (isfinite(values[i])) scratch[known++] = values[i];
    }
    double median = vw_median(scratch, known);
    *spread = vw_robust_spread(scratch, known);
    for (uint32_t i = 0; i < count; i++) values[i] -= median;
}

enum vw_status vw_photo_reasons_of_luminance(const struct vw_luminance *measured, uint32_t count,
                                             const char **reasons) {
    double *sharpness = vw_allocate(count, 3 * sizeof *sharpness), *noise = sharpness + count, spread[2];
    if (!sharpness) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < count; i++) { // divided by the contrast, so that dim light is neither blur nor noise
        sharpness[i] = sqrt(measured[i].sharpness) / measured[i].contrast;
        noise[i] = measured[i].noise / measured[i].contrast;
    }
    centre(sharpness, count, noise + count, &spread[0]);
    centre(noise, count, noise + count, &spread[1]);
    for (uint32_t i = 0; i < count; i++) {
        if (sharpness[i] < fmin(log(BLURRED), -OUTLIER_SPREADS * spread[0])) reasons[i] = "blur";
        else if (noise[i] > fmax(log(NOISY), OUTLIER_SPREADS * spread[1])) reasons[i] = "noise";
    }
    free(sharpness);
    return VW_OK;
}

// ---- Renders -------------------------------------------------------------------------------------------------------

static double squared_error(const struct vw_panes *panes, uint32_t photo, uint32_t render) {
    double sum = 0;
    for (uint32_t c = 0; c < 3; c++) {
        double difference = panes->photo[3 * photo + c] - panes->render[3 * render + c];
        sum += difference * difference;
    }
    return sum / 3;
}

// Returns the error of the moved render, divided by that of the render in place at the same pixels of the photo.
static double error_of_moved(const struct vw_panes *panes, int right, int down) {
    double in_place = 0, moved = 0;
    int width = (int)panes->size_px[0], height = (int)panes->size_px[1];
    for (int y = down > 0 ? 0 : -down; y < height && y + down < height; y++)
        for (int x = right > 0 ? 0 : -right; x < width && x + right < width; x++) {
            uint32_t photo = (uint32_t)(y * width + x), render = (uint32_t)((y + down) * width + x + right);
            if (!panes->counts[photo] || !panes->counts[render]) continue;
            in_place += squared_error(panes, photo, photo);
            moved += squared_error(panes, photo, render);
        }
    return in_place > 0 ? moved / in_place : 1;
}

static bool fits_elsewhere(const struct vw_panes *panes) {
    int right = (int)panes->size_px[0] / MOVES_PER_SIDE, down = (int)panes->size_px[1] / MOVES_PER_SIDE;
    for (int y = -down; y <= down; y++)
        for (int x = -right; x <= right; x++)
            if (error_of_moved(panes, x, y) < FITS_ELSEWHERE) return true;
    return false;
}

struct region {
    double *errors, limit; // by pixel; 0 once it is part of a region
    uint32_t *open, open_count;
    double error;
    uint32_t pixels;
};

static void add_pixel(struct region *region, uint32_t pixel) {
    if (region->errors[pixel] <= region->limit) return;
    region->error += region->errors[pixel];
    region->errors[pixel] = 0;
    region->pixels++;
    region->open[region->open_count++] = pixel;
}

static void fill(struct region *region, const uint32_t size_px[2], uint32_t start) {
    region->error = 0, region->pixels = 0;
    add_pixel(region, start);
    while (region->open_count) {
        uint32_t pixel = region->open[--region->open_count], x = pixel % size_px[0], y = pixel / size_px[0];
        if (x) add_pixel(region, pixel - 1);
        if (x + 1 < size_px[0]) add_pixel(region, pixel + 1);
        if (y) add_pixel(region, pixel - size_px[0]);
        if (y + 1 < size_px[1]) add_pixel(region, pixel + size_px[0]);
    }
}

// Returns the mean squared error around a pixel; 0 for a pixel that does not count.
static double smooth_error(const struct vw_panes *panes, uint32_t pixel) {
    double sum = 0, count = 0;
    int width = (int)panes->size_px[0], height = (int)panes->size_px[1], x = (int)pixel % width, y = (int)pixel / width;
    for (int v = y - SMOOTH_PX; v <= y + SMOOTH_PX; v++)
        for (int u = x - SMOOTH_PX; u <= x + SMOOTH_PX; u++) {
            if (u < 0 || v < 0 || u >= width || v >= height || !panes->counts[v * width + u]) continue;
            sum += squared_error(panes, (uint32_t)(v * width + u), (uint32_t)(v * width + u));
            count++;
        }
    return panes->counts[pixel] ? sum / count : 0;
}

static bool has_region(const struct vw_panes *panes, struct region *region, double *scratch) {
    double total = 0;
    uint32_t pixels = panes->size_px[0] * panes->size_px[1];
    for (uint32_t i = 0; i < pixels; i++) {
        scratch[i] = region->errors[i] = smooth_error(panes, i);
        total += region->errors[i];
    }
    region->limit = fmax(TIMES_MEDIAN * vw_median(scratch, pixels), ERROR_LEAST);
    for (uint32_t i = 0; i < pixels; i++) {
        fill(region, panes->size_px, i);
        if (region->error >= REGION_ERROR * total && region->pixels >= REGION_AREA * pixels) return true;
    }
    return false;
}

enum vw_status vw_photo_reason_of_panes(const struct vw_panes *panes, const char **reason) {
    size_t pixels = (size_t)panes->size_px[0] * panes->size_px[1];
    double *errors = vw_allocate(pixels, 2 * sizeof *errors);
    struct region region = {.errors = errors, .open = vw_allocate(pixels, sizeof *region.open)};
    bool room = errors && region.open;
    if (room && fits_elsewhere(panes)) *reason = "pose";
    else if (room && has_region(panes, &region, errors + pixels)) *reason = "occluder";
    free(errors);
    free(region.open);
    return room ? VW_OK : VW_ERROR_MEMORY;
}

// ---- All photos ----------------------------------------------------------------------------------------------------

struct finding {
    const struct vw_residuals_params *params;
    uint32_t *views, count; // train photos
    const char **found;     // by train photo
};

static enum vw_status find_by_pixels(const struct finding *finding) {
    const struct vw_scene *scene = finding->params->panes.scene;
    const struct vw_exposure *exposures = NULL;
    struct vw_luminance *measured = vw_allocate(finding->count, sizeof *measured);
    enum vw_status status = measured ? vw_scene_decode(scene, finding->views, finding->count) : VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < finding->count && !status; i++)
        status = vw_image_measure_luminance(&scene->views[finding->views[i]].image, scene->background, &measured[i]);
    if (!status) status = vw_photo_reasons_of_luminance(measured, finding->count, finding->found);
    if (!status && scene->points_tell_exposures) status = vw_scene_estimate_exposures(scene, &exposures);
    for (uint32_t i = 0; i < finding->count && !status && exposures; i++) {
        double brightness = vw_exposure_brightness(&exposures[finding->views[i]]);
        if (brightness > BRIGHT || brightness < 1 / BRIGHT) finding->found[i] = "exposure";
    }
    free(measured);
    return status;
}

// Renders none of the photos whose pixels say enough; an occluder with a fine pattern is not noise.
static enum vw_status find_by_renders(const struct finding *finding) {
    const struct vw_residuals_params *params = finding->params;
    struct vw_ordered *ordered = vw_allocate(finding->count, sizeof *ordered);
    double *qualities = vw_allocate(finding->count, sizeof *qualities);
    enum vw_status status = ordered && qualities ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < finding->count && !status; i++)
        qualities[i] = vw_residuals_quality(params->scoring, finding->views[i]);
    if (!status) vw_order(qualities, finding->count, ordered);
    double left = vw_residuals_rays(params->scoring, params->config) / 2;
    for (uint32_t i = 0; i < finding->count && !status && left > 0; i++) {
        const char **reason = &finding->found[ordered[i].place];
        struct vw_panes panes = {0};
        if (*reason && strcmp(*reason, "noise") != 0) continue;
        status = vw_panes_make(&params->panes, finding->views[ordered[i].place], HEIGHT_PX, &panes);
        if (!status) status = vw_photo_reason_of_panes(&panes, reason);
        left -= (double)panes.size_px[0] * panes.size_px[1];
        vw_panes_free(&panes);
    }
    free(ordered);
    free(qualities);
    return status;
}

enum vw_status vw_photo_reasons_find(const struct vw_residuals_params *params, const char **reasons) {
    struct finding finding = {.params = params};
    enum vw_status status = vw_scene_list_views(params->panes.scene, VW_SPLIT_TRAIN, &finding.views, &finding.count);
    finding.found = vw_allocate(finding.count, sizeof *finding.found);
    if (!status && !finding.found) status = VW_ERROR_MEMORY;
    if (!status) status = find_by_pixels(&finding);
    if (!status) status = find_by_renders(&finding);
    for (uint32_t i = 0; i < finding.count && !status; i++) reasons[finding.views[i]] = finding.found[i];
    free(finding.views);
    free(finding.found);
    return status;
}
