#include "train/effects/consistency.h"

#include <stdlib.h>

#include "base/memory.h"
#include "base/random.h"
#include "gpu/shaders.h"
#include "train/effects/effects.h"
#include "train/effects/encode_photo.h"
#include "train/passes.h"
#include "train/photo_order.h"

// ---- Creation -------------------------------------------------------------------------------------------------------

static enum vw_status create_buffers(const struct vw_step_passes *step, struct vw_consistency_effect *it) {
    uint64_t rays = it->padded_rays, columns = step->field->model->moved_columns;
    const struct vw_buffer_row buffers[] = {
        {&it->rays, "picture_rays", sizeof(struct vw_ray) * rays},
        {&it->ray_loss, "picture_ray_loss", sizeof(float) * rays}, // unread
        {&it->colours, "picture_colours", sizeof(vw_float4) * rays},
        {&it->d_sky, "picture_d_sky", step->effect_buffers[VW_SLOT_D_SKY] ? sizeof(vw_float4) * rays : 0},
        // 0 where this loss has no gradient
        {&it->d_weights, "picture_d_weights", sizeof(vw_float4) * columns},
        {&it->thumbnail, "picture_thumbnail", sizeof(vw_float4) * THUMBNAIL_PIXELS},
        {&it->encoder_rows, "picture_encoder_rows", sizeof(vw_float4) * ENCODER_ROWS},
        {&it->d_encoder_rows, "picture_d_encoder_rows", sizeof(vw_float4) * ENCODER_ROW_MEAN},
        {&it->code_shift, // unread
         "picture_code_shift", vw_buffer_size_bytes(step->field->effect_buffers[VW_SLOT_CODE_SHIFT])},
    };
    return vw_buffers_create(&it->objects, VW_BUFFER_DEVICE, buffers, VW_ARRAY_COUNT(buffers));
}

// Returns the step's passes with the picture's buffers in place of its own.
static struct vw_step_passes step_of_picture(const struct vw_step_passes *step,
                                             const struct vw_consistency_effect *it) {
    struct vw_step_passes own = *step;
    own.ray_buffer = it->rays;
    own.ray_loss = it->ray_loss;
    own.effect_buffers[VW_SLOT_D_SKY] = it->d_sky;
    own.d_weights = it->d_weights;
    return own;
}

// Bindings that are not the step's.
static uint32_t bind_own(const struct vw_step_passes *step, const struct vw_consistency_effect *it,
                         struct vw_binding *bindings) {
    bindings[0] =
        (struct vw_binding){.slot = VW_SLOT_GIVEN_ROWS, .buffer = step->field->effect_buffers[VW_SLOT_ENCODER_ROWS]};
    bindings[1] = (struct vw_binding){.slot = VW_SLOT_OWN_D_WEIGHTS, .buffer = it->d_weights};
    bindings[2] = (struct vw_binding){.slot = VW_SLOT_SEEN_AHEAD, .buffer = it->colours};
    bindings[3] = (struct vw_binding){.slot = VW_SLOT_ADJOINT_STATE, .unused = true};
    return 4;
}

// Creates the passes over the buffers of the step. Outside of training the push block names a photo.
static enum vw_status create_on_step(const struct vw_step_passes *step, const struct vw_specialization *rendering,
                                     struct vw_consistency_effect *it) {
    struct vw_binding bindings[VW_SLOT_COUNT];
    uint32_t count = bind_own(step, it, bindings);
    vw_step_bind(step, bindings, &count);
    const struct vw_pass_params params = vw_pass_params_of(rendering, bindings, count, NULL);
    enum vw_status status = vw_encoder_create_passes(&it->objects, &params, false, &it->give);
    return !status ? vw_pass_create_of(&it->objects, &params, &vw_shader_add_gradients, &it->add) : status;
}

static enum vw_status create_on_picture(const struct vw_step_passes *step, const struct vw_specialization *rendering,
                                        struct vw_consistency_effect *it) {
    const struct vw_specialization *given = &it->gradient.specialization;
    const struct vw_shader *composite = vw_effects_are_of_rays(step->field->model, given)
                                            ? &vw_shader_difference_rays_effects
                                            : &vw_shader_difference_rays;
    struct vw_step_passes own = step_of_picture(step, it);
    struct vw_radiance_field field = *step->field;
    field.effect_buffers[VW_SLOT_THUMBNAILS] = it->thumbnail;
    field.effect_buffers[VW_SLOT_ENCODER_ROWS] = it->encoder_rows;
    field.effect_buffers[VW_SLOT_CODE_SHIFT] = it->code_shift;
    own.effect_buffers[VW_SLOT_D_ENCODER_ROWS] = it->d_encoder_rows;
    own.field = &field;
    struct vw_binding bindings[VW_SLOT_COUNT];
    uint32_t count = bind_own(step, it, bindings);
    vw_step_bind(&own, bindings, &count);
    const struct vw_pass_params renders = vw_pass_params_of(rendering, bindings, count, NULL),
                                composites = vw_pass_params_of(given, bindings, count, NULL);
    const struct vw_pass_row rows[] = {{&vw_shader_shrink_colours, &it->shrink},
                                       {&vw_shader_spread_colours, &it->spread_colours}};
    enum vw_status status = vw_encoder_create_passes(&it->objects, &renders, true, &it->see);
    if (!status) status = vw_passes_create(&it->objects, &renders, rows, VW_ARRAY_COUNT(rows));
    return !status ? vw_pass_create_of(&it->objects, &composites, composite, &it->composite) : status;
}

static enum vw_status create_passes(const struct vw_step_passes *step, struct vw_consistency_effect *it) {
    struct vw_specialization given = step->field->model->specialization, rendering = given;
    const struct vw_step_passes own = step_of_picture(step, it);
    given.loss = LOSS_GIVEN;
    rendering.training = 0;
    enum vw_status status = vw_gradient_create(&own, &it->objects, &given, &it->gradient);
    if (!status) status = create_on_step(step, &rendering, it);
    return !status ? create_on_picture(step, &rendering, it) : status;
}

enum vw_status vw_consistency_create(const struct vw_step_passes *step, struct vw_consistency_effect **consistency) {
    const struct vw_model *model = step->field->model;
    if (model->consistency_weight == 0.0) return VW_OK;
    struct vw_consistency_effect *it = *consistency = vw_allocate(1, sizeof *it);
    if (!it) return VW_ERROR_MEMORY;
    it->objects.gpu = step->field->gpu;
    it->side = model->picture_side;
    it->ray_count = it->side * it->side;
    it->padded_rays = vw_model_pad_rays(model, it->ray_count);
    it->codes.slope = (float)(model->consistency_weight * step->rays / (4 * CODE4));
    enum vw_status status = create_buffers(step, it);
    if (!status) status = create_passes(step, it);
    if (status) vw_consistency_destroy(consistency);
    return status;
}

void vw_consistency_destroy(struct vw_consistency_effect **consistency) {
    struct vw_consistency_effect *it = *consistency;
    if (!it) return;
    vw_gpu_objects_destroy(&it->objects);
    free(it);
    *consistency = NULL;
}

// ---- Recording ------------------------------------------------------------------------------------------------------

void vw_consistency_record_rays(const struct vw_consistency_effect *it, struct vw_submission *submission,
                                const struct vw_push_rays *rays) {
    if (!it) return;
    struct vw_push_rays own = *rays;
    own.ray_count = it->ray_count;
    vw_submission_dispatch(submission, it->gradient.generate, &own, sizeof own, it->padded_rays);
}

uint32_t vw_consistency_given_view(const struct vw_step_passes *step, uint64_t number) {
    uint32_t words[4];
    vw_random_words(step->field->model->seed, VW_RANDOM_GIVEN_PHOTO, number, 0, 0, words);
    uint64_t drawn = (uint64_t)words[0] << 32 | words[1];
    return vw_photo_order_view_of_step(step->photo_order, 1 + drawn % number);
}

static void record_forward(const struct vw_step_passes *step, struct vw_submission *submission,
                           const struct vw_push_samples *chunk) {
    const struct vw_gradient_passes *gradient = &step->consistency->gradient;
    vw_importance_record(step->field->model, &gradient->importance, submission, chunk);
    vw_gradient_record_forward(step, &gradient->field, submission, chunk);
}

static void record_picture(const struct vw_step_passes *step, struct vw_submission *submission, vw_uint4 key) {
    const struct vw_consistency_effect *it = step->consistency;
    const struct vw_push_picture picture = {.side = it->side};
    for (uint32_t first = 0; first < it->padded_rays; first += step->chunk_rays) {
        const struct vw_push_samples chunk = vw_gradient_chunk(step, it->padded_rays, first, key);
        const struct vw_push_difference composite = {
            .first_ray = chunk.first_ray, .ray_count = chunk.ray_count, .key = key, .ahead = 1};
        record_forward(step, submission, &chunk);
        vw_submission_dispatch(submission, it->composite, &composite, sizeof composite, chunk.ray_count);
    }
    vw_submission_dispatch(submission, it->shrink, &picture, sizeof picture, THUMBNAIL_PIXELS);
    vw_encoder_record_forward(it->see.passes, submission, 0);
    vw_encoder_record_back(it->see.passes, &it->codes, submission);
    vw_submission_dispatch(submission, it->spread_colours, &picture, sizeof picture, it->padded_rays);
}

// Records the backward pass. The next chunk overwrites the last chunk's activations: with more than one chunk they are
// recomputed.
static void record_back(const struct vw_step_passes *step, struct vw_submission *submission, vw_uint4 key) {
    const struct vw_consistency_effect *it = step->consistency;
    for (uint32_t first = 0; first < it->padded_rays; first += step->chunk_rays) {
        const struct vw_push_samples chunk = vw_gradient_chunk(step, it->padded_rays, first, key);
        if (it->padded_rays > step->chunk_rays) record_forward(step, submission, &chunk);
        vw_gradient_record_back(step, &it->gradient, submission, &chunk);
    }
    vw_gradient_record_end(step, &it->gradient, submission, it->padded_rays);
    vw_submission_dispatch(submission, it->add, NULL, 0, step->field->model->moved_columns);
}

void vw_consistency_record_gradients(const struct vw_step_passes *step, struct vw_submission *submission,
                                     uint64_t number) {
    if (!step->consistency) return;
    const vw_uint4 key = vw_model_key_of_step(step->field->model, number);
    vw_encoder_record_forward(step->consistency->give.passes, submission, vw_consistency_given_view(step, number));
    record_picture(step, submission, key);
    record_back(step, submission, key);
}
