// Passes and buffers of the volume's step: rays, chunk by chunk, to gradients; the update of the grid.
#include <string.h>

#include "base/memory.h"
#include "gpu/shaders.h"
#include "train/device_photos.h"
#include "train/passes.h"
#include "train/pixels.h"
#include "train/renderers/volume/volume.h"

static uint32_t word_bytes(const struct vw_model *model) { return model->specialization.wide_gradient ? 16 : 8; }

static uint32_t draw_pixels(const struct vw_step_passes *step, struct vw_submission *submission, uint32_t view,
                            const struct vw_pixel_draw *draw, uint32_t first_pixel) {
    if (!step->photos) return vw_pixels_draw(step->field->scene, view, draw, step->rays, step->drawn);
    const struct vw_push_draw push = vw_device_photos_push(step->photos, view, draw, first_pixel, step->rays);
    vw_submission_dispatch(submission, step->draw_pixels, &push, sizeof push, step->rays);
    return step->rays;
}

static enum vw_status create_step_buffers(struct vw_step_passes *step) {
    const struct vw_model *model = step->field->model;
    const struct vw_volume_model *layout = vw_volume_of(model);
    struct vw_volume_step *volume = step->of_renderer = vw_allocate(1, sizeof *volume);
    if (!volume) return VW_ERROR_MEMORY;
    volume->chunk_rays = model->specialization.chunk_samples / layout->ray_samples;
    uint64_t chunk = model->specialization.chunk_samples, pairs = layout->pair_count, columns = layout->partial_columns;
    const struct vw_buffer_row buffers[] = {
        {&volume->samples, "samples", 16 * chunk},
        {&volume->d_samples, "d_samples", 16 * chunk},
        {&volume->weight_partials, "weight_partials", 16 * columns * (chunk / model->specialization.slice_samples)},
        {&volume->d_grid, "d_grid", word_bytes(model) * pairs},
        // Without momentum there is no first moment; the slot is declared by the shader, so a stub is bound.
        {&volume->grid_moment1, "grid_moment1", pairs && !model->specialization.momentum ? 8 : 8 * pairs},
        {&volume->grid_moment2, "grid_moment2", 8 * pairs},
        {&volume->grid_visits, "grid_visits", 4 * pairs},
        {&volume->places, "sample_places", vw_importance_places_bytes(model, volume->chunk_rays)},
    };
    return vw_buffers_create(&step->objects, VW_BUFFER_DEVICE, buffers, VW_ARRAY_COUNT(buffers));
}

// Creates the pass that updates one window of the grid. Passes that write the grid see one window of it, so that each
// binding fits the device's range.
static enum vw_status create_update_grid(struct vw_step_passes *step, uint32_t index) {
    const struct vw_radiance_field *field = step->field;
    struct vw_volume_step *volume = step->of_renderer;
    const struct vw_volume_model *layout = vw_volume_of(field->model);
    const struct vw_grid_window *window = &layout->windows[index];
    uint64_t first = window->first_pair, pairs = window->pair_count, word = word_bytes(field->model),
             pair = VW_GRID_PAIR_BYTES;
    bool momentum = field->model->specialization.momentum;
    const struct vw_binding bindings[] = {
        {.slot = VW_SLOT_STEP_STATE, .buffer = field->step_state},
        vw_step_overflow_binding(step, VW_OVERFLOW_RENDERER + index),
        {.slot = VW_SLOT_GRID,
         .buffer = field->params,
         .offset_bytes = layout->grid.offset_bytes + pair * first,
         .size_bytes = pair * pairs},
        {.slot = VW_SLOT_D_GRID, .buffer = volume->d_grid, .offset_bytes = word * first, .size_bytes = word * pairs},
        {.slot = VW_SLOT_GRID_MOMENT1,
         .buffer = volume->grid_moment1,
         .offset_bytes = momentum ? 8 * first : 0,
         .size_bytes = momentum ? 8 * pairs : 8},
        {.slot = VW_SLOT_GRID_MOMENT2,
         .buffer = volume->grid_moment2,
         .offset_bytes = 8 * first,
         .size_bytes = 8 * pairs},
        {.slot = VW_SLOT_GRID_VISITS,
         .buffer = volume->grid_visits,
         .offset_bytes = 4 * first,
         .size_bytes = 4 * pairs},
    };
    const struct vw_pass_params common =
        vw_pass_params_of(&field->model->specialization, bindings, VW_ARRAY_COUNT(bindings), NULL);
    return vw_pass_create_of(&step->objects, &common, &vw_shader_update_grid, &volume->update_grid[index]);
}

static enum vw_status create_step_passes(struct vw_step_passes *step) {
    const struct vw_model *model = step->field->model;
    enum vw_status status =
        vw_gradient_create(step, &step->objects, &model->specialization, &vw_volume_step_of(step)->gradient);
    if (!status) status = vw_step_create_draw(step, &vw_shader_draw_pixels, NULL);
    for (uint32_t i = 0; i < vw_volume_of(model)->window_count && !status; i++) status = create_update_grid(step, i);
    return status;
}

static void training_state(const struct vw_step_passes *step, struct vw_buffer **buffers, uint32_t *count) {
    const struct vw_volume_step *volume = vw_volume_step_of(step);
    struct vw_buffer *const state[] = {volume->grid_moment1, volume->grid_moment2, volume->grid_visits};
    for (size_t i = 0; i < VW_ARRAY_COUNT(state); i++)
        if (state[i]) buffers[(*count)++] = state[i]; // a field without grid has none
}

static void record_gradients(const struct vw_step_passes *step, struct vw_submission *submission, uint64_t number,
                             const struct vw_push_rays *rays) {
    const struct vw_model *model = step->field->model;
    const struct vw_volume_step *volume = vw_volume_step_of(step);
    uint32_t padded_rays = vw_model_pad_rays(model, rays->ray_count);
    vw_submission_dispatch(submission, volume->gradient.of_rays.generate, rays, sizeof *rays, step->padded_rays);
    vw_effects_record_rays(model, &step->effects, step, submission, rays);
    vw_effects_record_photo(model, &step->effects, submission, 0);
    for (uint32_t first = 0; first < padded_rays; first += volume->chunk_rays) {
        const struct vw_push_samples chunk = vw_gradient_chunk(step, padded_rays, first, rays->key);
        vw_gradient_record_chunk(step, &volume->gradient, submission, &chunk);
        vw_effects_record_chunk_gradient(model, &step->effects, submission, &chunk);
    }
    vw_ray_passes_record_end(&volume->gradient.of_rays, submission, padded_rays);
    vw_effects_record_gradient(model, &step->effects, step, submission, rays, number);
}

static void record_update(const struct vw_step_passes *step, struct vw_submission *submission,
                          struct vw_push_update update) {
    const struct vw_volume_model *layout = vw_volume_of(step->field->model);
    for (uint32_t i = 0; i < layout->window_count; i++) {
        update.count = layout->windows[i].pair_count;
        vw_submission_dispatch(submission, vw_volume_step_of(step)->update_grid[i], &update, sizeof update,
                               update.count);
    }
}

// ---- From rays to gradients -----------------------------------------------------------------------------------------

static void bind_step(const struct vw_step_passes *step, struct vw_binding *bindings, uint32_t *count) {
    const struct vw_volume_step *volume = vw_volume_step_of(step);
    const struct vw_binding own[] = {
        {.slot = VW_SLOT_FIELD, .buffer = volume->samples},
        {.slot = VW_SLOT_D_FIELD, .buffer = volume->d_samples},
        {.slot = VW_SLOT_WEIGHT_PARTIALS, .buffer = volume->weight_partials},
        {.slot = VW_SLOT_PLACES, .buffer = volume->places, .unused = !volume->places},
    };
    memcpy(bindings + *count, own, sizeof own);
    *count += VW_ARRAY_COUNT(own);
}

static const struct vw_shader *backward_shader(const struct vw_model *model, const struct vw_specialization *s,
                                               bool transient) {
    bool effects = vw_model_has_ray_effects(model, s);
    if (transient) return effects ? &vw_shader_backward_transient_effects : &vw_shader_backward_transient;
    return effects ? &vw_shader_backward_rays_effects : &vw_shader_backward_rays;
}

enum vw_status vw_gradient_create(const struct vw_step_passes *step, struct vw_gpu_objects *objects,
                                  const struct vw_specialization *specialization, struct vw_gradient_passes *gradient) {
    *gradient =
        (struct vw_gradient_passes){.specialization = *specialization, .field = {.specialization = *specialization}};
    const struct vw_model *model = step->field->model;
    struct vw_binding bindings[VW_SLOT_COUNT];
    uint32_t count = 0;
    vw_step_bind(step, bindings, &count);
    const struct vw_field_pass_params field = {.objects = objects,
                                               .common = vw_pass_params_of(specialization, bindings, count, NULL),
                                               .d_grid = vw_volume_step_of(step)->d_grid,
                                               .backward = true};
    enum vw_status status = vw_ray_passes_create(model, objects, &field.common, specialization, &gradient->of_rays);
    if (!status)
        status = vw_pass_create_of(objects, &field.common,
                                   backward_shader(model, specialization, specialization->effect_transient),
                                   &gradient->backward_rays);
    // Slopes that are given are of the field's colours.
    const struct vw_shader *coarse =
        specialization->loss == LOSS_GIVEN ? NULL : backward_shader(model, specialization, false);
    if (!status) status = vw_importance_create(step->field, &field, specialization, coarse, &gradient->importance);
    return !status ? vw_volume_of(model)->kind->create_passes(step->field, &field, &gradient->field) : status;
}

void vw_gradient_record_back(const struct vw_step_passes *step, const struct vw_gradient_passes *gradient,
                             struct vw_submission *submission, const struct vw_push_samples *chunk) {
    const struct vw_model *model = step->field->model;
    const struct vw_specialization *s = &gradient->specialization;
    vw_submission_dispatch(submission, gradient->backward_rays, chunk, sizeof *chunk,
                           (uint64_t)chunk->ray_count * (s->effect_transient ? 1 : s->ray_lanes));
    vw_volume_of(model)->kind->record_backward(model, &gradient->field, submission, chunk);
}

void vw_gradient_record_chunk(const struct vw_step_passes *step, const struct vw_gradient_passes *gradient,
                              struct vw_submission *submission, const struct vw_push_samples *chunk) {
    const struct vw_model *model = step->field->model;
    vw_importance_record(model, &gradient->importance, submission, chunk);
    vw_volume_of(model)->kind->record_forward(model, &gradient->field, submission, chunk);
    vw_gradient_record_back(step, gradient, submission, chunk);
}

struct vw_push_samples vw_gradient_chunk(const struct vw_step_passes *step, uint32_t rays, uint32_t first,
                                         vw_uint4 key) {
    uint32_t left = rays - first, chunk = vw_volume_step_of(step)->chunk_rays;
    return (struct vw_push_samples){.first_ray = first, .ray_count = left < chunk ? left : chunk, .key = key};
}

const struct vw_renderer_step vw_volume_renderer_step = {
    .draw_pixels = draw_pixels,
    .create_buffers = create_step_buffers,
    .create_passes = create_step_passes,
    .bind = bind_step,
    .training_state = training_state,
    .record_gradients = record_gradients,
    .record_update = record_update,
};
