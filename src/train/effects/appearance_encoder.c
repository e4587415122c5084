// The effect `appearance_encoder` (HA-NeRF, Chen et al., CVPR 2022, section 3.1): photos that differ in exposure, white
// balance and light. A small convolutional network makes a code of 48 numbers from a photo's thumbnail
// (encode_photo.h); the code enters the colour network as those of appearance_code do. update_weights moves the network
// with all other weights.
//   convolve_photo, pool_photo: the photo's code and the shift of the colour network -> the field, forward and back ->
//   spread_photo, convolve_photo_back, gradient_photo: gradients of the network
// A photo that nothing was trained on has a code as well: validation and renders of a view see it by the view's own
// photo. They remain a function of the params alone: thumbnails are the scene's.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "gpu/shaders.h"
#include "train/effects/consistency.h"
#include "train/effects/encode_photo.h"
#include "train/step_passes.h"

// ---- Params ---------------------------------------------------------------------------------------------------------

enum { LAYER_BLOCKS = ENCODER_TAPS * ENCODER4 };
_Static_assert(THUMBNAIL_PIXELS == THUMBNAIL_SIDE * THUMBNAIL_SIDE && ENCODER_LAYERS == 3 &&
                   ENCODER_LAYER2 == 4 * LAYER_BLOCKS + ENCODER4 &&
                   ENCODER_LAYER3 == ENCODER_LAYER2 + 4 * LAYER_BLOCKS * ENCODER4 + ENCODER4 &&
                   ENCODER_CODE == ENCODER_LAYER3 + 4 * LAYER_BLOCKS * ENCODER4 + ENCODER4 &&
                   ENCODER_CODE_BIAS == ENCODER_CODE + 4 * CODE4 * ENCODER4 &&
                   ENCODER_SHIFT == ENCODER_CODE_BIAS + CODE4,
               "the network's parts do not follow one another");
_Static_assert(ENCODER_ROW_LAYER2 == ENCODER4 * THUMBNAIL_PIXELS / 4 &&
                   ENCODER_ROW_LAYER3 == ENCODER_ROW_LAYER2 + ENCODER4 * THUMBNAIL_PIXELS / 16 &&
                   ENCODER_ROW_MEAN == ENCODER_ROW_LAYER3 + ENCODER4 * THUMBNAIL_PIXELS / 64 &&
                   ENCODER_ROW_CODE == ENCODER_ROW_MEAN + ENCODER4 && ENCODER_ROWS == ENCODER_ROW_CODE + CODE4,
               "its rows do not follow one another");

// Draws weights within He's bound for what a convolution sums; biases and the matrix to the code stay 0.
static void draw_convolution(float *values, const struct vw_drawn *drawn, uint32_t inputs) {
    vw_fill_weights(values, drawn, LAYER_BLOCKS * 4 * (uint64_t)inputs, sqrtf(6.0f / (float)(ENCODER_TAPS * inputs)));
}

static void lay_out_columns(const struct vw_config *config, struct vw_model *model) {
    uint32_t columns = VW_ENCODER_COLUMNS(model->specialization.width4);
    model->specialization.encoder_column = vw_model_append_columns(model, columns, 4 * (uint64_t)columns);
    model->consistency_weight = config->consistency_weight;
    if (config->consistency_weight > 0.0) model->picture_side = (uint32_t)sqrt(config->rays);
}

// Makes all codes 0 at first, so that the field starts as it would without them.
static void initialise(const struct vw_model *model, const struct vw_drawn *drawn, void *params) {
    float *values = (float *)((char *)params + vw_encoder_network(model).offset_bytes);
    draw_convolution(values, drawn, 4);
    draw_convolution(values + 4 * ENCODER_LAYER2, drawn, 4 * ENCODER4);
    draw_convolution(values + 4 * ENCODER_LAYER3, drawn, 4 * ENCODER4);
    vw_fill_matrix(values + 4 * ENCODER_SHIFT, drawn, model->specialization.width4, CODE4);
}

// ---- Buffers --------------------------------------------------------------------------------------------------------

static uint32_t list_buffers(const struct vw_model *model, uint32_t padded_rays, struct vw_effect_buffer *buffers) {
    (void)padded_rays;
    uint64_t photos = model->view_count, width4 = model->specialization.width4;
    const struct vw_effect_buffer listed[] = {
        {VW_SLOT_THUMBNAILS, "thumbnails", sizeof(vw_float4) * THUMBNAIL_PIXELS * photos, VW_EFFECT_OF_FIELD},
        {VW_SLOT_ENCODER_ROWS, "encoder_rows", sizeof(vw_float4) * ENCODER_ROWS, VW_EFFECT_OF_FIELD},
        {VW_SLOT_CODE_SHIFT, "code_shift", sizeof(vw_float4) * width4, VW_EFFECT_OF_FIELD},
        {VW_SLOT_D_ENCODER_ROWS, "d_encoder_rows", sizeof(vw_float4) * ENCODER_ROW_MEAN, VW_EFFECT_OF_STEP},
    };
    memcpy(buffers, listed, sizeof listed);
    return VW_ARRAY_COUNT(listed);
}

// Makes the thumbnails of all photos. VW_ERROR_USAGE where they are too many for the device.
static enum vw_status fill(const struct vw_model *model, struct vw_gpu *gpu, const struct vw_scene *scene,
                           struct vw_buffer *const *buffers) {
    uint64_t size_bytes = (uint64_t)scene->view_count * THUMBNAIL_PIXELS * sizeof(vw_float4);
    if (size_bytes > vw_gpu_get_limits(gpu)->storage_binding_bytes)
        return vw_fail(VW_ERROR_USAGE,
                       "--effects: appearance_encoder: the thumbnails of %u photos exceed this device's binding range; "
                       "leave it out, or exclude photos",
                       scene->view_count);
    enum vw_status status = vw_scene_decode_all(scene);
    if (status) return status;
    vw_float4 *thumbnails = vw_allocate(size_bytes, 1); // 0 for excluded photos, which have no pixels
    if (!thumbnails) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < scene->view_count; i++) {
        const struct vw_thumbnail_choice whole = {vw_pixels_all_columns(scene, i), model->obeys_masks};
        if (scene->views[i].image.pixels)
            vw_thumbnail_make(&scene->views[i], &whole, thumbnails + (size_t)THUMBNAIL_PIXELS * i);
    }
    status = vw_buffer_write(buffers[VW_SLOT_THUMBNAILS], 0, thumbnails, size_bytes);
    free(thumbnails);
    return status;
}

// ---- Passes ---------------------------------------------------------------------------------------------------------

static enum vw_status create(struct vw_step_passes *step) { return vw_consistency_create(step, &step->consistency); }
static void destroy(struct vw_step_passes *step) { vw_consistency_destroy(&step->consistency); }

static void record_rays(const struct vw_step_passes *step, struct vw_pass *const *passes,
                        struct vw_submission *submission, const struct vw_push_rays *rays) {
    (void)passes;
    vw_consistency_record_rays(step->consistency, submission, rays);
}

static void record_photo(const struct vw_model *model, struct vw_pass *const *passes, struct vw_submission *submission,
                         uint32_t view) {
    (void)model;
    vw_encoder_record_forward(passes, submission, view);
}

static void record_gradient(const struct vw_step_passes *step, struct vw_pass *const *passes,
                            struct vw_submission *submission, const struct vw_push_rays *rays, uint64_t number) {
    (void)rays;
    vw_encoder_record_back(passes, NULL, submission);
    vw_consistency_record_gradients(step, submission, number);
}

const struct vw_effect_kind vw_effect_appearance_encoder = {
    .name = "appearance_encoder",
    .constant = VW_EFFECT_CONSTANT(appearance_encoder),
    .adjoint = VW_ADJOINT_REFUSES,
    .sees_photos = true,
    .shaders = {[ENCODER_CONVOLVE] = &vw_shader_convolve_photo,
                [ENCODER_POOL] = &vw_shader_pool_photo,
                [ENCODER_SPREAD] = &vw_shader_spread_photo,
                [ENCODER_CONVOLVE_BACK] = &vw_shader_convolve_photo_back,
                [ENCODER_GRADIENT] = &vw_shader_gradient_photo},
    .photo_pass_count = ENCODER_SPREAD,
    .lay_out_columns = lay_out_columns,
    .initialise = initialise,
    .list_buffers = list_buffers,
    .fill = fill,
    .create = create,
    .destroy = destroy,
    .record_rays = record_rays,
    .record_photo = record_photo,
    .record_gradient = record_gradient,
};
