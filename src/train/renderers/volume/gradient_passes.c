#include "train/step_passes.h"

#include <string.h>

#include "base/memory.h"
#include "gpu/shaders.h"
#include "train/passes.h"

struct vw_effect_buffers vw_step_effect_buffers(const struct vw_step_passes *step) {
    return (struct vw_effect_buffers){step->field->params, step->field->effect_buffers, step->effect_buffers};
}

void vw_step_bind(const struct vw_step_passes *step, struct vw_binding *bindings, uint32_t *count) {
    const struct vw_binding own[] = {
        {.slot = VW_SLOT_OVERFLOW, .buffer = step->overflow},
        {.slot = VW_SLOT_PIXELS, .buffer = step->pixels},
        {.slot = VW_SLOT_SCALARS, .buffer = step->scalars},
        {.slot = VW_SLOT_RAYS, .buffer = step->ray_buffer},
        {.slot = VW_SLOT_FIELD, .buffer = step->samples},
        {.slot = VW_SLOT_D_FIELD, .buffer = step->d_samples},
        {.slot = VW_SLOT_RAY_LOSS, .buffer = step->ray_loss},
        {.slot = VW_SLOT_WEIGHT_PARTIALS, .buffer = step->weight_partials},
        {.slot = VW_SLOT_D_WEIGHTS, .buffer = step->d_weights},
        {.slot = VW_SLOT_WEIGHT_MOMENTS, .buffer = step->weight_moments},
    };
    memcpy(bindings + *count, own, sizeof own);
    *count += VW_ARRAY_COUNT(own);
    vw_field_bind(step->field, true, bindings, count);
    bindings[(*count)++] = (struct vw_binding){.slot = VW_SLOT_PLACES, .buffer = step->places, .unused = !step->places};
    const struct vw_effect_buffers of_effects = vw_step_effect_buffers(step);
    vw_effects_bind(step->field->model, &of_effects, bindings, count);
}

static const struct vw_shader *backward_shader(const struct vw_model *model, const struct vw_specialization *s,
                                               bool transient) {
    bool effects = vw_effects_are_of_rays(model, s);
    if (transient) return effects ? &vw_shader_backward_transient_effects : &vw_shader_backward_transient;
    return effects ? &vw_shader_backward_rays_effects : &vw_shader_backward_rays;
}

enum vw_status vw_gradient_create_generate(const struct vw_model *model, struct vw_gpu_objects *objects,
                                           const struct vw_pass_params *common, struct vw_gradient_passes *gradient) {
    struct vw_binding bindings[VW_SLOT_COUNT];
    struct vw_pass_params params = *common;
    memcpy(bindings, common->bindings, common->binding_count * sizeof *bindings);
    for (uint32_t i = 0; i < common->binding_count; i++)
        if (bindings[i].slot == VW_SLOT_STEP_STATE) bindings[i].unused = !vw_effects_know_photos(model);
    params.bindings = bindings;
    return vw_pass_create_of(objects, &params, &vw_shader_generate_rays, &gradient->generate);
}

enum vw_status vw_gradient_create_ends(const struct vw_model *model, struct vw_gpu_objects *objects,
                                       const struct vw_pass_params *common, struct vw_gradient_passes *gradient) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < model->effect_count && !status; i++)
        if (model->effects[i]->ray_gradient && vw_effect_is_on(model->effects[i], &gradient->specialization))
            status = vw_pass_create_of(objects, common, model->effects[i]->ray_gradient, &gradient->ends[i]);
    return status;
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
                                               .d_grid = step->d_grid,
                                               .backward = true};
    enum vw_status status = vw_gradient_create_generate(model, objects, &field.common, gradient);
    if (!status)
        status = vw_pass_create_of(objects, &field.common,
                                   backward_shader(model, specialization, specialization->effect_transient),
                                   &gradient->backward_rays);
    if (!status) status = vw_gradient_create_ends(model, objects, &field.common, gradient);
    // Slopes that are given are of the field's colours.
    const struct vw_shader *coarse =
        specialization->loss == LOSS_GIVEN ? NULL : backward_shader(model, specialization, false);
    if (!status) status = vw_importance_create(step->field, &field, specialization, coarse, &gradient->importance);
    return !status ? model->kind->create_passes(step->field, &field, &gradient->field) : status;
}

void vw_gradient_record_forward(const struct vw_step_passes *step, const struct vw_field_passes *passes,
                                struct vw_submission *submission, const struct vw_push_samples *chunk) {
    const struct vw_model *model = step->field->model;
    model->kind->record_forward(model, passes, submission, chunk);
}

void vw_gradient_record_back(const struct vw_step_passes *step, const struct vw_gradient_passes *gradient,
                             struct vw_submission *submission, const struct vw_push_samples *chunk) {
    const struct vw_model *model = step->field->model;
    const struct vw_specialization *s = &gradient->specialization;
    vw_submission_dispatch(submission, gradient->backward_rays, chunk, sizeof *chunk,
                           (uint64_t)chunk->ray_count * (s->effect_transient ? 1 : s->ray_lanes));
    model->kind->record_backward(model, &gradient->field, submission, chunk);
}

void vw_gradient_record_chunk(const struct vw_step_passes *step, const struct vw_gradient_passes *gradient,
                              struct vw_submission *submission, const struct vw_push_samples *chunk) {
    vw_importance_record(step->field->model, &gradient->importance, submission, chunk);
    vw_gradient_record_forward(step, &gradient->field, submission, chunk);
    vw_gradient_record_back(step, gradient, submission, chunk);
}

struct vw_push_samples vw_gradient_chunk(const struct vw_step_passes *step, uint32_t rays, uint32_t first,
                                         vw_uint4 key) {
    uint32_t left = rays - first;
    return (struct vw_push_samples){
        .first_ray = first, .ray_count = left < step->chunk_rays ? left : step->chunk_rays, .key = key};
}

void vw_gradient_record_end(const struct vw_step_passes *step, const struct vw_gradient_passes *gradient,
                            struct vw_submission *submission, uint32_t rays) {
    const struct vw_model *model = step->field->model;
    struct vw_push_reduce push = {.count = rays};
    for (uint32_t i = 0; i < model->effect_count; i++)
        if (gradient->ends[i])
            vw_submission_dispatch(submission, gradient->ends[i], &push, sizeof push,
                                   model->effects[i]->ray_gradient_invocations);
}
