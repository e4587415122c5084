// How near the field comes to whole views: the passes of validation, on all their usable pixels, through an evaluator of its own. The
// errors are summed in double on the host, in the order of the pixels.
#include <math.h>
#include <stdlib.h>

#include "appearance.h"
#include "pixels.h"
#include "trainer.h"
#include "viewworth/memory.h"
#include "viewworth/psnr.h"

enum { TILE_RAYS = 4096 };
static const double FIT_RIDGE = 0.1; // as in shaders/appearance.glsl

// The pixels of one view that are looked at, with what was rendered there.
struct seen_view {
    struct vw_pixel *pixels;   // first those to fit the view's exposure on, if any
    vw_float4 *rendered;       // rgb, transmittance
    struct vw_ray *rays;       // target_weight: what the photo shows, on the backdrop
    uint32_t fit_count, count; // pixels to fit on; all
};

static double channel_of(vw_float4 colour, int channel) { return channel == 0 ? colour.x : channel == 1 ? colour.y : colour.z; }

static enum vw_status render(struct vw_trainer *trainer, struct evaluator *evaluator, struct seen_view *seen) {
    enum vw_status status = VW_OK;
    if (!trainer->masks) pixels_unmask(trainer->scene, seen->pixels, seen->count);
    for (uint32_t first = 0; status == VW_OK && first < seen->count; first += TILE_RAYS) {
        uint32_t count = seen->count - first < TILE_RAYS ? seen->count - first : TILE_RAYS;
        status = evaluator_render(evaluator, seen->pixels + first, count, seen->rendered + first);
        if (status == VW_OK) status = vw_buffer_read(evaluator->rays, 0, seen->rays + first, count * sizeof *seen->rays);
    }
    return status;
}

// What shaders/fit_views.comp does for one channel, by the normal equations of its ridge regression: seen = (1 + gain) rendered + bias.
static void fit_channel(const struct seen_view *seen, int channel, double *gain, double *bias) {
    double rr = FIT_RIDGE, r = 0, n = FIT_RIDGE, rm = 0, m = 0;
    for (uint32_t i = 0; i < seen->fit_count; i++) {
        if (seen->rays[i].target_weight.w == 0.0f) continue;
        double rendered = channel_of(seen->rendered[i], channel);
        double missing = channel_of(seen->rays[i].target_weight, channel) - rendered;
        rr += rendered * rendered;
        r += rendered;
        n += 1;
        rm += rendered * missing;
        m += missing;
    }
    *gain = (rm * n - r * m) / (rr * n - r * r);
    *bias = (rr * m - r * rm) / (rr * n - r * r);
}

// False when no pixel counts.
static bool sum_errors(const struct seen_view *seen, bool fits, struct vw_view_error *error) {
    double squared = 0, absolute = 0, values = 0;
    for (int channel = 0; channel < 3; channel++) {
        double gain = 0, bias = 0;
        if (fits) fit_channel(seen, channel, &gain, &bias);
        for (uint32_t i = seen->fit_count; i < seen->count; i++) {
            if (seen->rays[i].target_weight.w == 0.0f) continue;
            double rendered = (1 + gain) * channel_of(seen->rendered[i], channel) + bias;
            double missing = rendered - channel_of(seen->rays[i].target_weight, channel);
            squared += missing * missing;
            absolute += fabs(missing);
            values++;
        }
    }
    *error = (struct vw_view_error){.mse = squared / values, .l1 = absolute / values};
    return values > 0;
}

static enum vw_status measure_view(struct vw_trainer *trainer, struct evaluator *evaluator, uint32_t view, uint32_t pixels_max,
                                   struct seen_view *seen, struct vw_view_error *error) {
    const struct vw_scene *scene = trainer->scene;
    bool fits = appearance_fits_views(&trainer->model);
    uint32_t fit_max = pixels_max < VIEW_FIT_RAYS_MAX ? pixels_max : VIEW_FIT_RAYS_MAX;
    struct pixel_columns left = view_fit_left_half(scene, view), right = view_fit_right_half(scene, view);
    seen->fit_count = fits ? pixels_stratify(scene, view, left, fit_max, seen->pixels) : 0;
    seen->count = seen->fit_count +
                  pixels_stratify(scene, view, fits ? right : pixels_all_columns(scene, view), pixels_max, seen->pixels + seen->fit_count);
    enum vw_status status = render(trainer, evaluator, seen);
    if (status == VW_OK && !sum_errors(seen, fits, error))
        status = vw_fail(VW_ERROR_INPUT, "%s: this view has no usable pixel to measure; leave it out of its list", scene->views[view].name);
    return status;
}

enum vw_status vw_trainer_measure_views(struct vw_trainer *trainer, const uint32_t *views, uint32_t view_count, uint32_t pixels_max,
                                        struct vw_view_error *errors) {
    size_t most = (size_t)pixels_max + (appearance_fits_views(&trainer->model) ? VIEW_FIT_RAYS_MAX : 0);
    struct evaluator evaluator = {0};
    struct seen_view seen = {.pixels = vw_allocate(most, sizeof *seen.pixels),
                             .rendered = vw_allocate(most, sizeof *seen.rendered),
                             .rays = vw_allocate(most, sizeof *seen.rays)};
    enum vw_status status = seen.pixels && seen.rendered && seen.rays ? VW_OK : VW_ERROR_MEMORY;
    if (status == VW_OK) status = evaluator_create(&trainer->field, most < TILE_RAYS ? (uint32_t)most : TILE_RAYS, &evaluator);
    for (uint32_t i = 0; status == VW_OK && i < view_count; i++)
        status = measure_view(trainer, &evaluator, views[i], pixels_max, &seen, &errors[i]);
    evaluator_destroy(&evaluator);
    free(seen.pixels);
    free(seen.rendered);
    free(seen.rays);
    return status;
}
