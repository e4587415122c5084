#include "train/evaluator.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "gpu/shaders.h"
#include "train/effects/effects.h"
#include "train/passes.h"

enum { CHUNK_SAMPLES = 1 << 16 }; // 1 MiB of samples at a time

const char evaluator_role[] = "validation";

static enum vw_status create_buffers(uint32_t rays, struct vw_evaluator *evaluator) {
    uint64_t samples = (uint64_t)evaluator->chunk_rays * evaluator->field->model->ray_samples;
    const struct vw_buffer_row pixels = {&evaluator->pixels, "evaluated_pixels", sizeof(struct vw_pixel) * rays};
    const struct vw_buffer_row buffers[] = {
        {&evaluator->rays, "evaluated_rays", sizeof(struct vw_ray) * evaluator->ray_count},
        {&evaluator->samples, "evaluated_samples", 16 * samples},
        {&evaluator->colours, "colours", 16 * (uint64_t)evaluator->ray_count},
        {&evaluator->places, "sample_places",
         vw_importance_places_bytes(evaluator->field->model, evaluator->chunk_rays)},
    };
    enum vw_status status = vw_buffers_create(&evaluator->objects, VW_BUFFER_UPLOAD, &pixels, 1);
    return !status ? vw_buffers_create(&evaluator->objects, VW_BUFFER_DEVICE, buffers, VW_ARRAY_COUNT(buffers))
                   : status;
}

static enum vw_status create_passes(struct vw_evaluator *evaluator) {
    const struct vw_model *model = evaluator->field->model;
    struct vw_specialization specialization = vw_effects_specialise_validation(model);
    specialization.stores_rows = 0;
    struct vw_binding bindings[VW_SLOT_COUNT] = {
        {.slot = VW_SLOT_PIXELS, .buffer = evaluator->pixels},
        {.slot = VW_SLOT_RAYS, .buffer = evaluator->rays},
        {.slot = VW_SLOT_FIELD, .buffer = evaluator->samples},
        {.slot = VW_SLOT_COLOURS, .buffer = evaluator->colours},
        {.slot = VW_SLOT_KEPT_SAMPLES, .buffer = evaluator->places, .unused = !evaluator->places},
        {.slot = VW_SLOT_OVERFLOW, .unused = true},
    };
    uint32_t count = 6;
    vw_field_bind(evaluator->field, false, bindings, &count);
    const struct vw_effect_buffers of_effects = {evaluator->field->params, evaluator->field->effect_buffers, NULL};
    vw_effects_bind(model, &of_effects, bindings, &count);
    const struct vw_field_pass_params field = {
        .objects = &evaluator->objects, .common = vw_pass_params_of(&specialization, bindings, count, evaluator_role)};
    const struct vw_pass_row passes[] = {
        {&vw_shader_generate_rays, &evaluator->generate},
        {&vw_shader_composite_rays, &evaluator->composite},
    };
    enum vw_status status = vw_passes_create(&evaluator->objects, &field.common, passes, VW_ARRAY_COUNT(passes));
    evaluator->passes.specialization = specialization;
    if (!status) status = vw_importance_create(evaluator->field, &field, &specialization, NULL, &evaluator->importance);
    if (!status)
        status = vw_effects_create_passes(model, &evaluator->objects, &field.common, false, &evaluator->effects);
    return !status ? model->kind->create_passes(evaluator->field, &field, &evaluator->passes) : status;
}

static bool sees_photos(const struct vw_evaluator *evaluator) { return vw_effects_see_photos(evaluator->field->model); }

// Makes room for one more group: the last view's rays may begin within a group.
static enum vw_status make_room_for_views(uint32_t rays, struct vw_evaluator *evaluator) {
    if (!sees_photos(evaluator)) return VW_OK;
    evaluator->views = vw_allocate(rays, sizeof *evaluator->views);
    if (!evaluator->views) return VW_ERROR_MEMORY;
    evaluator->views[0] = (struct vw_view_rays){.count = evaluator->ray_count};
    evaluator->view_count = 1;
    evaluator->ray_count += evaluator->field->model->ray_group;
    return VW_OK;
}

enum vw_status vw_evaluator_create(struct vw_radiance_field *field, uint32_t rays, struct vw_evaluator *evaluator) {
    const struct vw_model *model = field->model;
    *evaluator = (struct vw_evaluator){
        .field = field, .objects = {.gpu = field->gpu}, .ray_count = vw_model_pad_rays(model, rays)};
    uint32_t chunk_samples = model->kind->renders_in_rows ? model->specialization.chunk_samples : CHUNK_SAMPLES,
             chunk_rays = chunk_samples / model->ray_samples / model->ray_group * model->ray_group;
    if (chunk_rays < model->ray_group) chunk_rays = model->ray_group;
    evaluator->chunk_rays = chunk_rays < evaluator->ray_count ? chunk_rays : evaluator->ray_count;
    enum vw_status status = make_room_for_views(rays, evaluator);
    if (!status) status = create_buffers(rays, evaluator);
    if (!status) status = create_passes(evaluator);
    if (!status) status = vw_submission_create(field->gpu, &evaluator->submission);
    if (status) vw_evaluator_destroy(evaluator);
    return status;
}

void vw_evaluator_destroy(struct vw_evaluator *evaluator) {
    vw_submission_destroy(&evaluator->submission);
    vw_gpu_objects_destroy(&evaluator->objects);
    free(evaluator->views);
    evaluator->views = NULL;
}

static void list_views(struct vw_evaluator *evaluator, const struct vw_pixel *pixels, uint32_t count) {
    evaluator->view_count = 0;
    for (uint32_t i = 0; i < count; i++) {
        if (i == 0 || pixels[i].view != pixels[i - 1].view)
            evaluator->views[evaluator->view_count++] = (struct vw_view_rays){.view = pixels[i].view, .first = i};
        evaluator->views[evaluator->view_count - 1].count++;
    }
}

enum vw_status vw_evaluator_set_pixels(struct vw_evaluator *evaluator, const struct vw_pixel *pixels, uint32_t count) {
    memcpy(vw_buffer_map(evaluator->pixels), pixels, count * sizeof *pixels);
    if (sees_photos(evaluator)) list_views(evaluator, pixels, count);
    struct vw_push_rays push = {.first_pixel = 0, .ray_count = count};
    vw_submission_begin(evaluator->submission);
    vw_submission_dispatch(evaluator->submission, evaluator->generate, &push, sizeof push, evaluator->ray_count);
    enum vw_status status = vw_submission_submit(evaluator->submission);
    return !status ? vw_submission_wait(evaluator->submission) : status;
}

// Records the rays of one view. The field renders whole groups, of which the last may reach into the next view's rays:
// only those of this view are kept.
static void record_rays(const struct vw_evaluator *evaluator, struct vw_submission *submission, uint32_t first,
                        uint32_t count) {
    const struct vw_model *model = evaluator->field->model;
    const uint32_t end = first + count;
    for (; first < end; first += evaluator->chunk_rays) {
        uint32_t rays = end - first < evaluator->chunk_rays ? end - first : evaluator->chunk_rays;
        struct vw_push_samples push = {.first_ray = first, .ray_count = vw_model_pad_rays(model, rays)};
        vw_importance_record(model, &evaluator->importance, submission, &push);
        model->kind->record_forward(model, &evaluator->passes, submission, &(struct vw_field_chunk){.rays = &push});
        push.ray_count = rays;
        vw_submission_dispatch(submission, evaluator->composite, &push, sizeof push, rays);
    }
}

uint32_t vw_evaluator_count_chunks(const struct vw_evaluator *evaluator) {
    uint32_t chunk = evaluator->chunk_rays, sum = 0;
    if (!sees_photos(evaluator)) return (evaluator->ray_count + chunk - 1) / chunk;
    for (uint32_t i = 0; i < evaluator->view_count; i++) sum += (evaluator->views[i].count + chunk - 1) / chunk;
    return sum;
}

void vw_evaluator_record(const struct vw_evaluator *evaluator, struct vw_submission *submission) {
    if (!sees_photos(evaluator)) record_rays(evaluator, submission, 0, evaluator->ray_count);
    for (uint32_t i = 0; i < evaluator->view_count; i++) {
        vw_effects_record_photo(evaluator->field->model, &evaluator->effects, submission, evaluator->views[i].view);
        record_rays(evaluator, submission, evaluator->views[i].first, evaluator->views[i].count);
    }
}

enum vw_status vw_evaluator_run(struct vw_evaluator *evaluator) {
    vw_submission_begin(evaluator->submission);
    vw_evaluator_record(evaluator, evaluator->submission);
    enum vw_status status = vw_submission_submit(evaluator->submission);
    return !status ? vw_submission_wait(evaluator->submission) : status;
}

enum vw_status vw_evaluator_render(struct vw_evaluator *evaluator, const struct vw_pixel *pixels, uint32_t count,
                                   vw_float4 *colours) {
    enum vw_status status = vw_evaluator_set_pixels(evaluator, pixels, count);
    if (!status) status = vw_evaluator_run(evaluator);
    return !status ? vw_buffer_read(evaluator->colours, 0, colours, count * sizeof *colours) : status;
}
