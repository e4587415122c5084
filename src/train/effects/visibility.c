#include "train/effects/visibility.h"

#include "base/memory.h"
#include "gpu/shaders.h"

static uint32_t groups_of(uint32_t rays) { return (rays + VISIBILITY_GROUP - 1) / VISIBILITY_GROUP; }

enum vw_status vw_visibility_create_buffers(const struct vw_radiance_field *field, uint32_t padded_rays,
                                            struct vw_visibility_effect *visibility) {
    uint64_t photos = field->model->visibility_codes.size_bytes / (sizeof(vw_float4) * VISIBILITY_CODE4);
    const struct {
        struct vw_buffer **buffer;
        struct vw_buffer_params params;
    } buffers[] = {
        {&visibility->of_rays, {.name = "visibility", .size_bytes = 2 * sizeof(float) * (uint64_t)padded_rays}},
        {&visibility->partials,
         {.name = "visibility_partials",
          .size_bytes = sizeof(vw_float4) * VISIBILITY_COLUMNS * (uint64_t)groups_of(padded_rays)}},
        {&visibility->moments,
         {.name = "visibility_moments", .size_bytes = sizeof(struct vw_visibility_moments) * photos}},
    };
    enum vw_status status = VW_OK;
    for (size_t i = 0; i < VW_ARRAY_COUNT(buffers) && photos && !status; i++)
        status = vw_buffer_create(field->gpu, &buffers[i].params, buffers[i].buffer);
    return status;
}

void vw_visibility_bind(const struct vw_radiance_field *field, const struct vw_visibility_effect *visibility,
                        struct vw_binding *bindings, uint32_t *count) {
    const struct vw_param_range *codes = &field->model->visibility_codes;
    if (!visibility->of_rays) {
        bindings[(*count)++] = (struct vw_binding){.slot = VW_SLOT_VISIBILITY, .unused = true};
        return;
    }
    bindings[(*count)++] = (struct vw_binding){.slot = VW_SLOT_VISIBILITY, .buffer = visibility->of_rays};
    bindings[(*count)++] = (struct vw_binding){.slot = VW_SLOT_VISIBILITY_PARTIALS, .buffer = visibility->partials};
    bindings[(*count)++] = (struct vw_binding){.slot = VW_SLOT_VISIBILITY_MOMENTS, .buffer = visibility->moments};
    bindings[(*count)++] = (struct vw_binding){.slot = VW_SLOT_PHOTO_SCALES, .buffer = field->photo_scales};
    bindings[(*count)++] = (struct vw_binding){.slot = VW_SLOT_VISIBILITY_CODES,
                                               .buffer = field->params,
                                               .offset_bytes = codes->offset_bytes,
                                               .size_bytes = codes->size_bytes};
}

enum vw_status vw_visibility_create_passes(const struct vw_radiance_field *field, const struct vw_binding *bindings,
                                           uint32_t count, struct vw_visibility_effect *visibility) {
    const struct {
        const struct vw_shader *shader;
        struct vw_pass **pass;
    } passes[] = {
        {&vw_shader_predict_visibility, &visibility->predict},
        {&vw_shader_gradient_visibility, &visibility->gradient},
        {&vw_shader_reduce_visibility, &visibility->reduce},
        {&vw_shader_update_visibility, &visibility->update},
    };
    enum vw_status status = VW_OK;
    for (size_t i = 0; i < VW_ARRAY_COUNT(passes) && visibility->of_rays && !status; i++) {
        struct vw_pass_params params = {.shader = passes[i].shader,
                                        .specialization = (const uint32_t *)&field->model->specialization,
                                        .specialization_count = VW_SPECIALIZATION_COUNT,
                                        .bindings = bindings,
                                        .binding_count = count};
        status = vw_pass_create(field->gpu, &params, passes[i].pass);
    }
    return status;
}

void vw_visibility_destroy(struct vw_visibility_effect *visibility) {
    vw_pass_destroy(&visibility->predict);
    vw_pass_destroy(&visibility->gradient);
    vw_pass_destroy(&visibility->reduce);
    vw_pass_destroy(&visibility->update);
    vw_buffer_destroy(&visibility->of_rays);
    vw_buffer_destroy(&visibility->partials);
    vw_buffer_destroy(&visibility->moments);
}

void vw_visibility_training_state(const struct vw_visibility_effect *visibility, struct vw_buffer **buffers,
                                  uint32_t *count) {
    if (visibility->moments) buffers[(*count)++] = visibility->moments;
}

void vw_visibility_record_forward(const struct vw_visibility_effect *visibility, struct vw_submission *batch,
                                  const struct vw_push_rays *rays, uint32_t padded_rays) {
    if (visibility->predict) vw_submission_dispatch(batch, visibility->predict, rays, sizeof *rays, padded_rays);
}

void vw_visibility_record_gradients(const struct vw_visibility_effect *visibility, struct vw_submission *batch,
                                    const struct vw_push_rays *rays, uint32_t padded_rays) {
    struct vw_push_reduce reduce = {.count = groups_of(padded_rays)};
    if (!visibility->gradient) return;
    vw_submission_dispatch(batch, visibility->gradient, rays, sizeof *rays, padded_rays);
    vw_submission_dispatch(batch, visibility->reduce, &reduce, sizeof reduce, VISIBILITY_COLUMNS);
}

void vw_visibility_record_update(const struct vw_visibility_effect *visibility, struct vw_submission *batch,
                                 const struct vw_push_update *push) {
    if (visibility->update) vw_submission_dispatch(batch, visibility->update, push, sizeof *push, 1);
}
