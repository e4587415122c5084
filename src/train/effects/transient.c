#include "train/effects/transient.h"

#include "base/memory.h"
#include "gpu/shaders.h"

enum vw_status vw_transient_create_buffers(const struct vw_radiance_field *field,
                                           struct vw_transient_effect *transient) {
    uint64_t photos = field->model->transient_codes.size_bytes / (16 * TRANSIENT_CODE4);
    const struct vw_buffer_params moments = {.name = "transient_code_moments",
                                             .size_bytes = sizeof(struct vw_transient_moments) * photos};
    return photos ? vw_buffer_create(field->gpu, &moments, &transient->moments) : VW_OK;
}

void vw_transient_bind(const struct vw_radiance_field *field, const struct vw_transient_effect *transient,
                       struct vw_binding *bindings, uint32_t *count) {
    const struct vw_param_range *codes = &field->model->transient_codes;
    bindings[(*count)++] = (struct vw_binding){.slot = VW_SLOT_TRANSIENT_CODES,
                                               .buffer = field->params,
                                               .offset_bytes = codes->offset_bytes,
                                               .size_bytes = codes->size_bytes,
                                               .unused = !codes->size_bytes};
    bindings[(*count)++] = (struct vw_binding){
        .slot = VW_SLOT_TRANSIENT_CODE_MOMENTS, .buffer = transient->moments, .unused = !transient->moments};
}

enum vw_status vw_transient_create_passes(const struct vw_radiance_field *field, const struct vw_binding *bindings,
                                          uint32_t count, struct vw_transient_effect *transient) {
    const struct vw_pass_params params = {.shader = &vw_shader_update_transient,
                                          .specialization = (const uint32_t *)&field->model->specialization,
                                          .specialization_count = VW_SPECIALIZATION_COUNT,
                                          .bindings = bindings,
                                          .binding_count = count};
    return transient->moments ? vw_pass_create(field->gpu, &params, &transient->update) : VW_OK;
}

void vw_transient_destroy(struct vw_transient_effect *transient) {
    vw_pass_destroy(&transient->update);
    vw_buffer_destroy(&transient->moments);
}

void vw_transient_training_state(const struct vw_transient_effect *transient, struct vw_buffer **buffers,
                                 uint32_t *count) {
    if (transient->moments) buffers[(*count)++] = transient->moments;
}

void vw_transient_record_update(const struct vw_transient_effect *transient, struct vw_submission *batch,
                                struct vw_push_update push) {
    if (transient->update) vw_submission_dispatch(batch, transient->update, &push, sizeof push, 1);
}
