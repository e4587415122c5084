#include "train/step_passes.h"

#include <string.h>

#include "base/memory.h"
#include "gpu/shaders.h"

void vw_step_bind(const struct vw_step_passes *step, struct vw_binding *bindings, uint32_t *count) {
    struct vw_buffer *listed = step->places ? step->places : step->occupancy.kept_samples; // never both
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
        {.slot = VW_SLOT_D_SKY, .buffer = step->d_sky, .unused = !step->d_sky},
        {.slot = VW_SLOT_KEPT_SAMPLES, .buffer = listed, .unused = !listed},
    };
    memcpy(bindings + *count, own, sizeof own);
    *count += VW_ARRAY_COUNT(own);
    vw_field_bind(step->field, true, bindings, count);
    vw_appearance_bind(step->field, &step->appearance, bindings, count);
    vw_occupancy_bind(step->field, &step->occupancy, bindings, count);
    vw_visibility_bind(step->field, &step->visibility, bindings, count);
    vw_transient_bind(step->field, &step->transient, bindings, count);
    vw_pose_bind(step->field, &step->pose, bindings, count);
    vw_encoder_bind(&step->field->encoder, &step->encoder_gradient, bindings, count);
}

enum vw_status vw_step_create_pass(const struct vw_step_passes *step, const struct vw_specialization *specialization,
                                   const struct vw_shader *shader, const struct vw_binding *bindings, uint32_t count,
                                   struct vw_pass **pass) {
    struct vw_pass_params params = {.shader = shader,
                                    .specialization = (const uint32_t *)specialization,
                                    .specialization_count = VW_SPECIALIZATION_COUNT,
                                    .bindings = bindings,
                                    .binding_count = count};
    return vw_pass_create(step->field->gpu, &params, pass);
}

bool vw_step_has_ray_effects(const struct vw_specialization *s) {
    return s->effect_sky || s->effect_appearance || s->effect_visibility;
}

static const struct vw_shader *backward_shader(const struct vw_specialization *s, bool transient) {
    if (transient)
        return vw_step_has_ray_effects(s) ? &vw_shader_backward_transient_effects : &vw_shader_backward_transient;
    return vw_step_has_ray_effects(s) ? &vw_shader_backward_rays_effects : &vw_shader_backward_rays;
}

enum vw_status vw_gradient_create(const struct vw_step_passes *step, const struct vw_specialization *specialization,
                                  struct vw_gradient_passes *gradient) {
    *gradient =
        (struct vw_gradient_passes){.specialization = *specialization, .field = {.specialization = *specialization}};
    struct vw_binding bindings[VW_SLOT_COUNT];
    uint32_t count = 0;
    vw_step_bind(step, bindings, &count);
    const struct {
        const struct vw_shader *shader;
        struct vw_pass **pass;
    } passes[] = {
        {&vw_shader_generate_rays, &gradient->generate},
        {backward_shader(specialization, specialization->effect_transient), &gradient->backward_rays},
        {&vw_shader_gradient_sky, step->d_sky ? &gradient->gradient_sky : NULL},
    };
    enum vw_status status = VW_OK;
    for (size_t i = 0; i < VW_ARRAY_COUNT(passes) && !status; i++)
        if (passes[i].pass)
            status = vw_step_create_pass(step, specialization, passes[i].shader, bindings, count, passes[i].pass);
    const struct vw_field_pass_params field = {.specialization = specialization,
                                               .bindings = bindings,
                                               .binding_count = count,
                                               .d_grid = step->d_grid,
                                               .backward = true};
    // Slopes that are given are of the field's colours.
    const struct vw_shader *coarse = specialization->loss == LOSS_GIVEN ? NULL : backward_shader(specialization, false);
    if (!status) status = vw_importance_create(step->field, &field, coarse, &gradient->importance);
    return !status ? step->field->model->kind->create_passes(step->field, &field, &gradient->field) : status;
}

void vw_gradient_destroy(struct vw_gradient_passes *gradient) {
    vw_pass_destroy(&gradient->generate);
    vw_pass_destroy(&gradient->backward_rays);
    vw_pass_destroy(&gradient->gradient_sky);
    vw_field_passes_destroy(&gradient->field);
    vw_importance_destroy(&gradient->importance);
}

void vw_gradient_record_forward(const struct vw_step_passes *step, const struct vw_field_passes *passes,
                                struct vw_submission *batch, const struct vw_push_samples *chunk) {
    const struct vw_model *model = step->field->model;
    const struct vw_field_chunk samples = {chunk, step->occupancy.kept};
    if (passes->specialization.effect_occupancy) vw_occupancy_record_chunk(&step->occupancy, batch, chunk);
    model->kind->record_forward(model, passes, batch, &samples);
}

void vw_gradient_record_back(const struct vw_step_passes *step, const struct vw_gradient_passes *gradient,
                             struct vw_submission *batch, const struct vw_push_samples *chunk) {
    const struct vw_model *model = step->field->model;
    const struct vw_field_chunk samples = {chunk, step->occupancy.kept};
    vw_submission_dispatch(batch, gradient->backward_rays, chunk, sizeof *chunk, chunk->ray_count);
    model->kind->record_backward(model, &gradient->field, batch, &samples);
}

void vw_gradient_record_chunk(const struct vw_step_passes *step, const struct vw_gradient_passes *gradient,
                              struct vw_submission *batch, const struct vw_push_samples *chunk) {
    vw_importance_record(step->field->model, &gradient->importance, batch, chunk);
    vw_gradient_record_forward(step, &gradient->field, batch, chunk);
    vw_gradient_record_back(step, gradient, batch, chunk);
}

struct vw_push_samples vw_gradient_chunk(const struct vw_step_passes *step, uint32_t rays, uint32_t first,
                                         vw_uint4 key) {
    uint32_t left = rays - first;
    return (struct vw_push_samples){
        .first_ray = first, .ray_count = left < step->chunk_rays ? left : step->chunk_rays, .key = key};
}

void vw_gradient_record_sky(const struct vw_gradient_passes *gradient, struct vw_submission *batch, uint32_t rays) {
    struct vw_push_reduce push = {.count = rays};
    if (gradient->gradient_sky)
        vw_submission_dispatch(batch, gradient->gradient_sky, &push, sizeof push, 64ull * VW_SKY_COLUMNS);
}
