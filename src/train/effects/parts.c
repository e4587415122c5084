#include "train/effects/parts.h"

#include <assert.h>

#include "train/model.h"
#include "train/passes.h"

static uint32_t list_buffers(const struct vw_effect_kind *kind, const struct vw_model *model, uint32_t padded_rays,
                             struct vw_effect_buffer buffers[VW_EFFECT_BUFFERS_MAX]) {
    uint32_t count = kind->list_buffers ? kind->list_buffers(model, padded_rays, buffers) : 0;
    assert(count <= VW_EFFECT_BUFFERS_MAX);
    return count;
}

// Creates an effect's buffers that belong to the field, or those that belong to a step.
static enum vw_status create_buffers(const struct vw_effect_kind *kind, const struct vw_model *model,
                                     struct vw_gpu *gpu, bool of_field, uint32_t padded_rays,
                                     struct vw_buffer **created) {
    struct vw_effect_buffer buffers[VW_EFFECT_BUFFERS_MAX];
    uint32_t count = list_buffers(kind, model, padded_rays, buffers);
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < count && !status; i++) {
        const struct vw_buffer_params params = {.name = buffers[i].name, .size_bytes = buffers[i].size_bytes};
        if (buffers[i].of_field == of_field) status = vw_buffer_create(gpu, &params, &created[buffers[i].slot]);
    }
    return status;
}

enum vw_status vw_effects_create_of_field(const struct vw_model *model, struct vw_gpu *gpu,
                                          const struct vw_scene *scene, struct vw_buffer *buffers[VW_SLOT_COUNT]) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < vw_effect_kind_count && !status; i++) {
        const struct vw_effect_kind *kind = vw_effect_kind_on(i, &model->specialization);
        if (!kind) continue;
        status = create_buffers(kind, model, gpu, true, 0, buffers);
        if (!status && kind->fill) status = kind->fill(model, gpu, scene, buffers);
    }
    return status;
}

enum vw_status vw_effects_create_of_step(const struct vw_model *model, struct vw_gpu *gpu, uint32_t padded_rays,
                                         struct vw_buffer *buffers[VW_SLOT_COUNT]) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < vw_effect_kind_count && !status; i++) {
        const struct vw_effect_kind *kind = vw_effect_kind_on(i, &model->specialization);
        if (kind) status = create_buffers(kind, model, gpu, false, padded_rays, buffers);
    }
    return status;
}

void vw_effects_destroy_buffers(struct vw_buffer *buffers[VW_SLOT_COUNT]) {
    for (uint32_t i = 0; i < VW_SLOT_COUNT; i++) vw_buffer_destroy(&buffers[i]);
}

static void bind(struct vw_binding binding, struct vw_binding *bindings, uint32_t *count) {
    for (uint32_t i = 0; i < *count; i++)
        if (bindings[i].slot == binding.slot) return;
    bindings[(*count)++] = binding;
}

static void bind_range(const struct vw_model *model, struct vw_buffer *params, uint32_t slot,
                       struct vw_binding *bindings, uint32_t *count) {
    const struct vw_param_range *range = &model->ranges[slot];
    bind((struct vw_binding){.slot = slot,
                             .buffer = params,
                             .offset_bytes = range->offset_bytes,
                             .size_bytes = range->size_bytes,
                             .unused = !range->size_bytes},
         bindings, count);
}

void vw_effects_bind(const struct vw_model *model, const struct vw_effect_buffers *buffers, struct vw_binding *bindings,
                     uint32_t *count) {
    for (uint32_t i = 0; i < vw_effect_kind_count; i++) {
        const struct vw_effect_kind *kind = vw_effect_kinds[i];
        struct vw_effect_buffer own[VW_EFFECT_BUFFERS_MAX];
        uint32_t own_count = list_buffers(kind, model, 0, own);
        for (uint32_t k = 0; k < own_count; k++) {
            uint32_t slot = own[k].slot;
            struct vw_buffer *buffer = buffers->of_step ? buffers->of_step[slot] : NULL;
            if (buffers->of_field[slot]) buffer = buffers->of_field[slot];
            bind((struct vw_binding){.slot = slot, .buffer = buffer, .unused = !buffer}, bindings, count);
        }
        for (size_t k = 0; k < 2 && kind->ranges[k]; k++)
            bind_range(model, buffers->params, kind->ranges[k], bindings, count);
    }
}

void vw_effects_training_state(const struct vw_model *model, const struct vw_effect_buffers *buffers,
                               struct vw_buffer **state, uint32_t *count) {
    for (uint32_t i = 0; i < vw_effect_kind_count; i++) {
        struct vw_effect_buffer own[VW_EFFECT_BUFFERS_MAX];
        const struct vw_effect_kind *kind = vw_effect_kind_on(i, &model->specialization);
        uint32_t own_count = kind ? list_buffers(kind, model, 0, own) : 0;
        for (uint32_t k = 0; k < own_count; k++)
            if (own[k].carried)
                state[(*count)++] = own[k].of_field ? buffers->of_field[own[k].slot] : buffers->of_step[own[k].slot];
    }
}

static enum vw_status create_set(const struct vw_effect_kind *kind, const struct vw_model *model, struct vw_gpu *gpu,
                                 const struct vw_pass_params *common, uint32_t count, struct vw_effect_passes *set) {
    struct vw_pass_row rows[VW_EFFECT_PASSES_MAX] = {0};
    for (uint32_t i = 0; i < count; i++) {
        const struct vw_effect_shader *shader = &kind->shaders[i];
        bool half = model->half_grid && shader->half;
        rows[i] = (struct vw_pass_row){half ? shader->half : shader->shader, &set->passes[i]};
    }
    return vw_passes_create(gpu, common, rows, count);
}

enum vw_status vw_effects_create_passes(const struct vw_model *model, struct vw_gpu *gpu,
                                        const struct vw_pass_params *common, struct vw_effect_sets *effects) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < vw_effect_kind_count && !status; i++) {
        const struct vw_effect_kind *kind = vw_effect_kind_on(i, &model->specialization);
        if (kind) status = create_set(kind, model, gpu, common, VW_EFFECT_PASSES_MAX, &effects->sets[i]);
    }
    return status;
}

enum vw_status vw_effects_create_photo_passes(const struct vw_model *model, struct vw_gpu *gpu,
                                              const struct vw_pass_params *common, struct vw_effect_sets *effects) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < vw_effect_kind_count && !status; i++) {
        const struct vw_effect_kind *kind = vw_effect_kind_on(i, &model->specialization);
        if (kind && kind->sees_photos)
            status = create_set(kind, model, gpu, common, kind->photo_pass_count, &effects->sets[i]);
    }
    return status;
}

void vw_effects_destroy_passes(struct vw_effect_sets *effects) {
    for (uint32_t i = 0; i < VW_EFFECT_COUNT_MAX; i++)
        for (uint32_t k = 0; k < VW_EFFECT_PASSES_MAX; k++) vw_pass_destroy(&effects->sets[i].passes[k]);
}

void vw_effects_record_photo(const struct vw_model *model, const struct vw_effect_sets *effects,
                             struct vw_submission *batch, uint32_t view) {
    for (uint32_t i = 0; i < vw_effect_kind_count; i++) {
        const struct vw_effect_kind *kind = vw_effect_kind_on(i, &model->specialization);
        if (kind && kind->record_photo && effects->sets[i].passes[0])
            kind->record_photo(model, effects->sets[i].passes, batch, view);
    }
}

void vw_effects_record_chunk(const struct vw_specialization *specialization, const struct vw_effect_sets *effects,
                             struct vw_submission *batch, const struct vw_push_samples *chunk) {
    for (uint32_t i = 0; i < vw_effect_kind_count; i++) {
        const struct vw_effect_kind *kind = vw_effect_kind_on(i, specialization);
        if (kind && kind->record_chunk) kind->record_chunk(effects->sets[i].passes, batch, chunk);
    }
}

void vw_effects_list_costs(const struct vw_effect_work *work, struct vw_pass_cost *costs, uint32_t *count) {
    for (uint32_t i = 0; i < vw_effect_kind_count; i++) {
        const struct vw_effect_kind *kind = vw_effect_kind_on(i, &work->model->specialization);
        if (kind && kind->list_costs && (!work->picture || kind->record_chunk || kind->ray_gradient))
            kind->list_costs(work, costs, count);
    }
}

void vw_effects_list_photo_costs(const struct vw_model *model, double photos, bool seen, const char *role,
                                 struct vw_pass_cost *costs, uint32_t *count) {
    for (uint32_t i = 0; i < vw_effect_kind_count; i++) {
        const struct vw_effect_kind *kind = vw_effect_kind_on(i, &model->specialization);
        if (kind && kind->list_photo_costs && (kind->sees_photos || !seen))
            kind->list_photo_costs(model, photos, role, costs, count);
    }
}
