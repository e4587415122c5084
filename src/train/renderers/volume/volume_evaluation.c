// Rendering by the volume: samples of a chunk of rays, composited to colours, without changing anything.

#include "base/memory.h"
#include "gpu/shaders.h"
#include "train/effects/effects.h"
#include "train/passes.h"
#include "train/renderers/volume/volume.h"

enum { CHUNK_SAMPLES = 1 << 16 }; // 1 MiB of samples at a time

static enum vw_status create_buffers(struct vw_evaluator *evaluator) {
    const struct vw_model *model = evaluator->field->model;
    const struct vw_volume_model *layout = vw_volume_of(model);
    struct vw_volume_evaluation *volume = vw_volume_evaluation_of(evaluator);
    uint32_t chunk_samples = layout->kind->renders_in_rows ? model->specialization.chunk_samples : CHUNK_SAMPLES,
             chunk_rays = chunk_samples / layout->ray_samples / model->ray_group * model->ray_group;
    if (chunk_rays < model->ray_group) chunk_rays = model->ray_group;
    volume->chunk_rays = chunk_rays < evaluator->ray_count ? chunk_rays : evaluator->ray_count;
    const struct vw_buffer_row buffers[] = {
        {&volume->samples, "evaluated_samples", 16 * (uint64_t)volume->chunk_rays * layout->ray_samples},
        {&volume->places, "sample_places", vw_importance_places_bytes(model, volume->chunk_rays)},
    };
    return vw_buffers_create(&evaluator->objects, VW_BUFFER_DEVICE, buffers, VW_ARRAY_COUNT(buffers));
}

static enum vw_status create_passes(struct vw_evaluator *evaluator) {
    const struct vw_model *model = evaluator->field->model;
    struct vw_volume_evaluation *volume = vw_volume_evaluation_of(evaluator);
    struct vw_specialization specialization = vw_effects_specialise_validation(model);
    specialization.stores_rows = 0;
    struct vw_binding bindings[VW_SLOT_COUNT] = {
        {.slot = VW_SLOT_PIXELS, .buffer = evaluator->pixels},
        {.slot = VW_SLOT_RAYS, .buffer = evaluator->rays},
        {.slot = VW_SLOT_FIELD, .buffer = volume->samples},
        {.slot = VW_SLOT_COLOURS, .buffer = evaluator->colours},
        {.slot = VW_SLOT_PLACES, .buffer = volume->places, .unused = !volume->places},
    };
    uint32_t count = 5;
    vw_field_bind(evaluator->field, false, bindings, &count);
    const struct vw_effect_buffers of_effects = {evaluator->field->params, evaluator->field->effect_buffers, NULL};
    vw_effects_bind(model, &of_effects, bindings, &count);
    const struct vw_field_pass_params field = {
        .objects = &evaluator->objects, .common = vw_pass_params_of(&specialization, bindings, count, evaluator_role)};
    const struct vw_pass_row passes[] = {
        {&vw_shader_generate_rays, &evaluator->generate},
        {evaluator->depth ? &vw_shader_composite_rays_depth : &vw_shader_composite_rays, &volume->composite},
    };
    enum vw_status status = vw_passes_create(&evaluator->objects, &field.common, passes, VW_ARRAY_COUNT(passes));
    volume->passes.specialization = specialization;
    if (!status) status = vw_importance_create(evaluator->field, &field, &specialization, NULL, &volume->importance);
    if (!status)
        status = vw_effects_create_passes(model, &evaluator->objects, &field.common, false, &evaluator->effects);
    return !status ? vw_volume_of(model)->kind->create_passes(evaluator->field, &field, &volume->passes) : status;
}

static enum vw_status create_evaluation(struct vw_evaluator *evaluator) {
    evaluator->of_renderer = vw_allocate(1, sizeof(struct vw_volume_evaluation));
    enum vw_status status = evaluator->of_renderer ? create_buffers(evaluator) : VW_ERROR_MEMORY;
    return !status ? create_passes(evaluator) : status;
}

// Records the rays of one view. The field renders whole groups, of which the last may reach into the next view's rays:
// only those of this view are kept.
static void record_rays(const struct vw_evaluator *evaluator, struct vw_submission *submission, uint32_t first,
                        uint32_t count) {
    const struct vw_model *model = evaluator->field->model;
    const struct vw_volume_evaluation *volume = vw_volume_evaluation_of(evaluator);
    const uint32_t end = first + count;
    for (; first < end; first += volume->chunk_rays) {
        uint32_t rays = end - first < volume->chunk_rays ? end - first : volume->chunk_rays;
        struct vw_push_samples push = {.first_ray = first, .ray_count = vw_model_pad_rays(model, rays)};
        vw_importance_record(model, &volume->importance, submission, &push);
        vw_volume_of(model)->kind->record_forward(model, &volume->passes, submission, &push);
        push.ray_count = rays;
        vw_submission_dispatch(submission, volume->composite, &push, sizeof push,
                               (uint64_t)rays * model->specialization.ray_lanes);
    }
}

static void record_evaluation(const struct vw_evaluator *evaluator, struct vw_submission *submission) {
    if (!vw_evaluator_sees_photos(evaluator)) record_rays(evaluator, submission, 0, evaluator->ray_count);
    for (uint32_t i = 0; i < evaluator->view_count; i++) {
        vw_effects_record_photo(evaluator->field->model, &evaluator->effects, submission, evaluator->views[i].view);
        record_rays(evaluator, submission, evaluator->views[i].first, evaluator->views[i].count);
    }
}

const struct vw_renderer_evaluation vw_volume_renderer_evaluation = {
    .create = create_evaluation,
    .record = record_evaluation,
};
