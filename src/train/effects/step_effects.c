#include "train/effects/step_effects.h"

#include "train/step_passes.h"

enum vw_status vw_effects_create_rest(struct vw_step_passes *step) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < vw_effect_kind_count && !status; i++) {
        const struct vw_effect_kind *kind = vw_effect_kind_on(i, &step->field->model->specialization);
        if (kind && kind->create) status = kind->create(step);
    }
    return status;
}

void vw_effects_destroy_rest(struct vw_step_passes *step) {
    for (uint32_t i = 0; i < vw_effect_kind_count; i++)
        if (vw_effect_kinds[i]->destroy) vw_effect_kinds[i]->destroy(step);
}

void vw_effects_record_begin(const struct vw_step_passes *step, struct vw_submission *batch, uint64_t number,
                             vw_uint4 key) {
    for (uint32_t i = 0; i < vw_effect_kind_count; i++) {
        const struct vw_effect_kind *kind = vw_effect_kind_on(i, &step->field->model->specialization);
        if (kind && kind->record_begin) kind->record_begin(step->effects.sets[i].passes, batch, number, key);
    }
}

void vw_effects_record_rays(const struct vw_step_passes *step, struct vw_submission *batch,
                            const struct vw_push_rays *rays) {
    for (uint32_t i = 0; i < vw_effect_kind_count; i++) {
        const struct vw_effect_kind *kind = vw_effect_kind_on(i, &step->field->model->specialization);
        if (kind && kind->record_rays) kind->record_rays(step, step->effects.sets[i].passes, batch, rays);
    }
}

void vw_effects_record_chunk_gradient(const struct vw_step_passes *step, struct vw_submission *batch,
                                      const struct vw_push_samples *chunk) {
    const struct vw_model *model = step->field->model;
    const struct vw_field_chunk samples = {chunk, step->effect_buffers[VW_SLOT_KEPT]};
    for (uint32_t i = 0; i < vw_effect_kind_count; i++) {
        const struct vw_effect_kind *kind = vw_effect_kind_on(i, &model->specialization);
        if (kind && kind->record_chunk_gradient)
            kind->record_chunk_gradient(model, step->effects.sets[i].passes, batch, &samples);
    }
}

void vw_effects_record_gradient(const struct vw_step_passes *step, struct vw_submission *batch,
                                const struct vw_push_rays *rays, uint64_t number) {
    for (uint32_t i = 0; i < vw_effect_kind_count; i++) {
        const struct vw_effect_kind *kind = vw_effect_kind_on(i, &step->field->model->specialization);
        if (kind && kind->record_gradient)
            kind->record_gradient(step, step->effects.sets[i].passes, batch, rays, number);
    }
}

void vw_effects_record_update(const struct vw_step_passes *step, struct vw_submission *batch,
                              struct vw_push_update push) {
    push.count = step->padded_rays;
    for (uint32_t i = 0; i < vw_effect_kind_count; i++) {
        const struct vw_effect_kind *kind = vw_effect_kind_on(i, &step->field->model->specialization);
        if (kind && kind->record_update) kind->record_update(step->effects.sets[i].passes, batch, &push);
    }
}
