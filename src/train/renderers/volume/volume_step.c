// Passes and buffers of the volume's step: rays, chunk by chunk, to gradients; the update of the grid.
#include <string.h>

#include "base/memory.h"
#include "gpu/shaders.h"
#include "train/device_photos.h"
#include "train/passes.h"
#include "train/pixels.h"
#include "train/renderers/volume/importance.h"
#include "train/renderers/volume/volume.h"

static uint32_t word_bytes(const struct vw_model *model) { return model->specialization.wide_gradient ? 16 : 8; }

uint32_t vw_volume_draw_pixels(const struct vw_step_passes *step, struct vw_submission *submission, uint32_t view,
                               const struct vw_pixel_draw *draw, uint32_t first_pixel) {
    if (!step->photos) return vw_pixels_draw(step->field->scene, view, draw, step->rays, step->drawn);
    const struct vw_push_draw push = vw_device_photos_push(step->photos, view, draw, first_pixel, step->rays);
    vw_submission_dispatch(submission, step->draw_pixels, &push, sizeof push, step->rays);
    return step->rays;
}

enum vw_status vw_volume_create_step_buffers(struct vw_step_passes *step) {
    const struct vw_model *model = step->field->model;
    step->chunk_rays = model->specialization.chunk_samples / model->ray_samples;
    uint64_t chunk = model->specialization.chunk_samples, pairs = model->pair_count, columns = model->partial_columns;
    const struct vw_buffer_row buffers[] = {
        {&step->samples, "samples", 16 * chunk},
        {&step->d_samples, "d_samples", 16 * chunk},
        {&step->weight_partials, "weight_partials", 16 * columns * (chunk / model->specialization.slice_samples)},
        {&step->d_grid, "d_grid", word_bytes(model) * pairs},
        // Without momentum there is no first moment; the slot is declared by the shader, so a stub is bound.
        {&step->grid_moment1, "grid_moment1", pairs && !model->specialization.momentum ? 8 : 8 * pairs},
        {&step->grid_moment2, "grid_moment2", 8 * pairs},
        {&step->grid_visits, "grid_visits", 4 * pairs},
        {&step->places, "sample_places", vw_importance_places_bytes(model, step->chunk_rays)},
    };
    return vw_buffers_create(&step->objects, VW_BUFFER_DEVICE, buffers, VW_ARRAY_COUNT(buffers));
}

// Creates the pass that updates one window of the grid. Passes that write the grid see one window of it, so that each
// binding fits the device's range.
static enum vw_status create_update_grid(struct vw_step_passes *step, uint32_t index) {
    const struct vw_radiance_field *field = step->field;
    const struct vw_grid_window *window = &field->model->windows[index];
    uint64_t first = window->first_pair, pairs = window->pair_count, word = word_bytes(field->model),
             pair = VW_GRID_PAIR_BYTES;
    bool momentum = field->model->specialization.momentum;
    const struct vw_binding bindings[] = {
        {.slot = VW_SLOT_STEP_STATE, .buffer = field->step_state},
        vw_step_overflow_binding(step, VW_OVERFLOW_RENDERER + index),
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
    return vw_pass_create_of(&step->objects, &common, &vw_shader_update_grid, &step->update_grid[index]);
}

enum vw_status vw_volume_create_step_passes(struct vw_step_passes *step) {
    const struct vw_model *model = step->field->model;
    enum vw_status status = vw_gradient_create(step, &step->objects, &model->specialization, &step->gradient);
    if (!status) status = vw_step_create_draw(step, &vw_shader_draw_pixels, NULL);
    for (uint32_t i = 0; i < model->window_count && !status; i++) status = create_update_grid(step, i);
    return status;
}

void vw_volume_training_state(const struct vw_step_passes *step, struct vw_buffer **buffers, uint32_t *count) {
    struct vw_buffer *const state[] = {step->grid_moment1, step->grid_moment2, step->grid_visits};
    for (size_t i = 0; i < VW_ARRAY_COUNT(state); i++)
        if (state[i]) buffers[(*count)++] = state[i]; // a field without grid has none
}

void vw_volume_record_gradients(const struct vw_step_passes *step, struct vw_submission *submission, uint64_t number,
                                const struct vw_push_rays *rays) {
    const struct vw_model *model = step->field->model;
    uint32_t padded_rays = vw_model_pad_rays(model, rays->ray_count);
    vw_submission_dispatch(submission, step->gradient.generate, rays, sizeof *rays, step->padded_rays);
    vw_effects_record_rays(model, &step->effects, step, submission, rays);
    vw_effects_record_photo(model, &step->effects, submission, 0);
    for (uint32_t first = 0; first < padded_rays; first += step->chunk_rays) {
        const struct vw_push_samples chunk = vw_gradient_chunk(step, padded_rays, first, rays->key);
        vw_gradient_record_chunk(step, &step->gradient, submission, &chunk);
        vw_effects_record_chunk_gradient(model, &step->effects, submission, &chunk);
    }
    vw_gradient_record_end(step, &step->gradient, submission, padded_rays);
    vw_effects_record_gradient(model, &step->effects, step, submission, rays, number);
}

void vw_volume_record_update(const struct vw_step_passes *step, struct vw_submission *submission,
                             struct vw_push_update update) {
    const struct vw_model *model = step->field->model;
    for (uint32_t i = 0; i < model->window_count; i++) {
        update.count = model->windows[i].pair_count;
        vw_submission_dispatch(submission, step->update_grid[i], &update, sizeof update, update.count);
    }
}
