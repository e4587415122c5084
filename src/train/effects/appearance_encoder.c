#include "train/effects/appearance_encoder.h"

#include <stdlib.h>

#include "base/memory.h"
#include "gpu/shaders.h"

// ---- What the field has ---------------------------------------------------------------------------------------------

static enum vw_status create_thumbnails(struct vw_gpu *gpu, const struct vw_model *model, const struct vw_scene *scene,
                                        struct vw_appearance_encoder_effect *encoder) {
    uint64_t size_bytes = (uint64_t)scene->view_count * THUMBNAIL_PIXELS * sizeof(vw_float4);
    if (size_bytes > vw_gpu_get_limits(gpu)->storage_binding_bytes)
        return vw_fail(VW_ERROR_USAGE,
                       "--effects: appearance_encoder: the thumbnails of %u photos exceed this device's binding range; "
                       "leave it out, or exclude photos",
                       scene->view_count);
    enum vw_status status = vw_scene_decode_all(scene);
    if (status) return status;
    vw_float4 *thumbnails = vw_allocate(size_bytes, 1); // of excluded photos, which have no pixels: 0
    if (!thumbnails) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < scene->view_count; i++) {
        const struct vw_thumbnail_choice whole = {vw_pixels_all_columns(scene, i), model->obeys_masks};
        if (scene->views[i].image.pixels)
            vw_thumbnail_make(&scene->views[i], &whole, thumbnails + (size_t)THUMBNAIL_PIXELS * i);
    }
    const struct vw_buffer_params buffer = {.name = "thumbnails", .size_bytes = size_bytes};
    status = vw_buffer_create(gpu, &buffer, &encoder->thumbnails);
    if (!status) status = vw_buffer_write(encoder->thumbnails, 0, thumbnails, size_bytes);
    free(thumbnails);
    return status;
}

enum vw_status vw_encoder_create(struct vw_gpu *gpu, const struct vw_model *model, const struct vw_scene *scene,
                                 struct vw_appearance_encoder_effect *encoder) {
    const struct vw_buffer_params rows = {.name = "encoder_rows", .size_bytes = sizeof(vw_float4) * ENCODER_ROWS},
                                  shift = {.name = "code_shift",
                                           .size_bytes = sizeof(vw_float4) * (uint64_t)model->specialization.width4};
    if (!model->encoder.size_bytes) return VW_OK;
    enum vw_status status = create_thumbnails(gpu, model, scene, encoder);
    if (!status) status = vw_buffer_create(gpu, &rows, &encoder->rows);
    return !status ? vw_buffer_create(gpu, &shift, &encoder->code_shift) : status;
}

void vw_encoder_destroy(struct vw_appearance_encoder_effect *encoder) {
    vw_buffer_destroy(&encoder->thumbnails);
    vw_buffer_destroy(&encoder->rows);
    vw_buffer_destroy(&encoder->code_shift);
}

enum vw_status vw_encoder_set_thumbnail(const struct vw_appearance_encoder_effect *encoder,
                                        const struct vw_scene *scene, uint32_t view,
                                        const struct vw_thumbnail_choice *choice) {
    vw_float4 thumbnail[THUMBNAIL_PIXELS];
    if (!encoder->thumbnails) return VW_OK;
    vw_thumbnail_make(&scene->views[view], choice, thumbnail);
    return vw_buffer_write(encoder->thumbnails, (uint64_t)view * sizeof thumbnail, thumbnail, sizeof thumbnail);
}

void vw_encoder_bind(const struct vw_appearance_encoder_effect *encoder, const struct vw_encoder_gradient *gradient,
                     struct vw_binding *bindings, uint32_t *count) {
    if (!encoder->thumbnails) return; // only passes of its own declare these
    bindings[(*count)++] = (struct vw_binding){.slot = VW_SLOT_THUMBNAILS, .buffer = encoder->thumbnails};
    bindings[(*count)++] = (struct vw_binding){.slot = VW_SLOT_ENCODER_ROWS, .buffer = encoder->rows};
    bindings[(*count)++] = (struct vw_binding){.slot = VW_SLOT_CODE_SHIFT, .buffer = encoder->code_shift};
    if (gradient)
        bindings[(*count)++] = (struct vw_binding){.slot = VW_SLOT_D_ENCODER_ROWS, .buffer = gradient->d_rows};
}

// ---- Forward --------------------------------------------------------------------------------------------------------

static enum vw_status create_pass(struct vw_gpu *gpu, struct vw_pass_params params, const struct vw_shader *shader,
                                  struct vw_pass **pass) {
    params.shader = shader;
    return vw_pass_create(gpu, &params, pass);
}

enum vw_status vw_encoder_create_passes(struct vw_gpu *gpu, const struct vw_appearance_encoder_effect *encoder,
                                        const struct vw_pass_params *params, struct vw_encoder_passes *passes) {
    if (!encoder->thumbnails) return VW_OK;
    enum vw_status status = create_pass(gpu, *params, &vw_shader_convolve_photo, &passes->convolve);
    return !status ? create_pass(gpu, *params, &vw_shader_pool_photo, &passes->pool) : status;
}

void vw_encoder_destroy_passes(struct vw_encoder_passes *passes) {
    vw_pass_destroy(&passes->convolve);
    vw_pass_destroy(&passes->pool);
}

void vw_encoder_record_forward(const struct vw_encoder_passes *passes, struct vw_submission *batch, uint32_t view) {
    struct vw_push_photo push = {.view = view};
    if (!passes->convolve) return;
    for (; push.layer < ENCODER_LAYERS; push.layer++)
        vw_submission_dispatch(batch, passes->convolve, &push, sizeof push,
                               (uint64_t)ENCODER4 * THUMBNAIL_PIXELS >> 2 * (push.layer + 1));
    vw_submission_dispatch(batch, passes->pool, NULL, 0, 1);
}

// ---- Back -----------------------------------------------------------------------------------------------------------

enum vw_status vw_encoder_gradient_create_buffers(struct vw_gpu *gpu, const struct vw_model *model,
                                                  struct vw_encoder_gradient *gradient) {
    const struct vw_buffer_params rows = {.name = "d_encoder_rows", .size_bytes = sizeof(vw_float4) * ENCODER_ROW_MEAN};
    return model->encoder.size_bytes ? vw_buffer_create(gpu, &rows, &gradient->d_rows) : VW_OK;
}

enum vw_status vw_encoder_gradient_create_passes(struct vw_gpu *gpu, const struct vw_pass_params *params,
                                                 const struct vw_shader *spread, struct vw_encoder_gradient *gradient) {
    const struct {
        const struct vw_shader *shader;
        struct vw_pass **pass;
    } passes[] = {
        {spread, &gradient->spread},
        {&vw_shader_convolve_photo_back, &gradient->convolve_back},
        {&vw_shader_gradient_photo, &gradient->gradient},
    };
    enum vw_status status = VW_OK;
    for (size_t i = 0; i < VW_ARRAY_COUNT(passes) && gradient->d_rows && !status; i++)
        status = create_pass(gpu, *params, passes[i].shader, passes[i].pass);
    return status;
}

void vw_encoder_gradient_destroy(struct vw_encoder_gradient *gradient) {
    vw_pass_destroy(&gradient->spread);
    vw_pass_destroy(&gradient->convolve_back);
    vw_pass_destroy(&gradient->gradient);
    vw_buffer_destroy(&gradient->d_rows);
}

void vw_encoder_gradient_record(const struct vw_encoder_gradient *gradient, const struct vw_push_codes *codes,
                                struct vw_submission *batch) {
    struct vw_push_photo push = {.layer = ENCODER_LAYERS - 1};
    if (!gradient->spread) return;
    vw_submission_dispatch(batch, gradient->spread, codes, codes ? sizeof *codes : 0, 1);
    for (; push.layer > 0; push.layer--)
        vw_submission_dispatch(batch, gradient->convolve_back, &push, sizeof push,
                               (uint64_t)ENCODER4 * THUMBNAIL_PIXELS >> 2 * push.layer);
    vw_submission_dispatch(batch, gradient->gradient, NULL, 0, ENCODER_CODE);
}
