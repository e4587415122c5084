// Effects by which rays count less in the loss, as much as a small network says (shaders/effects/ray_network.glsl).
// Only training uses them, and one excludes the other. update_weights moves the network with all other weights.
//   predict_visibility: how much each ray counts -> backward_rays: the loss and its slope, times that ->
//   gradient_visibility, reduce_visibility: the network's gradient -> update_visibility: the photo's code
//
// `visibility`: what covers the scene in one photo alone is left out, by the pixel's place and a code of the photo,
// which is lazy (HA-NeRF's image-dependent 2-D mask, shaders/effects/visibility/visibility.glsl). Lasting credit keeps
// what is visible fixed: it leaves out how a step changes it for later steps.
//
// `uncertainty`: a pixel counts as much as a network of its features, which all photos share, is certain of it (NeRF
// On-the-go, shaders/effects/uncertainty/uncertainty.glsl). The host computes the features of the pixels that it draws
// (scene/features.h) and uploads them beside these. Its passes are variants of those of visibility, whose slots they
// take.
#include "train/effects/effects.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "gpu/shaders.h"
#include "scene/features.h"
#include "train/step.h"

struct network {
    uint32_t input4, layer2, logit, columns, params;
};

static const struct network visibility = {.input4 = VISIBILITY_INPUT4,
                                          .layer2 = VISIBILITY_LAYER2,
                                          .logit = VISIBILITY_LOGIT,
                                          .columns = VISIBILITY_COLUMNS,
                                          .params = 913},
                            uncertainty = {.input4 = FEATURE4,
                                           .layer2 = UNCERTAINTY_LAYER2,
                                           .logit = UNCERTAINTY_LOGIT,
                                           .columns = UNCERTAINTY_COLUMNS,
                                           .params = 801};

_Static_assert(VISIBILITY_INPUT4 == VISIBILITY_PLACE4 + VISIBILITY_CODE4 &&
                   VISIBILITY_PLACE4 == 1 + VISIBILITY_FREQUENCIES &&
                   VISIBILITY_LAYER2 == 4 * VISIBILITY4 * VISIBILITY_INPUT4 &&
                   VISIBILITY_BIAS2 == VISIBILITY_LAYER2 + 4 * VISIBILITY4 * VISIBILITY4 &&
                   VISIBILITY_LOGIT == VISIBILITY_BIAS2 + VISIBILITY4 &&
                   VISIBILITY_COLUMNS == VISIBILITY_LOGIT + VISIBILITY4 + 1,
               "the network's parts do not follow one another");
_Static_assert(4 * FEATURE4 == VW_FEATURES + 1, "a constant 1 does not follow the features");
_Static_assert(UNCERTAINTY_LAYER2 == 4 * VISIBILITY4 * FEATURE4 &&
                   UNCERTAINTY_BIAS2 == UNCERTAINTY_LAYER2 + 4 * VISIBILITY4 * VISIBILITY4 &&
                   UNCERTAINTY_LOGIT == UNCERTAINTY_BIAS2 + VISIBILITY4 &&
                   UNCERTAINTY_COLUMNS == UNCERTAINTY_LOGIT + VISIBILITY4 + 1,
               "the network's parts do not follow one another");

enum { PREDICT, GRADIENT, REDUCE }; // places of the passes

static const struct network *network_of(const struct vw_model *model) {
    return model->specialization.effect_uncertainty ? &uncertainty : &visibility;
}

// ---- What both have -------------------------------------------------------------------------------------------------

struct vw_param_range vw_visibility_network(const struct vw_model *model) {
    if (!model->specialization.effect_visibility) return (struct vw_param_range){0};
    return vw_model_columns(model, model->specialization.visibility_column, visibility.columns);
}

struct vw_param_range vw_uncertainty_network(const struct vw_model *model) {
    if (!model->specialization.effect_uncertainty) return (struct vw_param_range){0};
    return vw_model_columns(model, model->specialization.visibility_column, uncertainty.columns);
}

static void lay_out_columns(struct vw_model *model) {
    const struct network *network = network_of(model);
    model->specialization.visibility_column = vw_model_append_columns(model, network->columns, network->params);
}

// Draws the initial values: every ray counts about half.
static void initialise(const struct vw_model *model, const struct vw_drawn *drawn, void *params) {
    const struct network *network = network_of(model);
    uint64_t first = vw_model_columns(model, model->specialization.visibility_column, 0).offset_bytes;
    float *values = (float *)((char *)params + first);
    vw_fill_matrix(values, drawn, VISIBILITY4, network->input4);
    vw_fill_matrix(values + 4 * network->layer2, drawn, VISIBILITY4, VISIBILITY4);
    vw_fill_weights(values + 4 * network->logit, drawn, 4 * VISIBILITY4, 0.5f / VISIBILITY4);
}

static uint32_t groups_of(uint32_t rays) { return (rays + VISIBILITY_GROUP - 1) / VISIBILITY_GROUP; }

static uint32_t list_shared_buffers(const struct network *network, uint32_t padded_rays,
                                    struct vw_effect_buffer *buffers) {
    uint64_t rays = padded_rays, groups = groups_of(padded_rays);
    buffers[0] =
        (struct vw_effect_buffer){VW_SLOT_VISIBILITY, "visibility", 2 * sizeof(float) * rays, VW_EFFECT_OF_STEP};
    buffers[1] = (struct vw_effect_buffer){VW_SLOT_VISIBILITY_PARTIALS, "visibility_partials",
                                           sizeof(vw_float4) * network->columns * groups, VW_EFFECT_OF_STEP};
    return 2;
}

static void record_rays(const struct vw_step_passes *step, struct vw_pass *const *passes,
                        struct vw_submission *submission, const struct vw_push_rays *rays) {
    vw_submission_dispatch(submission, passes[PREDICT], rays, sizeof *rays, step->padded_rays);
}

static void record_gradient(const struct vw_step_passes *step, struct vw_pass *const *passes,
                            struct vw_submission *submission, const struct vw_push_rays *rays, uint64_t number) {
    (void)number;
    const struct vw_model *model = step->field->model;
    uint32_t padded_rays = vw_model_pad_rays(model, rays->ray_count);
    struct vw_push_reduce reduce = {.count = groups_of(padded_rays)};
    vw_submission_dispatch(submission, passes[GRADIENT], rays, sizeof *rays, padded_rays);
    vw_submission_dispatch(submission, passes[REDUCE], &reduce, sizeof reduce, network_of(model)->columns);
}

// ---- Visibility -----------------------------------------------------------------------------------------------------

static void lay_out_ranges(struct vw_model *model, uint64_t trained_views) {
    vw_model_append_range(model, VW_SLOT_VISIBILITY_CODES,
                          sizeof(vw_float4) * VISIBILITY_CODE4 * (uint64_t)model->view_count,
                          4 * VISIBILITY_CODE4 * trained_views);
}

static uint32_t list_visibility_buffers(const struct vw_model *model, uint32_t padded_rays,
                                        struct vw_effect_buffer *buffers) {
    uint32_t count = list_shared_buffers(&visibility, padded_rays, buffers);
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

const struct vw_effect_kind vw_effect_visibility = {
    .name = "visibility",
    .constant = VW_EFFECT_CONSTANT(visibility),
    .adjoint = VW_ADJOINT_HOLDS,
    .training_alone = true,
    .binds_ray_buffers = true,
    .shaders = {[PREDICT] = &vw_shader_predict_visibility,
                [GRADIENT] = &vw_shader_gradient_visibility,
                [REDUCE] = &vw_shader_reduce_visibility},
    .update = &vw_shader_update_visibility,
    .ranges = {VW_SLOT_VISIBILITY_CODES},
    .lay_out_columns = lay_out_columns,
    .lay_out_ranges = lay_out_ranges,
    .initialise = initialise,
    .list_buffers = list_visibility_buffers,
    .fill = fill,
    .record_rays = record_rays,
    .record_gradient = record_gradient,
};

// ---- Uncertainty ----------------------------------------------------------------------------------------------------

static uint32_t list_uncertainty_buffers(const struct vw_model *model, uint32_t padded_rays,
                                         struct vw_effect_buffer *buffers) {
    (void)model;
    uint32_t count = list_shared_buffers(&uncertainty, padded_rays, buffers);
    buffers[count++] =
        (struct vw_effect_buffer){VW_SLOT_FEATURES, "features", sizeof(vw_float4) * FEATURE4, VW_EFFECT_OF_PIXELS};
    return count;
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

const struct vw_effect_kind vw_effect_uncertainty = {
    .name = "uncertainty",
    .constant = VW_EFFECT_CONSTANT(uncertainty),
    .adjoint = VW_ADJOINT_REFUSES,
    .training_alone = true,
    .binds_ray_buffers = true,
    .shaders = {[PREDICT] = &vw_shader_predict_visibility_uncertainty,
                [GRADIENT] = &vw_shader_gradient_visibility_uncertainty,
                [REDUCE] = &vw_shader_reduce_visibility_uncertainty},
    .lay_out_columns = lay_out_columns,
    .initialise = initialise,
    .list_buffers = list_uncertainty_buffers,
    .draw_pixels = draw_pixels,
    .create = create,
    .record_rays = record_rays,
    .record_gradient = record_gradient,
};
