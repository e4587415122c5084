#include "train/step.h"

#include <stddef.h>

#include "base/memory.h"
#include "gpu/compute.h"
#include "gpu/shaders.h"
#include "train/effects/effects.h"
#include "train/passes.h"

static uint32_t word_bytes(const struct vw_model *model) { return model->specialization.wide_gradient ? 16 : 8; }

// The flag of `overflow` that a pass sets: the grid's windows follow one another.
enum { OVERFLOW_WEIGHTS, OVERFLOW_PHOTOS, OVERFLOW_GRID };
static const uint64_t OVERFLOW_BYTES = 4 * VW_OVERFLOW_STRIDE;

static struct vw_binding overflow_binding(const struct vw_step_passes *step, uint32_t flag) {
    return (struct vw_binding){.slot = VW_SLOT_OVERFLOW,
                               .buffer = step->overflow,
                               .offset_bytes = flag * OVERFLOW_BYTES,
                               .size_bytes = OVERFLOW_BYTES};
}

static enum vw_status create_buffers(struct vw_step_passes *step) {
    const struct vw_model *model = step->field->model;
    uint64_t chunk = model->specialization.chunk_samples, pairs = model->pair_count, columns = model->partial_columns,
             moved = model->moved_columns;
    const struct vw_buffer_row buffers[] = {
        {&step->ray_buffer, "rays", sizeof(struct vw_ray) * step->padded_rays},
        {&step->samples, "samples", 16 * chunk},
        {&step->d_samples, "d_samples", 16 * chunk},
        {&step->overflow, "overflow", OVERFLOW_BYTES * (OVERFLOW_GRID + model->window_count)},
        {&step->ray_loss, "ray_loss", 4 * (uint64_t)step->padded_rays},
        {&step->weight_partials, "weight_partials", 16 * columns * (chunk / model->specialization.slice_samples)},
        {&step->d_weights, "d_weights", 16 * moved},
        {&step->weight_moments, "weight_moments", 2 * 16 * moved},
        {&step->d_grid, "d_grid", word_bytes(model) * pairs},
        // Without momentum there is no first moment; the slot is declared by the shader, so a stub is bound.
        {&step->grid_moment1, "grid_moment1", pairs && !model->specialization.momentum ? 8 : 8 * pairs},
        {&step->grid_moment2, "grid_moment2", 8 * pairs},
        {&step->grid_visits, "grid_visits", 4 * pairs},
        {&step->places, "sample_places", vw_importance_places_bytes(model, step->chunk_rays)},
    };
    enum vw_status status = vw_buffers_create(&step->objects, VW_BUFFER_DEVICE, buffers, VW_ARRAY_COUNT(buffers));
    return !status ? vw_effects_create_buffers(model, &step->objects, false, step->padded_rays, step->effect_buffers)
                   : status;
}

static enum vw_status create_update_passes(struct vw_step_passes *step) {
    const struct vw_model *model = step->field->model;
    struct vw_binding bindings[VW_SLOT_COUNT];
    uint32_t count = 0;
    vw_step_bind(step, bindings, &count); // its first binding is the one of flags
    const struct vw_pass_params common = vw_pass_params_of(&model->specialization, bindings, count, NULL);
    enum vw_status status = vw_pass_create_of(&step->objects, &common, &vw_shader_reduce_loss, &step->reduce_loss);
    bindings[0] = overflow_binding(step, OVERFLOW_WEIGHTS);
    if (!status) status = vw_pass_create_of(&step->objects, &common, &vw_shader_update_weights, &step->update_weights);
    bindings[0] = overflow_binding(step, OVERFLOW_PHOTOS);
    return !status ? vw_effects_create_passes(model, &step->objects, &common, true, &step->effects) : status;
}

// Creates the pass that updates one window of the grid. Passes that write the grid see one window of it, so that each
// binding fits the device's range.
static enum vw_status create_update_grid(struct vw_step_passes *step, uint32_t index) {
    const struct vw_radiance_field *field = step->field;
    const struct vw_grid_window *window = &field->model->windows[index];
    uint64_t first = window->first_pair, pairs = window->pair_count, word = word_bytes(field->model),
             pair = field->model->pair_bytes;
    bool momentum = field->model->specialization.momentum;
    const struct vw_binding bindings[] = {
        {.slot = VW_SLOT_STEP_STATE, .buffer = field->step_state},
        overflow_binding(step, OVERFLOW_GRID + index),
        {.slot = VW_SLOT_GRID,
         .buffer = field->params,
         .offset_bytes = field->model->grid.offset_bytes + pair * first,
         .size_bytes = pair * pairs},
        {.slot = VW_SLOT_D_GRID, .buffer = step->d_grid, .offset_bytes = word * first, .size_bytes = word * pairs},
        {.slot = VW_SLOT_GRID_MOMENT1,
         .buffer = step->grid_moment1,
         .offset_bytes = momentum ? 8 * first : 0,
         .size_bytes = momentum ? 8 * pairs : 8},
        {.slot = VW_SLOT_GRID_MOMENT2,
         .buffer = step->grid_moment2,
         .offset_bytes = 8 * first,
         .size_bytes = 8 * pairs},
        {.slot = VW_SLOT_GRID_VISITS, .buffer = step->grid_visits, .offset_bytes = 4 * first, .size_bytes = 4 * pairs},
    };
    const struct vw_pass_params common =
        vw_pass_params_of(&field->model->specialization, bindings, VW_ARRAY_COUNT(bindings), NULL);
    return vw_pass_create_of(&step->objects, &common,
                             field->model->half_grid ? &vw_shader_update_grid_half : &vw_shader_update_grid,
                             &step->update_grid[index]);
}

enum vw_status vw_step_create(struct vw_radiance_field *field, const struct vw_config *config,
                              struct vw_photo_order *photo_order, struct vw_buffer *pixels, struct vw_buffer *scalars,
                              struct vw_step_passes *step) {
    *step =
        (struct vw_step_passes){.field = field,
                                .objects = {.gpu = field->gpu},
                                .photo_order = photo_order,
                                .pixels = pixels,
                                .scalars = scalars,
                                .rays = config->rays,
                                .padded_rays = vw_model_pad_rays(field->model, config->rays),
                                .chunk_rays = field->model->specialization.chunk_samples / field->model->ray_samples};
    enum vw_status status = create_buffers(step);
    if (!status) status = vw_gradient_create(step, &step->objects, &field->model->specialization, &step->gradient);
    if (!status) status = create_update_passes(step);
    for (uint32_t i = 0; i < field->model->window_count && !status; i++) status = create_update_grid(step, i);
    if (!status) status = vw_effects_create_extras(field->model, step);
    if (status) vw_step_destroy(step);
    return status;
}

void vw_step_destroy(struct vw_step_passes *step) {
    if (step->field) vw_effects_destroy_extras(step->field->model, step);
    vw_gpu_objects_destroy(&step->objects);
}

// Lists the buffers of the training's state. The gradients do not belong to it: they are 0 between steps (the grid's)
// or overwritten (the weights').
uint32_t vw_step_training_state(const struct vw_step_passes *step,
                                struct vw_buffer *buffers[TRAINING_STATE_BUFFERS_MAX]) {
    struct vw_buffer *const state[] = {step->field->params, step->weight_moments, step->grid_moment1,
                                       step->grid_moment2, step->grid_visits};
    uint32_t count = 0;
    for (size_t i = 0; i < VW_ARRAY_COUNT(state); i++)
        if (state[i]) buffers[count++] = state[i]; // a field without grid has no more
    const struct vw_effect_buffers of_effects = vw_step_effect_buffers(step);
    vw_effects_training_state(step->field->model, &of_effects, buffers, &count);
    return count;
}

void vw_step_record_gradients(const struct vw_step_passes *step, struct vw_submission *submission, uint64_t number,
                              uint32_t first_pixel) {
    const struct vw_model *model = step->field->model;
    struct vw_push_rays rays = {
        .first_pixel = first_pixel, .ray_count = step->rays, .key = vw_model_key_of_step(model, number)};
    vw_effects_record_begin(model, &step->effects, submission, number, rays.key);
    vw_submission_dispatch(submission, step->gradient.generate, &rays, sizeof rays, step->padded_rays);
    vw_effects_record_rays(model, &step->effects, step, submission, &rays);
    vw_effects_record_photo(model, &step->effects, submission, 0);
    for (uint32_t first = 0; first < step->padded_rays; first += step->chunk_rays) {
        const struct vw_push_samples chunk = vw_gradient_chunk(step, step->padded_rays, first, rays.key);
        vw_gradient_record_chunk(step, &step->gradient, submission, &chunk);
        const struct vw_field_chunk samples = {&chunk, step->effect_buffers[VW_SLOT_KEPT]};
        vw_effects_record_chunk_gradient(model, &step->effects, submission, &samples);
    }
    vw_gradient_record_end(step, &step->gradient, submission, step->padded_rays);
    vw_effects_record_gradient(model, &step->effects, step, submission, &rays, number);
}

void vw_step_record_update(const struct vw_step_passes *step, struct vw_submission *submission, uint64_t number,
                           float extra) {
    const struct vw_model *model = step->field->model;
    double rate = (1.0 + extra) * vw_model_rate_factor_of_step(model, number);
    struct vw_push_update update = {.count = step->padded_rays,
                                    .step_low = number > INT32_MAX ? INT32_MAX : (uint32_t)number,
                                    .extra = (float)(rate - 1.0)};
    vw_effects_record_update(model, &step->effects, submission, &update);
    update.count = model->moved_columns;
    vw_submission_dispatch(submission, step->update_weights, &update, sizeof update, update.count);
    for (uint32_t i = 0; i < model->window_count; i++) {
        update.count = model->windows[i].pair_count;
        vw_submission_dispatch(submission, step->update_grid[i], &update, sizeof update, update.count);
    }
}

void vw_step_record_loss(const struct vw_step_passes *step, struct vw_submission *submission, uint32_t scalar_row) {
    struct vw_push_reduce push = {.count = step->padded_rays, .scalar_row = scalar_row};
    vw_submission_dispatch(submission, step->reduce_loss, &push, sizeof push, 1);
}

void vw_step_record_passes(const struct vw_step_passes *step, struct vw_submission *submission, uint64_t number,
                           uint32_t first_pixel, uint32_t scalar_row) {
    vw_step_record_gradients(step, submission, number, first_pixel);
    vw_step_record_update(step, submission, number, 0);
    vw_step_record_loss(step, submission, scalar_row); // reads what all passes before it have found
}
