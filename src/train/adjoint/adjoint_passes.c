#include "train/adjoint/adjoint_passes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "gpu/shaders.h"
#include "train/effects/effects.h"
#include "train/passes.h"

// ---- Creation -------------------------------------------------------------------------------------------------------

static const char adjoint_role[] = "adjoint"; // the role of its passes in the timers

static const struct vw_model *model_of(const struct vw_adjoint_passes *backward) {
    return backward->context->field->model;
}

static uint32_t pad(const struct vw_adjoint_passes *backward, uint32_t rays) {
    return vw_model_pad_rays(model_of(backward), rays);
}

enum vw_status vw_adjoint_check(const struct vw_trainer_parts *context) {
    const struct vw_model *model = context->field->model;
    enum vw_status status = vw_effects_check_adjoint(model);
    if (status) return status;
    if (model->param_bytes > vw_gpu_get_limits(context->field->gpu)->storage_binding_bytes)
        return vw_fail(
            VW_ERROR_USAGE,
            "the backward pass: the params of %llu bytes exceed this device's binding range; value the scene "
            "with a lower --log2-table",
            (unsigned long long)model->param_bytes);
    return VW_OK;
}

static uint64_t adjoint_bytes(const struct vw_model *model) {
    return model->param_bytes * (model->specialization.momentum ? 2 : 1);
}

static enum vw_status create_buffers(struct vw_adjoint_passes *backward, uint32_t submission_steps) {
    const struct vw_trainer_parts *context = backward->context;
    const struct vw_model *model = model_of(backward);
    uint64_t block = model->param_bytes, momentum = model->specialization.momentum ? block : 0;
    const struct vw_buffer_row rows = {&backward->rows, "adjoint_rows",
                                       16ull * backward->measure_count * submission_steps};
    const struct vw_buffer_row buffers[] = {
        {&backward->blocks.before, "params_before", block},
        {&backward->blocks.after, "params_after", block},
        {&backward->blocks.gradient, "step_gradient", block},
        {&backward->blocks.moment, "step_moment", momentum},
        {&backward->direction, "direction", block},
        {&backward->sums, "adjoint_sums", 2 * 16 * VW_ADJOINT_GROUPS},
        {&backward->state, "adjoint_state", sizeof(struct vw_adjoint_state)},
        {&backward->seen_ahead, "seen_ahead", 16 * (uint64_t)context->step->padded_rays},
        {&backward->places, "step_places", vw_importance_places_bytes(model, pad(backward, backward->rays))},
        {&backward->val_rays, "slopes_of_views", vw_buffer_size_bytes(context->validation->evaluator.rays)},
        {&backward->adjoint.blocks.lambda, "adjoint", block},
        {&backward->adjoint.blocks.moment, "adjoint_moment", momentum},
    };
    enum vw_status status = vw_buffers_create(&backward->objects, VW_BUFFER_READBACK, &rows, 1);
    if (!status) status = vw_buffers_create(&backward->objects, VW_BUFFER_DEVICE, buffers, VW_ARRAY_COUNT(buffers));
    backward->by_measure = vw_allocate(backward->measure_count, sizeof *backward->by_measure);
    if (!status && !backward->by_measure) status = VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < backward->measure_count && !status; i++) {
        bool by_host = i >= ADJOINT_OF_VIEWS && backward->views_on_host;
        const struct vw_buffer_row of_measure[] = {{&backward->by_measure[i].lambda, "adjoint_of_measure", block},
                                                   {&backward->by_measure[i].moment, "adjoint_of_measure", momentum}};
        status = vw_buffers_create(&backward->objects, by_host ? VW_BUFFER_READBACK : VW_BUFFER_DEVICE, of_measure, 2);
    }
    return status;
}

static double largest_weight(const struct vw_validation *validation) {
    double most = 0;
    for (uint32_t i = 0; i < validation->view_count; i++) most = fmax(most, validation->weights[i]);
    return most;
}

// Multiplies the weights of the rays in the views' ranges, of which there may be none, by the views' weights as shares
// of the largest: slopes of at most 1 fit the fixed-point range.
static enum vw_status weigh_rays(const struct vw_validation *validation, double most, struct vw_buffer *ranges,
                                 struct vw_ray *rays) {
    if (!ranges) return VW_OK;
    struct vw_ray_range *of_views = vw_allocate(validation->view_count, sizeof *of_views);
    if (!of_views) return VW_ERROR_MEMORY;
    enum vw_status status = vw_buffer_read(ranges, 0, of_views, validation->view_count * sizeof *of_views);
    for (uint32_t v = 0; v < validation->view_count && !status; v++)
        for (uint32_t i = of_views[v].first; i < of_views[v].first + of_views[v].count; i++)
            rays[i].target_weight.w *= (float)(validation->weights[v] / most);
    free(of_views);
    return status;
}

static enum vw_status create_weighted_rays(struct vw_adjoint_passes *backward, struct vw_ray *rays) {
    const struct vw_validation *validation = backward->context->validation;
    uint64_t bytes = vw_buffer_size_bytes(backward->val_rays);
    const struct vw_buffer_row buffers[] = {{&backward->plain_rays, "plain_rays", bytes},
                                            {&backward->weighted_rays, "weighted_rays", bytes}};
    double most = largest_weight(validation);
    bool weighted = false;
    for (uint32_t v = 0; v < validation->view_count; v++) weighted |= validation->weights[v] != most;
    if (!weighted) return VW_OK;
    enum vw_status status = vw_buffers_create(&backward->objects, VW_BUFFER_DEVICE, buffers, VW_ARRAY_COUNT(buffers));
    if (!status) status = vw_buffer_write(backward->plain_rays, 0, rays, bytes);
    if (!status) status = weigh_rays(validation, most, validation->ranges, rays);
    if (!status) status = weigh_rays(validation, most, validation->view_fit.ranges, rays);
    return status ? status : vw_buffer_write(backward->weighted_rays, 0, rays, bytes);
}

// Rays that are padding have no slope, and never get one.
static enum vw_status create_val_rays(struct vw_adjoint_passes *backward) {
    uint64_t bytes = vw_buffer_size_bytes(backward->val_rays);
    struct vw_ray *rays = vw_allocate(bytes, 1);
    if (!rays) return VW_ERROR_MEMORY;
    enum vw_status status = vw_buffer_read(backward->context->validation->evaluator.rays, 0, rays, bytes);
    for (uint64_t i = 0; i < bytes / sizeof *rays; i++)
        rays[i].target_weight = (vw_float4){.w = rays[i].target_weight.w};
    if (!status) status = vw_buffer_write(backward->val_rays, 0, rays, bytes);
    if (!status) status = create_weighted_rays(backward, rays);
    free(rays);
    return status;
}

static enum vw_status create_pass(struct vw_adjoint_passes *backward, const struct vw_shader *shader,
                                  const struct vw_binding *bindings, uint32_t count, struct vw_pass **pass) {
    const struct vw_pass_params common =
        vw_pass_params_of(&model_of(backward)->specialization, bindings, count, adjoint_role);
    return vw_pass_create_of(&backward->objects, &common, shader, pass);
}

static struct vw_binding range_binding(uint32_t slot, struct vw_buffer *block, const struct vw_param_range *range) {
    return (struct vw_binding){
        .slot = slot, .buffer = block, .offset_bytes = range->offset_bytes, .size_bytes = range->size_bytes};
}

// Creates a gather. `second`: another range that the shader gathers; NULL: none.
static enum vw_status create_gather(struct vw_adjoint_passes *backward, const struct vw_shader *shader,
                                    const struct vw_param_range *range, const struct vw_param_range *second,
                                    struct vw_buffer *block, struct vw_pass **pass) {
    struct vw_binding bindings[VW_SLOT_COUNT] = {
        range_binding(VW_SLOT_GATHERED, block, range),
        {.slot = VW_SLOT_ADJOINT_STATE, .buffer = backward->state},
    };
    uint32_t count = 2;
    if (second) bindings[count++] = range_binding(VW_SLOT_GATHERED_CODES, block, second);
    vw_step_bind(backward->context->step, bindings, &count);
    return create_pass(backward, shader, bindings, count, pass);
}

static enum vw_status create_gather_grid(struct vw_adjoint_passes *backward, uint32_t index,
                                         struct vw_gathered *gathered) {
    const struct vw_grid_window *window = &vw_volume_of(model_of(backward))->windows[index];
    uint64_t word = model_of(backward)->specialization.wide_gradient ? 16 : 8, first = window->first_pair,
             pairs = window->pair_count;
    const struct vw_param_range range = {
        .offset_bytes = vw_volume_of(model_of(backward))->grid.offset_bytes + 8 * first, .size_bytes = 8 * pairs};
    const struct vw_binding bindings[] = {
        range_binding(VW_SLOT_GATHERED, gathered->block, &range),
        {.slot = VW_SLOT_ADJOINT_STATE, .buffer = backward->state},
        {.slot = VW_SLOT_STEP_STATE, .buffer = backward->context->field->step_state},
        {.slot = VW_SLOT_D_GRID,
         .buffer = vw_volume_step_of(backward->context->step)->d_grid,
         .offset_bytes = word * first,
         .size_bytes = word * pairs},
    };
    return create_pass(backward, &vw_shader_gather_grid, bindings, VW_ARRAY_COUNT(bindings), &gathered->grid[index]);
}

static enum vw_status create_gathered(struct vw_adjoint_passes *backward, struct vw_buffer *block,
                                      struct vw_gathered *gathered) {
    const struct vw_model *model = model_of(backward);
    const struct vw_param_range moved = {.offset_bytes = model->weights.offset_bytes,
                                         .size_bytes = 16 * (uint64_t)model->moved_columns};
    enum vw_status status = VW_OK;
    gathered->block = block;
    for (uint32_t i = 0; i < vw_volume_of(model)->window_count && !status; i++)
        status = create_gather_grid(backward, i, gathered);
    if (!status) status = create_gather(backward, &vw_shader_gather_weights, &moved, NULL, block, &gathered->weights);
    if (status || !model->specialization.effect_appearance_code) return status;
    return create_gather(backward, &vw_shader_gather_code, &model->ranges[VW_SLOT_CODE_WEIGHTS],
                         &model->ranges[VW_SLOT_CODES], block, &gathered->codes);
}

static enum vw_status create_adjoint(struct vw_adjoint_passes *backward, struct vw_adjoint *adjoint) {
    bool momentum = adjoint->blocks.moment != NULL;
    const struct vw_binding bindings[] = {
        {.slot = VW_SLOT_PARAMS_BEFORE, .buffer = backward->blocks.before},
        {.slot = VW_SLOT_PARAMS_AFTER, .buffer = backward->blocks.after},
        {.slot = VW_SLOT_STEP_GRADIENT, .buffer = backward->blocks.gradient},
        {.slot = VW_SLOT_STEP_MOMENT, .buffer = backward->blocks.moment, .unused = !momentum},
        {.slot = VW_SLOT_ADJOINT, .buffer = adjoint->blocks.lambda},
        {.slot = VW_SLOT_ADJOINT_MOMENT, .buffer = adjoint->blocks.moment, .unused = !momentum},
        {.slot = VW_SLOT_DIRECTION, .buffer = backward->direction},
        {.slot = VW_SLOT_ADJOINT_SUMS, .buffer = backward->sums},
    };
    enum vw_status status = create_gathered(backward, adjoint->blocks.lambda, &adjoint->sum);
    return !status
               ? create_pass(backward, &vw_shader_direct_adjoint, bindings, VW_ARRAY_COUNT(bindings), &adjoint->direct)
               : status;
}

// Passes over a step's rays and the block of all params.
static enum vw_status create_step_passes(struct vw_adjoint_passes *backward) {
    const struct vw_model *model = model_of(backward);
    const struct vw_specialization *s = &model->specialization;
    struct vw_specialization plain = *s, given = *s;
    plain.stores_rows = 0;
    given.loss = LOSS_GIVEN;
    struct vw_binding bindings[VW_SLOT_COUNT] = {
        {.slot = VW_SLOT_SCALARS, .buffer = backward->rows}, // in place of the step's, which is bound last
        {.slot = VW_SLOT_PARAMS, .buffer = backward->context->field->params, .size_bytes = model->param_bytes},
        {.slot = VW_SLOT_PARAMS_BEFORE, .buffer = backward->blocks.before},
        {.slot = VW_SLOT_DIRECTION, .buffer = backward->direction},
        {.slot = VW_SLOT_ADJOINT_SUMS, .buffer = backward->sums},
        {.slot = VW_SLOT_ADJOINT_STATE, .buffer = backward->state},
        {.slot = VW_SLOT_SEEN_AHEAD, .buffer = backward->seen_ahead},
    };
    uint32_t own = 7, count = own;
    vw_step_bind(backward->context->step, bindings, &count);
    for (uint32_t i = own; i < count; i++) // each slot once
        if (bindings[i].slot == VW_SLOT_SCALARS) bindings[i] = bindings[--count];
    const struct vw_pass_params common = vw_pass_params_of(s, bindings, count, adjoint_role);
    const struct vw_pass_row passes[] = {
        {&vw_shader_perturb_params, &backward->perturb},
        {vw_model_has_ray_effects(model, s) ? &vw_shader_difference_rays_effects : &vw_shader_difference_rays,
         &backward->difference},
        {&vw_shader_reduce_adjoint, &backward->reduce},
        {&vw_shader_normalise_slopes, &backward->normalise_step},
    };
    const struct vw_field_pass_params ahead = {.objects = &backward->objects,
                                               .common = vw_pass_params_of(&plain, bindings, count, adjoint_role)};
    enum vw_status status = vw_gradient_create(backward->context->step, &backward->objects, &given, &backward->product);
    backward->forward.specialization = plain;
    if (!status)
        status = vw_volume_of(model)->kind->create_passes(backward->context->field, &ahead, &backward->forward);
    return !status ? vw_passes_create(&backward->objects, &common, passes, VW_ARRAY_COUNT(passes)) : status;
}

static enum vw_status create_view_passes(struct vw_adjoint_passes *backward) {
    const struct vw_validation *validation = backward->context->validation;
    // Passes as validation has them (decision 1: no jitter, no skipping, no photo's code, everything visible), with
    // activations stored.
    struct vw_specialization of_views = vw_effects_specialise_validation(model_of(backward));
    of_views.loss = LOSS_GIVEN;
    const struct vw_binding slopes[] = {
        {.slot = VW_SLOT_RAYS, .buffer = validation->evaluator.rays},
        {.slot = VW_SLOT_COLOURS, .buffer = validation->evaluator.colours},
        {.slot = VW_SLOT_VAL_VIEWS, .buffer = validation->ranges},
        {.slot = VW_SLOT_FITS, .buffer = validation->view_fit.fits, .unused = !validation->view_fit.fits},
        {.slot = VW_SLOT_FIT_VIEWS, .buffer = validation->view_fit.ranges, .unused = !validation->view_fit.ranges},
        {.slot = VW_SLOT_SCALARS, .buffer = backward->context->scalars},
        {.slot = VW_SLOT_GATHERED, .buffer = backward->val_rays},
    };
    const struct vw_binding normal[] = {
        {.slot = VW_SLOT_RAYS, .buffer = backward->val_rays},
        {.slot = VW_SLOT_STEP_STATE, .buffer = backward->context->field->step_state},
        {.slot = VW_SLOT_ADJOINT_STATE, .buffer = backward->state},
    };
    enum vw_status status =
        vw_gradient_create(backward->context->step, &backward->objects, &of_views, &backward->validation);
    if (!status)
        status = create_pass(backward, &vw_shader_slope_views, slopes, VW_ARRAY_COUNT(slopes), &backward->slope_views);
    return !status ? create_pass(backward, &vw_shader_normalise_slopes, normal, VW_ARRAY_COUNT(normal),
                                 &backward->normalise_views)
                   : status;
}

enum vw_status vw_adjoint_create(const struct vw_trainer_parts *context, const struct vw_adjoint_params *params,
                                 struct vw_adjoint_passes *backward) {
    uint32_t of_step = context->step->rays, views = params->by_view ? context->validation->view_count : 0;
    *backward = (struct vw_adjoint_passes){.context = context,
                                           .objects = {.gpu = context->field->gpu},
                                           .rays = params->rays && params->rays < of_step ? params->rays : of_step,
                                           .measure_count = params->psnr_alone ? 1 : ADJOINT_OF_VIEWS + views};
    backward->views_on_host = views * adjoint_bytes(context->field->model) > params->views_memory_bytes;
    enum vw_status status = vw_adjoint_check(context);
    if (!status) status = create_buffers(backward, params->submission_steps);
    if (!status) status = create_val_rays(backward);
    if (!status) status = create_step_passes(backward);
    if (!status) status = create_view_passes(backward);
    if (!status) status = create_gathered(backward, backward->blocks.gradient, &backward->step_gradient);
    if (!status) status = create_adjoint(backward, &backward->adjoint);
    if (status) vw_adjoint_destroy(backward);
    return status;
}

void vw_adjoint_destroy(struct vw_adjoint_passes *backward) {
    vw_gpu_objects_destroy(&backward->objects);
    free(backward->by_measure);
    backward->by_measure = NULL;
}

uint64_t vw_adjoint_views_bytes(const struct vw_adjoint_passes *backward) {
    return backward->views_on_host ? 0
                                   : (backward->measure_count - ADJOINT_OF_VIEWS) * adjoint_bytes(model_of(backward));
}

// ---- Recording ------------------------------------------------------------------------------------------------------

// Records a gather. `photos`: includes the params that belong to photos, for `rays` rays of one of them.
static void record_gather(const struct vw_adjoint_passes *backward, const struct vw_gathered *gathered,
                          struct vw_submission *submission, bool adds, bool photos, uint32_t rays) {
    const struct vw_model *model = model_of(backward);
    struct vw_push_gather push = {.adds = adds};
    for (uint32_t i = 0; i < vw_volume_of(model)->window_count; i++) {
        push.count = vw_volume_of(model)->windows[i].pair_count;
        vw_submission_dispatch(submission, gathered->grid[i], &push, sizeof push, push.count);
    }
    push.count = model->followed_columns;
    vw_submission_dispatch(submission, gathered->weights, &push, sizeof push, push.count);
    push.count = rays;
    if (photos && gathered->codes) vw_submission_dispatch(submission, gathered->codes, &push, sizeof push, 1);
}

void vw_adjoint_record_own_step(const struct vw_adjoint_passes *backward, struct vw_submission *submission,
                                uint64_t number, uint32_t first_pixel, uint32_t scalar_row) {
    const struct vw_step_passes *step = backward->context->step;
    vw_step_record_gradients(step, submission, number, first_pixel);
    uint32_t rays = vw_step_counted_rays(step, first_pixel);
    record_gather(backward, &backward->step_gradient, submission, false, true, pad(backward, rays));
    vw_step_record_update(step, submission, number, first_pixel, 0);
    vw_step_record_loss(step, submission, first_pixel, scalar_row);
}

void vw_adjoint_record_stored_step(const struct vw_adjoint_passes *backward, const struct vw_stored_steps *stored,
                                   struct vw_submission *submission, uint64_t number, uint32_t first_pixel,
                                   uint32_t scalar_row, uint32_t place) {
    vw_stored_steps_record_before(stored, submission, place);
    vw_adjoint_record_own_step(backward, submission, number, first_pixel, scalar_row);
    vw_stored_steps_record_gradient(stored, submission, backward->blocks.gradient, place);
    vw_stored_steps_record_after(stored, submission, place);
}

static void record_copy(const struct vw_adjoint_passes *backward, struct vw_submission *submission,
                        const struct vw_adjoint_blocks *from, const struct vw_adjoint_blocks *to) {
    uint64_t bytes = model_of(backward)->param_bytes;
    vw_submission_copy(submission, from->lambda, 0, to->lambda, 0, bytes);
    if (from->moment) vw_submission_copy(submission, from->moment, 0, to->moment, 0, bytes);
}

static void record_restore(const struct vw_adjoint_passes *backward, struct vw_submission *submission,
                           struct vw_buffer *block) {
    vw_submission_copy(submission, block, 0, backward->context->field->params, 0, model_of(backward)->param_bytes);
}

// Records the backward pass from the slopes of validation's rays, as many at a time as a step has.
static void record_views_back(const struct vw_adjoint_passes *backward, struct vw_submission *submission) {
    const struct vw_step_passes *step = backward->context->step;
    uint32_t rays = backward->context->validation->evaluator.ray_count;
    for (uint32_t piece = 0; piece < rays; piece += step->padded_rays) {
        uint32_t count = rays - piece < step->padded_rays ? rays - piece : step->padded_rays;
        vw_submission_copy(submission, backward->val_rays, sizeof(struct vw_ray) * piece, step->ray_buffer, 0,
                           sizeof(struct vw_ray) * count);
        for (uint32_t first = 0; first < count; first += vw_volume_step_of(step)->chunk_rays) {
            const struct vw_push_samples chunk = vw_gradient_chunk(step, count, first, (vw_uint4){0});
            vw_gradient_record_chunk(step, &backward->validation, submission, &chunk);
        }
        vw_ray_passes_record_end(&backward->validation.of_rays, submission, count);
        record_gather(backward, &backward->adjoint.sum, submission, true, false, 0);
        vw_step_record_clear(step, submission);
    }
}

void vw_adjoint_record_state(const struct vw_adjoint_passes *backward, struct vw_submission *submission,
                             uint32_t scalar_row, uint32_t states) {
    const struct vw_validation *validation = backward->context->validation;
    double values = 0.0, weights = 0.0, most = largest_weight(validation);
    for (uint32_t i = 0; i < validation->view_count; i++) {
        values += validation->weights[i] * 3.0 * validation->pixel_counts[i];
        weights += validation->weights[i];
    }
    // The passes back take a third of a ray's slope and divide by the rays of a step.
    double undo = 3.0 * backward->context->step->rays / states,
           factors[ADJOINT_OF_VIEWS] = {undo * most / weights, undo * most / values};
    record_restore(backward, submission, backward->blocks.after);
    vw_validation_record(validation, submission, scalar_row);
    for (uint32_t i = 0; i < backward->measure_count; i++) {
        bool of_view = i >= ADJOINT_OF_VIEWS;
        struct vw_push_slopes push = {.count = validation->view_count,
                                      .scalar_row = scalar_row,
                                      .measure = of_view ? ADJOINT_PSNR : i,
                                      .only_view = of_view ? i - ADJOINT_OF_VIEWS : VW_ALL_VIEWS,
                                      .unscale = (float)(of_view ? undo : factors[i])};
        if (backward->weighted_rays)
            vw_submission_copy(submission, of_view ? backward->plain_rays : backward->weighted_rays, 0,
                               backward->val_rays, 0, vw_buffer_size_bytes(backward->val_rays));
        vw_submission_dispatch(submission, backward->slope_views, &push, sizeof push, 64ull * push.count);
        push.count = validation->evaluator.ray_count;
        vw_submission_dispatch(submission, backward->normalise_views, &push, sizeof push, 1);
        record_copy(backward, submission, &backward->by_measure[i], &backward->adjoint.blocks);
        record_views_back(backward, submission);
        record_copy(backward, submission, &backward->adjoint.blocks, &backward->by_measure[i]);
    }
}

static uint32_t block_vectors(const struct vw_adjoint_passes *backward) {
    return (uint32_t)(model_of(backward)->param_bytes / sizeof(vw_float4));
}

// Records where the step had its samples: by the params before it.
static void record_places(const struct vw_adjoint_passes *backward, struct vw_submission *submission,
                          const struct vw_push_rays *rays) {
    const struct vw_step_passes *step = backward->context->step;
    uint32_t padded = pad(backward, rays->ray_count);
    if (!backward->places) return;
    record_restore(backward, submission, backward->blocks.before);
    vw_effects_record_photo(model_of(backward), &step->effects, submission, 0);
    for (uint32_t first = 0; first < padded; first += vw_volume_step_of(step)->chunk_rays) {
        const struct vw_push_samples chunk = vw_gradient_chunk(step, padded, first, rays->key);
        vw_importance_record(model_of(backward), &backward->product.importance, submission, &chunk);
        vw_submission_copy(submission, vw_volume_step_of(step)->places, 0, backward->places,
                           vw_importance_places_bytes(model_of(backward), first),
                           vw_importance_places_bytes(model_of(backward), chunk.ray_count));
    }
}

// Records the slopes of a step's rays: J direction by differences, times the loss's curvature.
static void record_slopes(const struct vw_adjoint_passes *backward, struct vw_submission *submission,
                          const struct vw_push_rays *rays) {
    const struct vw_step_passes *step = backward->context->step;
    uint32_t block4 = block_vectors(backward), padded = pad(backward, rays->ray_count);
    for (uint32_t ahead = 2; ahead-- > 0;) {
        struct vw_push_block push = {.count = block4, .sign = ahead ? 1.0f : -1.0f};
        vw_submission_dispatch(submission, backward->perturb, &push, sizeof push, block4);
        vw_effects_record_photo(model_of(backward), &step->effects, submission, 0);
        vw_effects_record_rays(model_of(backward), &step->effects, step, submission, rays);
        for (uint32_t first = 0; first < padded; first += vw_volume_step_of(step)->chunk_rays) {
            const struct vw_push_samples chunk = vw_gradient_chunk(step, padded, first, rays->key);
            const struct vw_push_difference difference = {
                .first_ray = chunk.first_ray, .ray_count = chunk.ray_count, .key = rays->key, .ahead = ahead};
            if (backward->places)
                vw_submission_copy(submission, backward->places, vw_importance_places_bytes(model_of(backward), first),
                                   vw_volume_step_of(step)->places, 0,
                                   vw_importance_places_bytes(model_of(backward), chunk.ray_count));
            vw_volume_of(model_of(backward))
                ->kind->record_forward(model_of(backward), &backward->forward, submission, &chunk);
            vw_submission_dispatch(submission, backward->difference, &difference, sizeof difference, chunk.ray_count);
        }
    }
    struct vw_push_slopes push = {
        .count = padded, .unscale = (float)vw_step_counted_rays(step, rays->first_pixel) / (float)rays->ray_count};
    vw_submission_dispatch(submission, backward->normalise_step, &push, sizeof push, 1);
}

void vw_adjoint_record_product(const struct vw_adjoint_passes *backward, struct vw_submission *submission,
                               const struct vw_push_rays *rays) {
    const struct vw_step_passes *step = backward->context->step;
    uint32_t padded = pad(backward, rays->ray_count);
    record_places(backward, submission, rays);
    record_slopes(backward, submission, rays);
    record_restore(backward, submission, backward->blocks.before);
    vw_effects_record_photo(model_of(backward), &step->effects, submission, 0);
    for (uint32_t first = 0; first < padded; first += vw_volume_step_of(step)->chunk_rays) {
        const struct vw_push_samples chunk = vw_gradient_chunk(step, padded, first, rays->key);
        vw_gradient_record_chunk(step, &backward->product, submission, &chunk);
    }
    vw_ray_passes_record_end(&backward->product.of_rays, submission, padded);
    record_gather(backward, &backward->adjoint.sum, submission, true, true, padded);
    vw_step_record_clear(step, submission);
}

static void record_adjoint(const struct vw_adjoint_passes *backward, struct vw_submission *submission,
                           const struct vw_push_rays *rays, uint32_t row) {
    const struct vw_step_passes *step = backward->context->step;
    const struct vw_push_block block = {.count = block_vectors(backward),
                                        .beta1 = step->field->model->specialization.beta1};
    const struct vw_push_reduce reduce = {.count = VW_ADJOINT_GROUPS, .scalar_row = row};
    record_restore(backward, submission, backward->blocks.before); // its pose params correct the rays of the photo
    vw_submission_dispatch(submission, vw_volume_step_of(step)->gradient.of_rays.generate, rays, sizeof *rays,
                           step->padded_rays);
    vw_submission_dispatch(submission, backward->adjoint.direct, &block, sizeof block, 64ull * VW_ADJOINT_GROUPS);
    vw_submission_dispatch(submission, backward->reduce, &reduce, sizeof reduce, 1);
    vw_adjoint_record_product(backward, submission, rays);
}

// Returns those of its rays that the product takes, from the first on.
static struct vw_push_rays rays_of_step(const struct vw_adjoint_passes *backward, uint64_t number,
                                        uint32_t first_pixel) {
    uint32_t counted = vw_step_counted_rays(backward->context->step, first_pixel);
    return (struct vw_push_rays){.first_pixel = first_pixel,
                                 .ray_count = backward->rays < counted ? backward->rays : counted,
                                 .key = vw_model_key_of_step(model_of(backward), number)};
}

void vw_adjoint_record_step(const struct vw_adjoint_passes *backward, struct vw_submission *submission, uint64_t number,
                            uint32_t first_pixel, uint32_t row) {
    const struct vw_push_rays rays = rays_of_step(backward, number, first_pixel);
    for (uint32_t i = 0; i < backward->measure_count; i++) {
        record_copy(backward, submission, &backward->by_measure[i], &backward->adjoint.blocks);
        record_adjoint(backward, submission, &rays, row + i);
        record_copy(backward, submission, &backward->adjoint.blocks, &backward->by_measure[i]);
    }
}
