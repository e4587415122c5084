#include "train/validation/validation.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/statistics.h"
#include "gpu/shaders.h"
#include "train/effects/effects.h"
#include "train/passes.h"
#include "train/pixels.h"

// ---- Pixels ---------------------------------------------------------------------------------------------------------

struct vw_pixel_columns vw_view_fit_left_half(const struct vw_scene *scene, uint32_t view) {
    return (struct vw_pixel_columns){0, scene->views[view].image.width_px / 2};
}

struct vw_pixel_columns vw_view_fit_right_half(const struct vw_scene *scene, uint32_t view) {
    uint32_t width = scene->views[view].image.width_px;
    return (struct vw_pixel_columns){width - width / 2, width};
}

enum vw_status vw_validation_list_views(const struct vw_scene *scene, struct vw_validation *validation) {
    enum vw_status status = vw_scene_list_views(scene, VW_SPLIT_VAL, &validation->views, &validation->view_count);
    if (!status && !validation->view_count)
        status = vw_fail(VW_ERROR_INPUT, "%s: no view is left to validate on; check the splits or give --val FILE",
                         scene->path);
    if (!status) validation->weights = vw_allocate(validation->view_count, sizeof *validation->weights);
    if (!status && !validation->weights) status = VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < validation->view_count && !status; i++)
        validation->weights[i] = scene->views[validation->views[i]].weight;
    return status;
}

static uint32_t rays_of_view(uint64_t total, uint32_t view_count, uint32_t index) {
    uint32_t share = (uint32_t)(total * (index + 1) / view_count - total * index / view_count);
    return share < VW_VAL_RAYS_PER_VIEW_MIN ? VW_VAL_RAYS_PER_VIEW_MIN : share;
}

// The pixels to render and each view's range of them: those that are scored, then those to fit on.
struct pixel_choice {
    struct vw_pixel *pixels;
    uint32_t count;
    struct vw_ray_range *scored, *fitted; // one allocation, at `scored`; fitted: empty unless views are fitted
};

static enum vw_status allocate_pixels(const struct vw_validation_params *params, struct vw_validation *validation,
                                      bool fits, struct pixel_choice *choice) {
    uint64_t most = 0, patch = params->field->model->patch_side; // a view takes a whole patch at least
    for (uint32_t i = 0; i < validation->view_count; i++)
        most += (fits ? 2 : 1) * rays_of_view(params->ray_count, validation->view_count, i) + 2 * patch * patch;
    choice->pixels = vw_allocate(most, sizeof *choice->pixels);
    choice->scored = vw_allocate(validation->view_count, 2 * sizeof *choice->scored);
    validation->pixel_counts = vw_allocate(validation->view_count, sizeof *validation->pixel_counts);
    if (!choice->pixels || !choice->scored || !validation->pixel_counts) return VW_ERROR_MEMORY;
    choice->fitted = choice->scored + validation->view_count;
    return VW_OK;
}

// Chooses the fixed pixels of every view that are scored, one view after another.
static enum vw_status choose_scored(const struct vw_validation_params *params, struct vw_validation *validation,
                                    bool fits, struct pixel_choice *choice) {
    const struct vw_scene *scene = params->scene;
    for (uint32_t i = 0; i < validation->view_count; i++) {
        uint32_t view = validation->views[i];
        struct vw_pixel_columns columns =
            fits ? vw_view_fit_right_half(scene, view) : vw_pixels_all_columns(scene, view);
        struct vw_pixel *pixels = choice->pixels + choice->count;
        uint32_t wanted = rays_of_view(params->ray_count, validation->view_count, i);
        uint32_t count = vw_pixels_stratify_squares(scene, view, columns, params->seed, params->masks,
                                                    params->field->model->patch_side, wanted, pixels);
        choice->scored[i] = (struct vw_ray_range){.first = choice->count, .count = count};
        for (uint32_t ray = 0; ray < count; ray++) validation->pixel_counts[i] += pixels[ray].weight != 0.0f;
        if (!validation->pixel_counts[i])
            return vw_fail(VW_ERROR_INPUT,
                           "%s: this validation view has no usable pixel%s; leave it out of the validation list",
                           scene->views[view].name, fits ? " in its right half, where appearance is scored" : "");
        choice->count += count;
    }
    validation->ray_count = choice->count;
    return VW_OK;
}

// Chooses the fixed pixels to fit each view on, after those that are scored: as many per view as are scored, or, of
// single pixels, fewer.
static void choose_fitted(const struct vw_validation_params *params, const struct vw_validation *validation,
                          struct pixel_choice *choice) {
    for (uint32_t i = 0; i < validation->view_count; i++) {
        uint32_t view = validation->views[i], wanted = choice->scored[i].count;
        // Squares show less of a photo than as many single pixels do: of 2, 4 and 9, fits of fox leave 24.8, 25.0 and
        // 27.0 dB, and whole photos have 26.8.
        if (params->field->model->patch_side == 1 && wanted > VIEW_FIT_RAYS_MAX) wanted = VIEW_FIT_RAYS_MAX;
        uint32_t taken = vw_pixels_stratify_squares(params->scene, view, vw_view_fit_left_half(params->scene, view),
                                                    params->seed, params->masks, params->field->model->patch_side,
                                                    wanted, choice->pixels + choice->count);
        choice->fitted[i] = (struct vw_ray_range){.first = choice->count, .count = taken};
        choice->count += taken;
    }
}

static enum vw_status choose_pixels(const struct vw_validation_params *params, struct vw_validation *validation,
                                    bool fits, struct pixel_choice *choice) {
    enum vw_status status = vw_scene_decode(params->scene, validation->views, validation->view_count);
    if (!status) status = allocate_pixels(params, validation, fits, choice);
    if (!status) status = choose_scored(params, validation, fits, choice);
    if (!status && fits) choose_fitted(params, validation, choice);
    return status;
}

// ---- Passes ---------------------------------------------------------------------------------------------------------

// Creates the pass that fits views, over the evaluator that renders their pixels as well.
static enum vw_status create_fit(const struct vw_ray_range *ranges, struct vw_validation *validation) {
    struct vw_view_fit *fit = &validation->view_fit;
    uint32_t count = validation->view_count;
    const struct vw_buffer_row buffers[] = {{&fit->ranges, "fit_ranges", sizeof *ranges * count},
                                            {&fit->fits, "fits", sizeof(struct vw_appearance) * count}};
    enum vw_status status = vw_buffers_create(&validation->objects, VW_BUFFER_DEVICE, buffers, VW_ARRAY_COUNT(buffers));
    if (!status) status = vw_buffer_write(fit->ranges, 0, ranges, sizeof *ranges * count);
    const struct vw_binding bindings[] = {
        {.slot = VW_SLOT_RAYS, .buffer = validation->evaluator.rays},
        {.slot = VW_SLOT_COLOURS, .buffer = validation->evaluator.colours},
        {.slot = VW_SLOT_VAL_VIEWS, .buffer = fit->ranges},
        {.slot = VW_SLOT_FITS, .buffer = fit->fits},
    };
    const struct vw_pass_params params = {.bindings = bindings, .binding_count = VW_ARRAY_COUNT(bindings)};
    return !status ? vw_pass_create_of(&validation->objects, &params, &vw_shader_fit_views, &fit->pass) : status;
}

static enum vw_status create_reduce(const struct vw_validation_params *params, struct vw_validation *validation) {
    const struct vw_radiance_field *field = params->field;
    const struct vw_binding bindings[] = {
        {.slot = VW_SLOT_RAYS, .buffer = validation->evaluator.rays},
        {.slot = VW_SLOT_COLOURS, .buffer = validation->evaluator.colours},
        {.slot = VW_SLOT_VAL_VIEWS, .buffer = validation->ranges},
        {.slot = VW_SLOT_SCALARS, .buffer = params->scalars},
        {.slot = VW_SLOT_FITS, .buffer = validation->view_fit.fits, .unused = !validation->view_fit.fits},
    };
    const struct vw_pass_params common =
        vw_pass_params_of(&field->model->specialization, bindings, VW_ARRAY_COUNT(bindings), NULL);
    return vw_pass_create_of(&validation->objects, &common, &vw_shader_reduce_views, &validation->reduce_views);
}

static enum vw_status create_passes(const struct vw_validation_params *params, const struct pixel_choice *choice,
                                    bool fits, struct vw_validation *validation) {
    uint64_t range_bytes = sizeof *choice->scored * validation->view_count;
    const struct vw_buffer_row ranges = {&validation->ranges, "val_ranges", range_bytes};
    enum vw_status status = vw_evaluator_create(params->field, choice->count, false, &validation->evaluator);
    if (!status) status = vw_evaluator_set_pixels(&validation->evaluator, choice->pixels, choice->count);
    if (!status) status = vw_buffers_create(&validation->objects, VW_BUFFER_DEVICE, &ranges, 1);
    if (!status) status = vw_buffer_write(validation->ranges, 0, choice->scored, range_bytes);
    if (!status && fits) status = create_fit(choice->fitted, validation);
    return !status ? create_reduce(params, validation) : status;
}

enum vw_status vw_validation_create(const struct vw_validation_params *params, struct vw_validation *validation) {
    bool fits = vw_effects_fit(params->field->model);
    struct pixel_choice choice = {0};
    validation->objects.gpu = params->field->gpu;
    enum vw_status status = choose_pixels(params, validation, fits, &choice);
    if (!status) status = create_passes(params, &choice, fits, validation);
    free(choice.pixels);
    free(choice.scored);
    return status;
}

void vw_validation_destroy(struct vw_validation *validation) {
    vw_gpu_objects_destroy(&validation->objects);
    vw_evaluator_destroy(&validation->evaluator);
    free(validation->views);
    free(validation->pixel_counts);
    free(validation->weights);
}

void vw_validation_record(const struct vw_validation *validation, struct vw_submission *submission,
                          uint32_t scalar_row) {
    if (!validation->view_count) return;
    const struct vw_push_reduce push = {.count = validation->view_count, .scalar_row = scalar_row};
    vw_evaluator_record(&validation->evaluator, submission);
    if (validation->view_fit.pass)
        vw_submission_dispatch(submission, validation->view_fit.pass, &push, sizeof push, 64ull * push.count);
    vw_submission_dispatch(submission, validation->reduce_views, &push, sizeof push, 64ull * push.count);
}

// ---- Reading back ---------------------------------------------------------------------------------------------------

uint32_t vw_validation_rows_per_measurement(const struct vw_validation *validation) {
    return 1 + validation->view_count;
}

struct vw_field_measurement vw_validation_read(const struct vw_validation *validation, const vw_float4 *rows,
                                               struct vw_view_error *views) {
    const vw_float4 *sums = rows + 1;
    struct vw_field_measurement measurement = {0};
    double squared = 0.0, absolute = 0.0, psnr = 0.0, values = 0.0, weights = 0.0;
    for (uint32_t i = 0; i < validation->view_count; i++) {
        double view_squared = (double)sums[i].x + sums[i].y, view_absolute = (double)sums[i].z + sums[i].w;
        double view_values = 3.0 * validation->pixel_counts[i], weight = validation->weights[i];
        struct vw_view_error error = {.mse = view_squared / view_values, .l1 = view_absolute / view_values};
        if (views) views[i] = error;
        psnr += weight * vw_psnr_db(error.mse);
        measurement.floored_views += error.mse < VW_MSE_FLOOR;
        squared += weight * view_squared;
        absolute += weight * view_absolute;
        values += weight * view_values;
        weights += weight;
    }
    measurement.val_psnr = psnr / weights;
    measurement.val_psnr_pooled = vw_psnr_db(squared / values);
    measurement.val_l1 = absolute / values;
    measurement.finite = isfinite(squared) && isfinite(absolute);
    return measurement;
}
