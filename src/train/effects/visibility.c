// The effect `visibility`: what covers the scene in one photo alone is left out of the loss, as much as a small
// network of the pixel's place and of a code of the photo says so (HA-NeRF's image-dependent 2-D mask,
// shaders/effects/visibility/visibility.glsl). update_weights moves the network with all other weights; codes are lazy.
//   predict_visibility: how visible each ray is -> backward_rays: the loss and its slope, times that ->
//   gradient_visibility, reduce_visibility: the network's gradient -> update_visibility: the photo's code
// Only training uses it. Lasting credit keeps what is visible fixed: it leaves out how a step changes it for later
// steps.
#include "train/effects/visibility.h"

#include <stdlib.h>

#include "base/memory.h"
#include "gpu/shaders.h"
#include "train/effects/ray_network.h"
#include "train/step_passes.h"

static const struct vw_ray_network network = {.input4 = VISIBILITY_INPUT4,
                                              .layer2 = VISIBILITY_LAYER2,
                                              .logit = VISIBILITY_LOGIT,
                                              .columns = VISIBILITY_COLUMNS,
                                              .params = 913,
                                              .code4 = VISIBILITY_CODE4};

_Static_assert(VISIBILITY_INPUT4 == VISIBILITY_PLACE4 + VISIBILITY_CODE4 &&
                   VISIBILITY_PLACE4 == 1 + VISIBILITY_FREQUENCIES &&
                   VISIBILITY_LAYER2 == 4 * VISIBILITY4 * VISIBILITY_INPUT4 &&
                   VISIBILITY_BIAS2 == VISIBILITY_LAYER2 + 4 * VISIBILITY4 * VISIBILITY4 &&
                   VISIBILITY_LOGIT == VISIBILITY_BIAS2 + VISIBILITY4 &&
                   VISIBILITY_COLUMNS == VISIBILITY_LOGIT + VISIBILITY4 + 1,
               "the network's parts do not follow one another");

// ---- Params ---------------------------------------------------------------------------------------------------------

struct vw_param_range vw_visibility_network(const struct vw_model *model) {
    if (!model->specialization.effect_visibility) return (struct vw_param_range){0};
    return vw_model_columns(model, model->specialization.visibility_column, VISIBILITY_COLUMNS);
}

static void lay_out_columns(const struct vw_config *config, struct vw_model *model) {
    (void)config;
    model->specialization.visibility_column = vw_model_append_columns(model, network.columns, network.params);
}

static void lay_out_ranges(struct vw_model *model, uint64_t trained_views) {
    vw_model_append_range(model, VW_SLOT_VISIBILITY_CODES,
                          sizeof(vw_float4) * VISIBILITY_CODE4 * (uint64_t)model->view_count,
                          4 * VISIBILITY_CODE4 * trained_views);
}

static void initialise(const struct vw_model *model, const struct vw_drawn *drawn, void *params) {
    float *values = (float *)((char *)params + vw_visibility_network(model).offset_bytes);
    vw_ray_network_initialise(&network, drawn, values);
}

// ---- Buffers --------------------------------------------------------------------------------------------------------

static uint32_t list_buffers(const struct vw_model *model, uint32_t padded_rays, struct vw_effect_buffer *buffers) {
    uint32_t count = vw_ray_network_list_buffers(&network, padded_rays, buffers);
    uint64_t photos = model->view_count;
    buffers[count++] =
        (struct vw_effect_buffer){VW_SLOT_PHOTO_SCALES, "photo_scales", 2 * sizeof(float) * photos, VW_EFFECT_OF_FIELD};
    buffers[count++] = (struct vw_effect_buffer){VW_SLOT_VISIBILITY_MOMENTS, "visibility_moments",
                                                 sizeof(struct vw_visibility_moments) * photos, VW_EFFECT_CARRIED};
    return count;
}

// Writes the scales from pixels to the network's coordinates.
static enum vw_status fill(const struct vw_model *model, struct vw_gpu *gpu, const struct vw_scene *scene,
                           struct vw_buffer *const *buffers) {
    (void)model, (void)gpu;
    float *values = vw_allocate(scene->view_count, 2 * sizeof *values);
    if (!values) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < scene->view_count; i++) {
        values[2 * i] = 2.0f / (float)scene->views[i].image.width_px;
        values[2 * i + 1] = 2.0f / (float)scene->views[i].image.height_px;
    }
    enum vw_status status =
        vw_buffer_write(buffers[VW_SLOT_PHOTO_SCALES], 0, values, 2 * sizeof *values * scene->view_count);
    free(values);
    return status;
}

// ---- Recording ------------------------------------------------------------------------------------------------------

static void record_gradient(const struct vw_step_passes *step, struct vw_pass *const *passes,
                            struct vw_submission *submission, const struct vw_push_rays *rays, uint64_t number) {
    (void)number;
    vw_ray_network_record_gradient(&network, step, passes, submission, rays);
}

const struct vw_effect_kind vw_effect_visibility = {
    .name = "visibility",
    .constant = VW_EFFECT_CONSTANT(visibility),
    .adjoint = VW_ADJOINT_HOLDS,
    .training_alone = true,
    .binds_ray_buffers = true,
    .shaders = {[VW_RAY_NETWORK_PREDICT] = &vw_shader_predict_visibility,
                [VW_RAY_NETWORK_GRADIENT] = &vw_shader_gradient_visibility,
                [VW_RAY_NETWORK_REDUCE] = &vw_shader_reduce_visibility},
    .update = &vw_shader_update_visibility,
    .ranges = {VW_SLOT_VISIBILITY_CODES},
    .lay_out_columns = lay_out_columns,
    .lay_out_ranges = lay_out_ranges,
    .initialise = initialise,
    .list_buffers = list_buffers,
    .fill = fill,
    .record_rays = vw_ray_network_record_rays,
    .record_gradient = record_gradient,
};
