// The effect `uncertainty`: a pixel counts in the loss as much as a small network of its features, which all photos
// share, is certain of it (NeRF On-the-go, shaders/effects/uncertainty/uncertainty.glsl). The host computes the
// features of the pixels that it draws (scene/features.h) and uploads them beside these. Passes, but for the update of
// a code, are variants of those of visibility, whose slots they take: one excludes the other. update_weights moves the
// network with all other weights. Only training uses it.
#include "train/effects/uncertainty.h"

#include <string.h>

#include "gpu/shaders.h"
#include "scene/features.h"
#include "train/effects/ray_network.h"
#include "train/step_passes.h"

static const struct vw_ray_network network = {.input4 = FEATURE4,
                                              .layer2 = UNCERTAINTY_LAYER2,
                                              .logit = UNCERTAINTY_LOGIT,
                                              .columns = UNCERTAINTY_COLUMNS,
                                              .params = 801};

_Static_assert(4 * FEATURE4 == VW_FEATURES + 1, "a constant 1 does not follow the features");
_Static_assert(UNCERTAINTY_LAYER2 == 4 * VISIBILITY4 * FEATURE4 &&
                   UNCERTAINTY_BIAS2 == UNCERTAINTY_LAYER2 + 4 * VISIBILITY4 * VISIBILITY4 &&
                   UNCERTAINTY_LOGIT == UNCERTAINTY_BIAS2 + VISIBILITY4 &&
                   UNCERTAINTY_COLUMNS == UNCERTAINTY_LOGIT + VISIBILITY4 + 1,
               "the network's parts do not follow one another");

struct vw_param_range vw_uncertainty_network(const struct vw_model *model) {
    if (!model->specialization.effect_uncertainty) return (struct vw_param_range){0};
    return vw_model_columns(model, model->specialization.visibility_column, UNCERTAINTY_COLUMNS);
}

static void lay_out_columns(const struct vw_config *config, struct vw_model *model) {
    (void)config;
    model->specialization.visibility_column = vw_model_append_columns(model, network.columns, network.params);
}

static void initialise(const struct vw_model *model, const struct vw_drawn *drawn, void *params) {
    float *values = (float *)((char *)params + vw_uncertainty_network(model).offset_bytes);
    vw_ray_network_initialise(&network, drawn, values);
}

static uint32_t list_buffers(const struct vw_model *model, uint32_t padded_rays, struct vw_effect_buffer *buffers) {
    (void)model;
    return vw_ray_network_list_buffers(&network, padded_rays, buffers);
}

static enum vw_status create(struct vw_step_passes *step) { return vw_features_open(step->field->scene); }

// Leaves out pixels that do not count: their features may be of nothing.
static void draw_pixels(const struct vw_step_passes *step, uint32_t view, uint32_t first_pixel) {
    const struct vw_pixel *pixels = step->drawn;
    float *features =
        (float *)vw_buffer_map(step->effect_buffers[VW_SLOT_FEATURES]) + (size_t)4 * FEATURE4 * first_pixel;
    for (uint32_t i = 0; i < step->rays; i++, features += 4 * FEATURE4) {
        if (pixels[i].weight == 0.0f) memset(features, 0, VW_FEATURES * sizeof *features);
        else vw_features_at(step->field->scene, view, pixels[i].x_px, pixels[i].y_px, features);
        features[VW_FEATURES] = 1.0f;
    }
}

static void record_gradient(const struct vw_step_passes *step, struct vw_pass *const *passes,
                            struct vw_submission *submission, const struct vw_push_rays *rays, uint64_t number) {
    (void)number;
    vw_ray_network_record_gradient(&network, step, passes, submission, rays);
}

const struct vw_effect_kind vw_effect_uncertainty = {
    .name = "uncertainty",
    .constant = VW_EFFECT_CONSTANT(uncertainty),
    .adjoint = VW_ADJOINT_REFUSES,
    .training_alone = true,
    .binds_ray_buffers = true,
    .shaders = {[VW_RAY_NETWORK_PREDICT] = &vw_shader_predict_visibility_uncertainty,
                [VW_RAY_NETWORK_GRADIENT] = &vw_shader_gradient_visibility_uncertainty,
                [VW_RAY_NETWORK_REDUCE] = &vw_shader_reduce_visibility_uncertainty},
    .lay_out_columns = lay_out_columns,
    .initialise = initialise,
    .list_buffers = list_buffers,
    .pixel_slot = VW_SLOT_FEATURES,
    .pixel_bytes = sizeof(vw_float4) * FEATURE4,
    .draw_pixels = draw_pixels,
    .create = create,
    .record_rays = vw_ray_network_record_rays,
    .record_gradient = record_gradient,
};
