#include "train/validation/measure_views.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "train/effects/appearance_encoder.h"
#include "train/effects/effects.h"
#include "train/evaluator.h"
#include "train/pixels.h"
#include "train/validation/validation.h"

enum { TILE_RAYS = 4096 };

// The pixels of one view that are looked at, with what was rendered there.
struct seen_view {
    struct vw_pixel *pixels;   // first those to fit the view's exposure on, if any
    vw_float4 *rendered;       // rgb, transmittance
    vw_float4 *targets;        // the photo's colour there, on the backdrop, and the pixel's weight
    struct vw_ray *tile;       // scratch
    uint32_t fit_count, count; // pixels to fit on; all
    double gain[3],
        bias[3];      // by channel: the view is seen as (1 + gain) rendered + bias; 0 where validation fits nothing
    double plain_mse; // without these
};

static double channel_of(vw_float4 colour, int channel) {
    return channel == 0 ? colour.x : channel == 1 ? colour.y : colour.z;
}

static enum vw_status allocate(size_t count, struct seen_view *seen) {
    *seen = (struct seen_view){.pixels = vw_allocate(count, sizeof *seen->pixels),
                               .rendered = vw_allocate(count, sizeof *seen->rendered),
                               .targets = vw_allocate(count, sizeof *seen->targets),
                               .tile = vw_allocate(TILE_RAYS, sizeof *seen->tile)};
    return seen->pixels && seen->rendered && seen->targets && seen->tile ? VW_OK : VW_ERROR_MEMORY;
}

static void release(struct seen_view *seen) {
    free(seen->pixels);
    free(seen->rendered);
    free(seen->targets);
    free(seen->tile);
}

static enum vw_status render(struct vw_evaluator *evaluator, struct seen_view *seen) {
    enum vw_status status = VW_OK;
    for (uint32_t first = 0; !status && first < seen->count; first += TILE_RAYS) {
        uint32_t count = seen->count - first < TILE_RAYS ? seen->count - first : TILE_RAYS;
        status = vw_evaluator_render(evaluator, seen->pixels + first, count, seen->rendered + first);
        if (!status) status = vw_buffer_read(evaluator->rays, 0, seen->tile, count * sizeof *seen->tile);
        for (uint32_t i = 0; !status && i < count; i++) seen->targets[first + i] = seen->tile[i].target_weight;
    }
    return status;
}

// Fits one channel as shaders/effects/appearance/fit_views.comp does, with the normal equations of its ridge
// regression: seen = (1
// + gain) rendered + bias. Without pixels to fit on, both are 0.
static void fit_channel(struct seen_view *seen, int channel) {
    double rr = FIT_RIDGE, r = 0, n = FIT_RIDGE, rm = 0, m = 0;
    for (uint32_t i = 0; i < seen->fit_count; i++) {
        if (seen->targets[i].w == 0.0f) continue;
        double rendered = channel_of(seen->rendered[i], channel);
        double missing = channel_of(seen->targets[i], channel) - rendered;
        rr += rendered * rendered;
        r += rendered;
        n += 1;
        rm += rendered * missing;
        m += missing;
    }
    seen->gain[channel] = (rm * n - r * m) / (rr * n - r * r);
    seen->bias[channel] = (rr * m - r * rm) / (rr * n - r * r);
}

static double seen_channel(const struct seen_view *seen, uint32_t pixel, int channel) {
    return (1 + seen->gain[channel]) * channel_of(seen->rendered[pixel], channel) + seen->bias[channel];
}

// Returns false when no pixel counts.
static bool sum_errors(struct seen_view *seen, struct vw_view_error *error) {
    double squared = 0, absolute = 0, values = 0, plain = 0;
    for (int channel = 0; channel < 3; channel++) {
        fit_channel(seen, channel);
        for (uint32_t i = seen->fit_count; i < seen->count; i++) {
            if (seen->targets[i].w == 0.0f) continue;
            double target = channel_of(seen->targets[i], channel), missing = seen_channel(seen, i, channel) - target;
            squared += missing * missing;
            plain += pow(channel_of(seen->rendered[i], channel) - target, 2);
            absolute += fabs(missing);
            values++;
        }
    }
    *error = (struct vw_view_error){.mse = squared / values, .l1 = absolute / values};
    seen->plain_mse = plain / values;
    return values > 0;
}

// Renders and measures the pixels that were chosen, those that weigh nothing left out.
static enum vw_status see(const struct vw_measured_field *measured, struct vw_evaluator *evaluator, uint32_t view,
                          bool allows_blank, struct seen_view *seen, struct vw_view_error *error) {
    enum vw_status status = render(evaluator, seen);
    if (!status && !sum_errors(seen, error) && !allows_blank)
        status = vw_fail(VW_ERROR_INPUT, "%s: this view has no usable pixel to measure; leave it out of its list",
                         measured->scene->views[view].name);
    return status;
}

// Chooses the pixels to fit a view's gain and bias on: single ones, since the few squares that steps of splats can
// afford show too little of a photo (2 dB of fox).
static uint32_t choose_fit(const struct vw_measured_field *measured, uint32_t view, uint32_t most,
                           struct vw_pixel *pixels) {
    if (!measured->fits) return 0;
    return vw_pixels_stratify_squares(measured->scene, view, vw_view_fit_left_half(measured->scene, view), 0,
                                      measured->masks, 1, most < VIEW_FIT_RAYS_MAX ? most : VIEW_FIT_RAYS_MAX, pixels);
}

// ---- A share of every view ------------------------------------------------------------------------------------------

static enum vw_status measure_view(const struct vw_measured_field *measured, struct vw_evaluator *evaluator,
                                   uint32_t view, uint32_t pixels_max, struct seen_view *seen,
                                   struct vw_view_error *error) {
    const struct vw_scene *scene = measured->scene;
    const struct vw_pixel_columns scored =
        measured->fits ? vw_view_fit_right_half(scene, view) : vw_pixels_all_columns(scene, view);
    seen->fit_count = choose_fit(measured, view, pixels_max, seen->pixels);
    seen->count = seen->fit_count + vw_pixels_stratify_squares(scene, view, scored, 0, measured->masks,
                                                               measured->field->model->patch_side, pixels_max,
                                                               seen->pixels + seen->fit_count);
    return see(measured, evaluator, view, measured->allows_blank, seen, error);
}

enum vw_status vw_measure_views(const struct vw_measured_field *measured, const uint32_t *views, uint32_t view_count,
                                uint32_t pixels_max, struct vw_view_error *errors) {
    size_t most = (size_t)pixels_max + (measured->fits ? VIEW_FIT_RAYS_MAX : 0);
    struct vw_evaluator evaluator = {0};
    struct seen_view seen;
    enum vw_status status = allocate(most, &seen);
    if (!status) status = vw_scene_decode(measured->scene, views, view_count);
    if (!status)
        status = vw_evaluator_create(measured->field, most < TILE_RAYS ? (uint32_t)most : TILE_RAYS, false, &evaluator);
    for (uint32_t i = 0; !status && i < view_count; i++) {
        status = measure_view(measured, &evaluator, views[i], pixels_max, &seen, &errors[i]);
        if (!status && measured->plain_mse) measured->plain_mse[i] = seen.plain_mse;
    }
    vw_evaluator_destroy(&evaluator);
    release(&seen);
    return status;
}

// ---- A whole view ---------------------------------------------------------------------------------------------------

// Returns whether the photo's left half tells how its right half looks, which alone is scored.
static bool halves(const struct vw_measured_field *measured) {
    return measured->fits || vw_effects_see_photos(measured->field->model);
}

// Chooses all pixels of the view, after those to fit on. Where the left half is not scored, only the right one has
// weight.
static void choose_all(const struct vw_measured_field *measured, uint32_t view, const struct vw_whole_view *whole,
                       struct seen_view *seen) {
    const struct vw_scene *scene = measured->scene;
    struct vw_pixel_columns right = vw_view_fit_right_half(scene, view);
    seen->fit_count = choose_fit(measured, view, UINT32_MAX, seen->pixels);
    seen->count = seen->fit_count + whole->width_px * whole->height_px;
    for (uint32_t i = seen->fit_count; i < seen->count; i++) {
        uint32_t pixel = i - seen->fit_count;
        seen->pixels[i] = vw_pixels_at(scene, view, measured->masks, pixel % whole->width_px, pixel / whole->width_px);
    }
    for (uint32_t i = seen->fit_count; halves(measured) && i < seen->count; i++)
        if ((i - seen->fit_count) % whole->width_px < right.begin) seen->pixels[i].weight = 0.0f;
}

// Writes over the pixels that were seen.
static enum vw_status fit_code(const struct vw_measured_field *measured, uint32_t view, struct seen_view *seen,
                               struct vw_code_fit *code) {
    const struct vw_scene *scene = measured->scene;
    if (!measured->fits) return VW_OK;
    uint32_t count = vw_pixels_stratify_squares(scene, view, vw_view_fit_left_half(scene, view), 0, measured->masks, 1,
                                                CODE_FIT_RAYS_MAX, seen->pixels);
    return vw_code_fit_apply(measured->field, seen->pixels, count, code);
}

// Shows a part of a view to the effect appearance_encoder.
static enum vw_status show_encoder(const struct vw_measured_field *measured, uint32_t view,
                                   struct vw_pixel_columns columns) {
    const struct vw_thumbnail_choice choice = {columns, measured->masks};
    return vw_encoder_set_thumbnail(measured->field, measured->field->scene, view, &choice);
}

static enum vw_status keep_pixels(const struct seen_view *seen, struct vw_whole_view *whole) {
    uint32_t count = seen->count - seen->fit_count;
    whole->rendered = vw_allocate(count, 3 * sizeof *whole->rendered);
    whole->photo = vw_allocate(count, 3 * sizeof *whole->photo);
    whole->counts = vw_allocate(count, sizeof *whole->counts);
    if (!whole->rendered || !whole->photo || !whole->counts) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < count; i++) {
        const vw_float4 *target = &seen->targets[seen->fit_count + i];
        whole->counts[i] = target->w != 0.0f;
        for (int channel = 0; channel < 3; channel++) {
            whole->rendered[3 * (size_t)i + (size_t)channel] = (float)seen_channel(seen, seen->fit_count + i, channel);
            whole->photo[3 * (size_t)i + (size_t)channel] = (float)channel_of(*target, channel);
        }
    }
    return VW_OK;
}

// Renders and measures the view, which the field sees with the camera of the measured scene.
static enum vw_status see_whole(const struct vw_measured_field *measured, uint32_t view, struct seen_view *seen,
                                struct vw_whole_view *whole) {
    struct vw_evaluator evaluator = {0};
    struct vw_code_fit code = {0};
    uint32_t rays = whole->width_px * whole->height_px + CODE_FIT_RAYS_MAX;
    enum vw_status status =
        vw_evaluator_create(measured->field, rays < TILE_RAYS ? rays : TILE_RAYS, false, &evaluator);
    if (!status) status = fit_code(measured, view, seen, &code);
    if (!status) status = show_encoder(measured, view, vw_view_fit_left_half(measured->field->scene, view));
    if (!status) {
        choose_all(measured, view, whole, seen);
        status = see(measured, &evaluator, view, measured->allows_blank, seen, &whole->error);
    }
    if (!status) status = keep_pixels(seen, whole);
    enum vw_status undone = vw_code_fit_undo(measured->field, &code);
    if (!undone) undone = show_encoder(measured, view, vw_pixels_all_columns(measured->field->scene, view));
    vw_evaluator_destroy(&evaluator);
    return status ? status : undone;
}

enum vw_status vw_measure_whole_view(const struct vw_measured_field *measured, uint32_t view,
                                     struct vw_whole_view *whole) {
    const struct vw_camera *camera = &measured->scene->views[view].camera;
    bool posed = measured->scene != measured->field->scene;
    struct seen_view seen;
    *whole = (struct vw_whole_view){.width_px = camera->width_px, .height_px = camera->height_px};
    enum vw_status status = allocate((size_t)whole->width_px * whole->height_px + CODE_FIT_RAYS_MAX, &seen);
    if (!status) status = vw_scene_decode(measured->scene, &view, 1);
    if (!status && posed) status = vw_scene_decode(measured->field->scene, &view, 1); // for effects that see it
    if (!status && posed) status = vw_field_pose(measured->field, view, &measured->scene->views[view]);
    if (!status) status = see_whole(measured, view, &seen, whole);
    enum vw_status undone = posed ? vw_field_pose(measured->field, view, NULL) : VW_OK;
    if (!status) status = undone;
    release(&seen);
    if (status) vw_whole_view_free(whole);
    return status;
}

void vw_whole_view_free(struct vw_whole_view *whole) {
    free(whole->rendered);
    free(whole->photo);
    free(whole->counts);
    *whole = (struct vw_whole_view){0};
}
