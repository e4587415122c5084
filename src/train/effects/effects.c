#include "train/effects/effects.h"

#include <assert.h>
#include <string.h>

#include "train/effects/registry.h"
#include "train/model.h"

// ---- Of a model -----------------------------------------------------------------------------------------------------

enum vw_status vw_effects_initialise(const struct vw_model *model, const struct vw_scene *scene,
                                     const struct vw_drawn *drawn, void *params) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < model->effect_count; i++)
        if (model->effects[i]->initialise) model->effects[i]->initialise(model, drawn, params);
    if (model->specialization.effect_appearance == APPEARANCE_GIVEN && !model->awaits_params)
        status = vw_appearance_take_exposures(model, scene, params);
    return status;
}

bool vw_effects_fit(const struct vw_model *model) {
    bool found = false;
    for (uint32_t i = 0; i < model->effect_count; i++) found |= model->effects[i]->fits_views;
    return found;
}

bool vw_effects_see_photos(const struct vw_model *model) {
    bool found = false;
    for (uint32_t i = 0; i < model->effect_count; i++) found |= model->effects[i]->photo_pass_count > 0;
    return found;
}

bool vw_effects_know_photos(const struct vw_model *model) {
    bool found = false;
    for (uint32_t i = 0; i < model->effect_count; i++)
        found |= model->effects[i]->photo_pass_count || model->effects[i]->update;
    return found;
}

struct vw_specialization vw_effects_specialise_validation(const struct vw_model *model) {
    struct vw_specialization specialization = model->specialization;
    specialization.training = 0;
    for (uint32_t i = 0; i < model->effect_count; i++)
        if (model->effects[i]->training_alone)
            memset((char *)&specialization + model->effects[i]->constant, 0, sizeof(uint32_t));
    return specialization;
}

enum vw_status vw_effects_check_adjoint(const struct vw_model *model) {
    for (uint32_t i = 0; i < model->effect_count; i++)
        if (model->effects[i]->adjoint == VW_ADJOINT_REFUSES)
            return vw_fail(VW_ERROR_USAGE,
                           "lasting credit cannot go back through the effect %s; value the scene with --effects -%s",
                           model->effects[i]->name, model->effects[i]->name);
    return VW_OK;
}

// ---- Buffers --------------------------------------------------------------------------------------------------------

static uint32_t list_buffers(const struct vw_effect_kind *kind, const struct vw_model *model, uint32_t padded_rays,
                             struct vw_effect_buffer buffers[VW_EFFECT_BUFFERS_MAX]) {
    uint32_t count = kind->list_buffers ? kind->list_buffers(model, padded_rays, buffers) : 0;
    assert(count <= VW_EFFECT_BUFFERS_MAX);
    return count;
}

enum vw_status vw_effects_create_buffers(const struct vw_model *model, struct vw_gpu_objects *objects, bool of_field,
                                         uint32_t padded_rays, uint64_t pixels,
                                         struct vw_buffer *created[VW_SLOT_COUNT]) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < model->effect_count; i++) {
        struct vw_effect_buffer buffers[VW_EFFECT_BUFFERS_MAX];
        uint32_t count = list_buffers(model->effects[i], model, padded_rays, buffers);
        for (uint32_t k = 0; k < count && !status; k++) {
            bool of_pixels = buffers[k].use & VW_EFFECT_OF_PIXELS;
            const struct vw_buffer_row row = {&created[buffers[k].slot], buffers[k].name,
                                              buffers[k].size_bytes * (of_pixels ? pixels : 1)};
            if (!!(buffers[k].use & VW_EFFECT_OF_FIELD) == of_field)
                status = vw_buffers_create(objects, of_pixels ? VW_BUFFER_UPLOAD : VW_BUFFER_DEVICE, &row, 1);
        }
    }
    return status;
}

uint64_t vw_effects_pixel_bytes(const struct vw_model *model) {
    uint64_t bytes = 0;
    for (uint32_t i = 0; i < model->effect_count; i++) {
        struct vw_effect_buffer buffers[VW_EFFECT_BUFFERS_MAX];
        uint32_t count = list_buffers(model->effects[i], model, 0, buffers);
        for (uint32_t k = 0; k < count; k++) bytes += buffers[k].use & VW_EFFECT_OF_PIXELS ? buffers[k].size_bytes : 0;
    }
    return bytes;
}

void vw_effects_draw_pixels(const struct vw_model *model, const struct vw_step_passes *step, uint32_t view,
                            uint32_t first_pixel) {
    for (uint32_t i = 0; i < model->effect_count; i++)
        if (model->effects[i]->draw_pixels) model->effects[i]->draw_pixels(step, view, first_pixel);
}

enum vw_status vw_effects_fill(const struct vw_model *model, struct vw_gpu *gpu, const struct vw_scene *scene,
                               struct vw_buffer *const *buffers) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < model->effect_count && !status; i++)
        if (model->effects[i]->fill) status = model->effects[i]->fill(model, gpu, scene, buffers);
    return status;
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
    for (uint32_t i = 0; model->effect_table[i]; i++) {
        const struct vw_effect_kind *kind = model->effect_table[i];
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
    for (uint32_t i = 0; i < model->effect_count; i++) {
        struct vw_effect_buffer own[VW_EFFECT_BUFFERS_MAX];
        uint32_t own_count = list_buffers(model->effects[i], model, 0, own);
        for (uint32_t k = 0; k < own_count; k++)
            if (own[k].size_bytes && own[k].use & VW_EFFECT_CARRIED)
                state[(*count)++] =
                    (own[k].use & VW_EFFECT_OF_FIELD ? buffers->of_field : buffers->of_step)[own[k].slot];
    }
}

// ---- Passes ---------------------------------------------------------------------------------------------------------

enum vw_status vw_effects_create_passes(const struct vw_model *model, struct vw_gpu_objects *objects,
                                        const struct vw_pass_params *common, bool of_step,
                                        struct vw_effect_sets *effects) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < model->effect_count && !status; i++) {
        const struct vw_effect_kind *kind = model->effects[i];
        struct vw_pass_row rows[VW_EFFECT_PASSES_MAX] = {0};
        uint32_t count = of_step ? VW_EFFECT_PASSES_MAX : kind->photo_pass_count;
        for (uint32_t k = 0; k < count; k++) {
            rows[k].shader = kind->shaders[k];
            rows[k].pass = &effects->sets[i].passes[k];
        }
        if (of_step && (!kind->updates || kind->updates(model))) rows[VW_EFFECT_UPDATE].shader = kind->update;
        status = vw_passes_create(objects, common, rows, count);
    }
    return status;
}

enum vw_status vw_effects_create_extras(const struct vw_model *model, struct vw_step_passes *step) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < model->effect_count && !status; i++)
        if (model->effects[i]->create) status = model->effects[i]->create(step);
    return status;
}

void vw_effects_destroy_extras(const struct vw_model *model, struct vw_step_passes *step) {
    for (uint32_t i = 0; i < model->effect_count; i++)
        if (model->effects[i]->destroy) model->effects[i]->destroy(step);
}

// ---- Recording ------------------------------------------------------------------------------------------------------

void vw_effects_record_photo(const struct vw_model *model, const struct vw_effect_sets *effects,
                             struct vw_submission *submission, uint32_t view) {
    for (uint32_t i = 0; i < model->effect_count; i++) {
        const struct vw_effect_kind *kind = model->effects[i];
        if (kind->record_photo && effects->sets[i].passes[0])
            kind->record_photo(model, effects->sets[i].passes, submission, view);
    }
}

void vw_effects_record_rays(const struct vw_model *model, const struct vw_effect_sets *effects,
                            const struct vw_step_passes *step, struct vw_submission *submission,
                            const struct vw_push_rays *rays) {
    for (uint32_t i = 0; i < model->effect_count; i++) {
        const struct vw_effect_kind *kind = model->effects[i];
        if (kind->record_rays) kind->record_rays(step, effects->sets[i].passes, submission, rays);
    }
}

void vw_effects_record_chunk_gradient(const struct vw_model *model, const struct vw_effect_sets *effects,
                                      struct vw_submission *submission, const struct vw_push_samples *chunk) {
    for (uint32_t i = 0; i < model->effect_count; i++) {
        const struct vw_effect_kind *kind = model->effects[i];
        if (kind->record_chunk_gradient) kind->record_chunk_gradient(model, effects->sets[i].passes, submission, chunk);
    }
}

void vw_effects_record_gradient(const struct vw_model *model, const struct vw_effect_sets *effects,
                                const struct vw_step_passes *step, struct vw_submission *submission,
                                const struct vw_push_rays *rays, uint64_t number) {
    for (uint32_t i = 0; i < model->effect_count; i++) {
        const struct vw_effect_kind *kind = model->effects[i];
        if (kind->record_gradient) kind->record_gradient(step, effects->sets[i].passes, submission, rays, number);
    }
}

void vw_effects_record_update(const struct vw_model *model, const struct vw_effect_sets *effects,
                              struct vw_submission *submission, const struct vw_push_update *push) {
    for (uint32_t i = 0; i < model->effect_count; i++) {
        const struct vw_pass *update = effects->sets[i].passes[VW_EFFECT_UPDATE];
        if (update) vw_submission_dispatch(submission, update, push, sizeof *push, 1);
    }
}
