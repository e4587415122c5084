#include "train/step.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "gpu/compute.h"
#include "gpu/shaders.h"
#include "train/device_photos.h"
#include "train/effects/effects.h"
#include "train/passes.h"
#include "train/renderers/registry.h"

static const uint64_t OVERFLOW_BYTES = 4 * VW_OVERFLOW_STRIDE;

struct vw_binding vw_step_overflow_binding(const struct vw_step_passes *step, uint32_t flag) {
    return (struct vw_binding){.slot = VW_SLOT_OVERFLOW,
                               .buffer = step->overflow,
                               .offset_bytes = flag * OVERFLOW_BYTES,
                               .size_bytes = OVERFLOW_BYTES};
}

static struct vw_effect_buffers effect_buffers_of(const struct vw_step_passes *step) {
    return (struct vw_effect_buffers){step->field->params, step->field->effect_buffers, step->effect_buffers};
}

void vw_step_bind(const struct vw_step_passes *step, struct vw_binding *bindings, uint32_t *count) {
    const struct vw_model *model = step->field->model;
    const struct vw_effect_buffers of_effects = effect_buffers_of(step);
    const struct vw_binding own[] = {
        {.slot = VW_SLOT_OVERFLOW, .buffer = step->overflow},
        {.slot = VW_SLOT_PIXELS, .buffer = step->pixels},
        {.slot = VW_SLOT_SCALARS, .buffer = step->scalars},
        {.slot = VW_SLOT_RAYS, .buffer = step->ray_buffer},
        {.slot = VW_SLOT_RAY_LOSS, .buffer = step->ray_loss},
        {.slot = VW_SLOT_D_WEIGHTS, .buffer = step->d_weights},
        {.slot = VW_SLOT_WEIGHT_MOMENTS, .buffer = step->weight_moments},
    };
    memcpy(bindings + *count, own, sizeof own);
    *count += VW_ARRAY_COUNT(own);
    vw_field_bind(step->field, true, bindings, count);
    if (model->renderer->step->bind) model->renderer->step->bind(step, bindings, count);
    vw_effects_bind(model, &of_effects, bindings, count);
}

static enum vw_status create_generate(const struct vw_model *model, struct vw_gpu_objects *objects,
                                      const struct vw_pass_params *common, struct vw_pass **generate) {
    struct vw_binding bindings[VW_SLOT_COUNT];
    struct vw_pass_params params = *common;
    memcpy(bindings, common->bindings, common->binding_count * sizeof *bindings);
    for (uint32_t i = 0; i < common->binding_count; i++)
        if (bindings[i].slot == VW_SLOT_STEP_STATE) bindings[i].unused = !vw_effects_know_photos(model);
    params.bindings = bindings;
    return vw_pass_create_of(objects, &params, &vw_shader_generate_rays, generate);
}

enum vw_status vw_ray_passes_create(const struct vw_model *model, struct vw_gpu_objects *objects,
                                    const struct vw_pass_params *common, const struct vw_specialization *specialization,
                                    struct vw_ray_passes *passes) {
    enum vw_status status = create_generate(model, objects, common, &passes->generate);
    if (status || !specialization->effect_sky) return status;
    return vw_pass_create_of(objects, common, &vw_shader_gradient_sky, &passes->gradient_sky);
}

void vw_ray_passes_record_end(const struct vw_ray_passes *passes, struct vw_submission *submission, uint32_t rays) {
    struct vw_push_reduce push = {.count = rays};
    if (passes->gradient_sky)
        vw_submission_dispatch(submission, passes->gradient_sky, &push, sizeof push, 64ull * VW_SKY_COLUMNS);
}

static enum vw_status create_buffers(struct vw_step_passes *step) {
    const struct vw_model *model = step->field->model;
    const struct vw_buffer_row buffers[] = {
        {&step->ray_buffer, "rays", sizeof(struct vw_ray) * step->padded_rays},
        {&step->overflow, "overflow", OVERFLOW_BYTES * (VW_OVERFLOW_RENDERER + model->renderer_flags)},
        {&step->ray_loss, "ray_loss", 4 * (uint64_t)step->padded_rays},
        {&step->d_weights, "d_weights", 16 * (uint64_t)model->moved_columns},
        {&step->weight_moments, "weight_moments", 2 * 16 * (uint64_t)model->moved_columns},
    };
    enum vw_status status = vw_buffers_create(&step->objects, VW_BUFFER_DEVICE, buffers, VW_ARRAY_COUNT(buffers));
    if (!status) status = model->renderer->step->create_buffers(step);
    uint64_t pixels = vw_buffer_size_bytes(step->pixels) / sizeof(struct vw_pixel);
    return !status ? vw_effects_create_buffers(model, &step->objects, false, step->padded_rays, pixels,
                                               step->effect_buffers)
                   : status;
}

static enum vw_status create_update_passes(struct vw_step_passes *step) {
    const struct vw_model *model = step->field->model;
    struct vw_binding bindings[VW_SLOT_COUNT];
    uint32_t count = 0;
    vw_step_bind(step, bindings, &count); // its first binding is the one of flags
    const struct vw_pass_params common = vw_pass_params_of(&model->specialization, bindings, count, NULL);
    enum vw_status status = vw_pass_create_of(&step->objects, &common, &vw_shader_reduce_loss, &step->reduce_loss);
    bindings[0] = vw_step_overflow_binding(step, VW_OVERFLOW_WEIGHTS);
    if (!status && model->moved_columns)
        status = vw_pass_create_of(&step->objects, &common, &vw_shader_update_weights, &step->update_weights);
    bindings[0] = vw_step_overflow_binding(step, VW_OVERFLOW_PHOTOS);
    return !status ? vw_effects_create_passes(model, &step->objects, &common, true, &step->effects) : status;
}

static enum vw_status allocate_places(struct vw_step_passes *step) {
    uint64_t places = vw_buffer_size_bytes(step->pixels) / (step->rays * sizeof *step->drawn);
    if (!step->photos) step->drawn = vw_allocate(step->rays, sizeof *step->drawn);
    step->counted = vw_allocate(places, sizeof *step->counted);
    if ((!step->drawn && !step->photos) || !step->counted) return VW_ERROR_MEMORY;
    for (uint64_t i = 0; i < places; i++) step->counted[i] = step->rays;
    return VW_OK;
}

enum vw_status vw_step_create(struct vw_radiance_field *field, struct vw_photo_order *photo_order,
                              struct vw_buffer *pixels, struct vw_buffer *scalars, struct vw_device_photos *photos,
                              struct vw_step_passes *step) {
    uint32_t rays = field->model->config->rays;
    *step = (struct vw_step_passes){.field = field,
                                    .objects = {.gpu = field->gpu},
                                    .photo_order = photo_order,
                                    .pixels = pixels,
                                    .scalars = scalars,
                                    .photos = photos,
                                    .rays = rays,
                                    .padded_rays = vw_model_pad_rays(field->model, rays)};
    enum vw_status status = allocate_places(step);
    if (!status) status = create_buffers(step);
    if (!status) status = field->model->renderer->step->create_passes(step);
    if (!status) status = create_update_passes(step);
    if (!status) status = vw_effects_create_extras(field->model, step);
    if (status) vw_step_destroy(step);
    return status;
}

void vw_step_destroy(struct vw_step_passes *step) {
    if (step->field) vw_effects_destroy_extras(step->field->model, step);
    if (step->of_renderer && step->field->model->renderer->step->destroy)
        step->field->model->renderer->step->destroy(step);
    vw_gpu_objects_destroy(&step->objects);
    free(step->of_renderer);
    free(step->drawn);
    free(step->counted);
    step->of_renderer = NULL; // who could not create a step destroys it once more
    step->drawn = NULL;
    step->counted = NULL;
}

// Lists the buffers of the training's state. The gradients do not belong to it: they are 0 between steps (the grid's)
// or overwritten (the weights').
uint32_t vw_step_training_state(const struct vw_step_passes *step,
                                struct vw_buffer *buffers[TRAINING_STATE_BUFFERS_MAX]) {
    uint32_t count = 0;
    buffers[count++] = step->field->params;
    if (step->weight_moments) buffers[count++] = step->weight_moments;
    step->field->model->renderer->step->training_state(step, buffers, &count);
    const struct vw_effect_buffers of_effects = effect_buffers_of(step);
    vw_effects_training_state(step->field->model, &of_effects, buffers, &count);
    return count;
}

enum vw_status vw_step_create_draw(struct vw_step_passes *step, const struct vw_shader *shader,
                                   struct vw_buffer *tiles) {
    if (!step->photos) return VW_OK;
    const struct vw_binding bindings[] = {{.slot = VW_SLOT_PHOTOS, .buffer = step->photos->buffer},
                                          {.slot = VW_SLOT_PIXELS, .buffer = step->pixels},
                                          {.slot = VW_SLOT_SPLAT_TILES, .buffer = tiles}};
    const struct vw_pass_params common =
        vw_pass_params_of(&step->field->model->specialization, bindings, VW_ARRAY_COUNT(bindings), NULL);
    return vw_pass_create_of(&step->objects, &common, shader, &step->draw_pixels);
}

enum vw_status vw_step_take_photos(const struct vw_step_passes *step, const uint32_t *views, uint32_t count) {
    enum vw_status status = vw_scene_decode(step->field->scene, views, count);
    return !status && step->photos ? vw_device_photos_keep(step->photos, views, count) : status;
}

void vw_step_draw_pixels(const struct vw_step_passes *step, struct vw_submission *submission, uint32_t view,
                         const struct vw_pixel_draw *draw, uint32_t first_pixel) {
    uint32_t counted = step->field->model->renderer->step->draw_pixels(step, submission, view, draw, first_pixel);
    step->counted[first_pixel / step->rays] = counted ? counted : 1; // a step has rays, if only one without weight
    if (step->photos) return;
    struct vw_pixel *uploaded = (struct vw_pixel *)vw_buffer_map(step->pixels) + first_pixel;
    vw_effects_draw_pixels(step->field->model, step, view, first_pixel);
    memcpy(uploaded, step->drawn, step->rays * sizeof *uploaded);
}

uint32_t vw_step_counted_rays(const struct vw_step_passes *step, uint32_t first_pixel) {
    return step->counted[first_pixel / step->rays];
}

static uint32_t padded_rays(const struct vw_step_passes *step, uint32_t first_pixel) {
    return vw_model_pad_rays(step->field->model, vw_step_counted_rays(step, first_pixel));
}

void vw_step_record_gradients(const struct vw_step_passes *step, struct vw_submission *submission, uint64_t number,
                              uint32_t first_pixel) {
    const struct vw_model *model = step->field->model;
    struct vw_push_rays rays = {.first_pixel = first_pixel,
                                .ray_count = vw_step_counted_rays(step, first_pixel),
                                .key = vw_model_key_of_step(model, number)};
    model->renderer->step->record_gradients(step, submission, number, &rays);
}

void vw_step_record_update(const struct vw_step_passes *step, struct vw_submission *submission, uint64_t number,
                           uint32_t first_pixel, float extra) {
    const struct vw_model *model = step->field->model;
    double rate = (1.0 + extra) * vw_model_rate_factor_of_step(model, number);
    struct vw_push_update update = {.count = padded_rays(step, first_pixel),
                                    .step_low = number > INT32_MAX ? INT32_MAX : (uint32_t)number,
                                    .extra = (float)(rate - 1.0),
                                    .adam = vw_adam_of(&model->specialization)};
    vw_effects_record_update(model, &step->effects, submission, &update);
    update.count = model->moved_columns;
    if (step->update_weights)
        vw_submission_dispatch(submission, step->update_weights, &update, sizeof update, update.count);
    model->renderer->step->record_update(step, submission, update);
}

void vw_step_record_loss(const struct vw_step_passes *step, struct vw_submission *submission, uint32_t first_pixel,
                         uint32_t scalar_row) {
    struct vw_push_reduce push = {.count = padded_rays(step, first_pixel), .scalar_row = scalar_row};
    vw_submission_dispatch(submission, step->reduce_loss, &push, sizeof push, 1);
}

void vw_step_record_clear(const struct vw_step_passes *step, struct vw_submission *submission) {
    struct vw_push_reduce push = {.scalar_row = VW_NO_ROW};
    vw_submission_dispatch(submission, step->reduce_loss, &push, sizeof push, 1);
}

void vw_step_record_passes(const struct vw_step_passes *step, struct vw_submission *submission, uint64_t number,
                           uint32_t first_pixel, uint32_t scalar_row) {
    vw_step_record_gradients(step, submission, number, first_pixel);
    vw_step_record_update(step, submission, number, first_pixel, 0);
    vw_step_record_loss(step, submission, first_pixel, scalar_row); // reads what all passes before it have found
}
