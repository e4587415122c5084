#include "train/effects/appearance.h"

#include "base/memory.h"
#include "gpu/compute.h"
#include "gpu/shaders.h"

// Sizes are in bytes; a range's tells the number of photos.
enum vw_status vw_appearance_create_buffers(const struct vw_radiance_field *field, uint32_t padded_rays,
                                            struct vw_appearance_effect *appearance) {
    const struct vw_model *model = field->model;
    uint64_t photos = model->appearance.size_bytes / sizeof(struct vw_appearance),
             codes = model->codes.size_bytes / (16 * CODE4);
    const struct {
        struct vw_buffer **buffer;
        struct vw_buffer_params params;
    } buffers[] = {
        {&appearance->d_appearance,
         {.name = "d_appearance", .size_bytes = photos ? sizeof(struct vw_appearance) * (uint64_t)padded_rays : 0}},
        {&appearance->moments,
         {.name = "appearance_moments", .size_bytes = sizeof(struct vw_appearance_moments) * photos}},
        {&appearance->code_shift, {.name = "code_shift", .size_bytes = model->code_weights.size_bytes / (4 * CODE4)}},
        {&appearance->code_weight_moments,
         {.name = "code_weight_moments", .size_bytes = 2 * model->code_weights.size_bytes}},
        {&appearance->code_moments, {.name = "code_moments", .size_bytes = sizeof(struct vw_code_moments) * codes}},
    };
    enum vw_status status = VW_OK;
    for (size_t i = 0; i < VW_ARRAY_COUNT(buffers) && !status; i++)
        if (buffers[i].params.size_bytes) status = vw_buffer_create(field->gpu, &buffers[i].params, buffers[i].buffer);
    return status;
}

void vw_appearance_bind(const struct vw_radiance_field *field, const struct vw_appearance_effect *appearance,
                        struct vw_binding *bindings, uint32_t *count) {
    static const struct vw_appearance_effect none;
    const struct vw_appearance_effect *it = appearance ? appearance : &none;
    const struct {
        uint32_t slot;
        struct vw_buffer *buffer;
    } buffers[] = {
        {VW_SLOT_D_APPEARANCE, it->d_appearance},
        {VW_SLOT_APPEARANCE_MOMENTS, it->moments},
        {VW_SLOT_CODE_WEIGHT_MOMENTS, it->code_weight_moments},
        {VW_SLOT_CODE_MOMENTS, it->code_moments},
    };
    const struct {
        uint32_t slot;
        const struct vw_param_range *range;
    } ranges[] = {{VW_SLOT_APPEARANCE, &field->model->appearance},
                  {VW_SLOT_CODE_WEIGHTS, &field->model->code_weights},
                  {VW_SLOT_CODES, &field->model->codes}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(buffers); i++)
        bindings[(*count)++] =
            (struct vw_binding){.slot = buffers[i].slot, .buffer = buffers[i].buffer, .unused = !buffers[i].buffer};
    if (!field->encoder.code_shift) // else vw_encoder_bind() does it
        bindings[(*count)++] =
            (struct vw_binding){.slot = VW_SLOT_CODE_SHIFT, .buffer = it->code_shift, .unused = !it->code_shift};
    for (size_t i = 0; i < VW_ARRAY_COUNT(ranges); i++) {
        const struct vw_param_range *range = ranges[i].range;
        struct vw_binding binding = {.slot = ranges[i].slot, .buffer = field->params, .unused = !range->size_bytes};
        binding.offset_bytes = range->offset_bytes;
        binding.size_bytes = range->size_bytes;
        bindings[(*count)++] = binding;
    }
}

enum vw_status vw_appearance_create_passes(const struct vw_radiance_field *field, const struct vw_binding *bindings,
                                           uint32_t count, struct vw_appearance_effect *appearance) {
    const struct {
        const struct vw_shader *shader;
        struct vw_pass **pass;
        bool on;
    } passes[] = {
        {&vw_shader_mix_code, &appearance->mix_code, appearance->code_shift},
        {&vw_shader_update_appearance, &appearance->update_appearance, appearance->moments},
        {&vw_shader_update_code, &appearance->update_code, appearance->code_shift},
    };
    enum vw_status status = VW_OK;
    for (size_t i = 0; i < VW_ARRAY_COUNT(passes) && !status; i++) {
        struct vw_pass_params params = {.shader = passes[i].shader,
                                        .specialization = (const uint32_t *)&field->model->specialization,
                                        .specialization_count = VW_SPECIALIZATION_COUNT,
                                        .bindings = bindings,
                                        .binding_count = count};
        if (passes[i].on) status = vw_pass_create(field->gpu, &params, passes[i].pass);
    }
    return status;
}

void vw_appearance_destroy(struct vw_appearance_effect *appearance) {
    vw_pass_destroy(&appearance->update_appearance);
    vw_pass_destroy(&appearance->mix_code);
    vw_pass_destroy(&appearance->update_code);
    vw_buffer_destroy(&appearance->d_appearance);
    vw_buffer_destroy(&appearance->moments);
    vw_buffer_destroy(&appearance->code_shift);
    vw_buffer_destroy(&appearance->code_weight_moments);
    vw_buffer_destroy(&appearance->code_moments);
}

void vw_appearance_training_state(const struct vw_appearance_effect *appearance, struct vw_buffer **buffers,
                                  uint32_t *count) {
    struct vw_buffer *const state[] = {appearance->moments, appearance->code_weight_moments, appearance->code_moments};
    for (size_t i = 0; i < VW_ARRAY_COUNT(state); i++)
        if (state[i]) buffers[(*count)++] = state[i];
}

void vw_appearance_record_forward(const struct vw_appearance_effect *appearance, const struct vw_model *model,
                                  struct vw_submission *batch) {
    if (appearance->mix_code)
        vw_submission_dispatch(batch, appearance->mix_code, NULL, 0, 4 * (uint64_t)model->specialization.width4);
}

void vw_appearance_record_update(const struct vw_appearance_effect *appearance, struct vw_submission *batch,
                                 struct vw_push_update push, uint32_t padded_rays) {
    push.count = padded_rays;
    if (appearance->update_appearance)
        vw_submission_dispatch(batch, appearance->update_appearance, &push, sizeof push, 1);
    if (appearance->update_code) vw_submission_dispatch(batch, appearance->update_code, &push, sizeof push, 1);
}

bool vw_appearance_fits_views(const struct vw_model *model) {
    return model->specialization.effect_appearance || model->specialization.effect_appearance_code;
}
