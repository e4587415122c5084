#include "train/step.h"

#include <stddef.h>

#include "base/memory.h"
#include "gpu/compute.h"
#include "gpu/shaders.h"
#include "train/effects/consistency.h"

static uint32_t word_bytes(const struct vw_model *model) { return model->specialization.wide_gradient ? 16 : 8; }

// Which flag of `overflow` a pass sets: the grid's windows follow one another.
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
    const struct {
        struct vw_buffer **buffer;
        struct vw_buffer_params params;
    } buffers[] = {
        {&step->ray_buffer, {.name = "rays", .size_bytes = sizeof(struct vw_ray) * step->padded_rays}},
        {&step->samples, {.name = "samples", .size_bytes = 16 * chunk}},
        {&step->d_samples, {.name = "d_samples", .size_bytes = 16 * chunk}},
        {&step->overflow, {.name = "overflow", .size_bytes = OVERFLOW_BYTES * (OVERFLOW_GRID + model->window_count)}},
        {&step->ray_loss, {.name = "ray_loss", .size_bytes = 4 * (uint64_t)step->padded_rays}},
        {&step->weight_partials,
         {.name = "weight_partials", .size_bytes = 16 * columns * (chunk / model->specialization.slice_samples)}},
        {&step->d_weights, {.name = "d_weights", .size_bytes = 16 * moved}},
        {&step->weight_moments, {.name = "weight_moments", .size_bytes = 2 * 16 * moved}},
        {&step->d_sky, {.name = "d_sky", .size_bytes = model->sky.size_bytes ? 16 * (uint64_t)step->padded_rays : 0}},
        {&step->d_grid, {.name = "d_grid", .size_bytes = word_bytes(model) * pairs}},
        // Without momentum there is no first moment; the slot is declared by the shader, so a stub is bound.
        {&step->grid_moment1,
         {.name = "grid_moment1", .size_bytes = pairs && !model->specialization.momentum ? 8 : 8 * pairs}},
        {&step->grid_moment2, {.name = "grid_moment2", .size_bytes = 8 * pairs}},
        {&step->grid_visits, {.name = "grid_visits", .size_bytes = 4 * pairs}},
    };
    enum vw_status status = VW_OK;
    for (size_t i = 0; i < VW_ARRAY_COUNT(buffers) && !status; i++) // an effect that is off has no bytes
        if (buffers[i].params.size_bytes)
            status = vw_buffer_create(step->field->gpu, &buffers[i].params, buffers[i].buffer);
    if (!status) status = vw_importance_create_places(step->field, step->chunk_rays, &step->places);
    if (!status && model->specialization.effect_occupancy)
        status = vw_occupancy_create_buffers(step->field, &step->occupancy);
    return status;
}

static enum vw_status create_encoder_passes(struct vw_step_passes *step, const struct vw_binding *bindings,
                                            uint32_t count) {
    const struct vw_pass_params params = {.specialization = (const uint32_t *)&step->field->model->specialization,
                                          .specialization_count = VW_SPECIALIZATION_COUNT,
                                          .bindings = bindings,
                                          .binding_count = count};
    enum vw_status status = vw_encoder_create_passes(step->field->gpu, &step->field->encoder, &params, &step->encoder);
    return !status ? vw_encoder_gradient_create_passes(step->field->gpu, &params, &vw_shader_spread_photo,
                                                       &step->encoder_gradient)
                   : status;
}

static enum vw_status create_update_passes(struct vw_step_passes *step) {
    const struct vw_specialization *specialization = &step->field->model->specialization;
    struct vw_binding bindings[VW_SLOT_COUNT];
    uint32_t count = 0;
    vw_step_bind(step, bindings, &count); // its first binding is the one of flags
    enum vw_status status =
        vw_step_create_pass(step, specialization, &vw_shader_reduce_loss, bindings, count, &step->reduce_loss);
    if (!status && step->occupancy.kept)
        status = vw_occupancy_create_passes(step->field, bindings, count, &step->occupancy);
    bindings[0] = overflow_binding(step, OVERFLOW_WEIGHTS);
    if (!status)
        status = vw_step_create_pass(step, specialization, &vw_shader_update_weights, bindings, count,
                                     &step->update_weights);
    bindings[0] = overflow_binding(step, OVERFLOW_PHOTOS);
    if (!status) status = vw_appearance_create_passes(step->field, bindings, count, &step->appearance);
    if (!status) status = vw_transient_create_passes(step->field, bindings, count, &step->transient);
    if (!status) status = vw_pose_create_passes(step->field, bindings, count, &step->pose);
    if (!status) status = create_encoder_passes(step, bindings, count);
    return !status ? vw_visibility_create_passes(step->field, bindings, count, &step->visibility) : status;
}

// The passes that write the grid see one window of it, so that each binding fits the device's range.
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
    return vw_step_create_pass(step, &field->model->specialization,
                               field->model->half_grid ? &vw_shader_update_grid_half : &vw_shader_update_grid, bindings,
                               VW_ARRAY_COUNT(bindings), &step->update_grid[index]);
}

enum vw_status vw_step_create(struct vw_radiance_field *field, const struct vw_config *config,
                              struct vw_photo_order *schedule, struct vw_buffer *pixels, struct vw_buffer *scalars,
                              struct vw_step_passes *step) {
    *step =
        (struct vw_step_passes){.field = field,
                                .schedule = schedule,
                                .pixels = pixels,
                                .scalars = scalars,
                                .rays = config->rays,
                                .padded_rays = vw_model_pad_rays(field->model, config->rays),
                                .chunk_rays = field->model->specialization.chunk_samples / field->model->ray_samples};
    enum vw_status status = create_buffers(step);
    if (!status) status = vw_appearance_create_buffers(field, step->padded_rays, &step->appearance);
    if (!status) status = vw_visibility_create_buffers(field, step->padded_rays, &step->visibility);
    if (!status) status = vw_transient_create_buffers(field, &step->transient);
    if (!status) status = vw_pose_create_buffers(field, step->padded_rays, &step->pose);
    if (!status) status = vw_encoder_gradient_create_buffers(field->gpu, field->model, &step->encoder_gradient);
    if (!status) status = vw_gradient_create(step, &field->model->specialization, &step->gradient);
    if (!status) status = create_update_passes(step);
    for (uint32_t i = 0; i < field->model->window_count && !status; i++) status = create_update_grid(step, i);
    if (!status) status = vw_consistency_create(step, &step->consistency);
    if (status) vw_step_destroy(step);
    return status;
}

void vw_step_destroy(struct vw_step_passes *step) {
    vw_consistency_destroy(&step->consistency);
    vw_gradient_destroy(&step->gradient);
    vw_pass_destroy(&step->reduce_loss);
    vw_pass_destroy(&step->update_weights);
    for (size_t i = 0; i < VW_LEVELS_MAX; i++) vw_pass_destroy(&step->update_grid[i]);
    vw_occupancy_destroy(&step->occupancy);
    struct vw_buffer **buffers[] = {
        &step->ray_buffer,      &step->samples,     &step->d_samples,      &step->ray_loss, &step->overflow,
        &step->weight_partials, &step->d_weights,   &step->weight_moments, &step->d_grid,   &step->grid_moment1,
        &step->grid_moment2,    &step->grid_visits, &step->d_sky,          &step->places};
    for (size_t i = 0; i < VW_ARRAY_COUNT(buffers); i++) vw_buffer_destroy(buffers[i]);
    vw_appearance_destroy(&step->appearance);
    vw_visibility_destroy(&step->visibility);
    vw_transient_destroy(&step->transient);
    vw_pose_destroy(&step->pose);
    vw_encoder_destroy_passes(&step->encoder);
    vw_encoder_gradient_destroy(&step->encoder_gradient);
}

// The gradients are not among them: they are 0 between steps (the grid's) or overwritten (the weights').
uint32_t vw_step_training_state(const struct vw_step_passes *step,
                                struct vw_buffer *buffers[TRAINING_STATE_BUFFERS_MAX]) {
    struct vw_buffer *const state[] = {step->field->params, step->weight_moments, step->grid_moment1,
                                       step->grid_moment2, step->grid_visits};
    uint32_t count = 0;
    for (size_t i = 0; i < VW_ARRAY_COUNT(state); i++)
        if (state[i]) buffers[count++] = state[i]; // a field without grid has no more
    vw_appearance_training_state(&step->appearance, buffers, &count);
    vw_visibility_training_state(&step->visibility, buffers, &count);
    vw_transient_training_state(&step->transient, buffers, &count);
    vw_pose_training_state(&step->pose, buffers, &count);
    if (step->field->occupancy) buffers[count++] = step->field->occupancy;
    return count;
}

void vw_step_record_appearance(const struct vw_step_passes *step, struct vw_submission *batch) {
    vw_appearance_record_forward(&step->appearance, step->field->model, batch);
    vw_encoder_record_forward(&step->encoder, batch, 0);
}

void vw_step_record_gradients(const struct vw_step_passes *step, struct vw_submission *batch, uint64_t number,
                              uint32_t first_pixel) {
    struct vw_push_rays rays = {
        .first_pixel = first_pixel, .ray_count = step->rays, .key = vw_model_key_of_step(step->field->model, number)};
    if (step->occupancy.kept) vw_occupancy_record_refresh(&step->occupancy, batch, number, rays.key);
    vw_submission_dispatch(batch, step->gradient.generate, &rays, sizeof rays, step->padded_rays);
    vw_consistency_record_rays(step->consistency, batch, &rays);
    vw_step_record_appearance(step, batch);
    vw_visibility_record_forward(&step->visibility, batch, &rays, step->padded_rays);
    for (uint32_t first = 0; first < step->padded_rays; first += step->chunk_rays) {
        const struct vw_push_samples chunk = vw_gradient_chunk(step, step->padded_rays, first, rays.key);
        vw_gradient_record_chunk(step, &step->gradient, batch, &chunk);
        vw_pose_record_chunk(&step->pose, step->field->model, batch,
                             &(struct vw_field_chunk){&chunk, step->occupancy.kept});
    }
    vw_gradient_record_sky(&step->gradient, batch, step->padded_rays);
    vw_visibility_record_gradients(&step->visibility, batch, &rays, step->padded_rays);
    vw_encoder_gradient_record(&step->encoder_gradient, NULL, batch);
    vw_consistency_record_gradients(step, batch, number);
}

void vw_step_record_update(const struct vw_step_passes *step, struct vw_submission *batch, uint64_t number,
                           float extra) {
    const struct vw_model *model = step->field->model;
    double rate = (1.0 + extra) * vw_model_rate_of_step(model, number);
    struct vw_push_update update = {.count = model->moved_columns,
                                    .step_low = number > INT32_MAX ? INT32_MAX : (uint32_t)number,
                                    .extra = (float)(rate - 1.0)};
    vw_appearance_record_update(&step->appearance, batch, update, step->padded_rays);
    vw_visibility_record_update(&step->visibility, batch, &update);
    vw_transient_record_update(&step->transient, batch, update);
    vw_pose_record_update(&step->pose, batch, update, step->padded_rays);
    vw_submission_dispatch(batch, step->update_weights, &update, sizeof update, update.count);
    for (uint32_t i = 0; i < model->window_count; i++) {
        update.count = model->windows[i].pair_count;
        vw_submission_dispatch(batch, step->update_grid[i], &update, sizeof update, update.count);
    }
}

void vw_step_record_loss(const struct vw_step_passes *step, struct vw_submission *batch, uint32_t scalar_row) {
    struct vw_push_reduce push = {.count = step->padded_rays, .scalar_row = scalar_row};
    vw_submission_dispatch(batch, step->reduce_loss, &push, sizeof push, 1);
}

void vw_step_record_passes(const struct vw_step_passes *step, struct vw_submission *batch, uint64_t number,
                           uint32_t first_pixel, uint32_t scalar_row) {
    vw_step_record_gradients(step, batch, number, first_pixel);
    vw_step_record_update(step, batch, number, 0);
    vw_step_record_loss(step, batch, scalar_row); // reads what all passes before it have found
}
