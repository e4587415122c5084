// The renderer `splats`: 3-D Gaussians, drawn tile by tile (Kerbl et al., SIGGRAPH 2023), a fixed number of them.
#include <math.h>

#include "base/memory.h"
#include "train/model.h"
#include "train/renderers/registry.h"
#include "train/renderers/splats/splats.h"

enum {
    SPLATS_MOST = 1 << 20,
    SPLATS_LEAST = 8192, // unless asked for fewer: a point has several where there are few
    OF_POINT_MOST = 16,  // splats of a point; with fewer points, none begins at one
    PATCH_SIDE = 8,      // squares of validation have a CPU's tile's side
};

// Cameras that spread less than so many box edges stand in a box that reaches to the horizon: how far they spread says
// more of the size of what they look at.
static const double SPREAD_LEAST = 0.32;
static const float ADAM_EPSILON = 1e-8f; // for effects

static enum vw_status specialise(struct vw_model *model) {
    const struct vw_config *config = model->config;
    struct vw_specialization *s = &model->specialization;
    s->samples = s->strata = config->samples; // rays are divided into so many strata, which nothing samples
    s->learning_rate = (float)(VW_SPLAT_RATE_UNIT * config->learning_rate);
    s->gradient_quantum = ADAM_EPSILON * (float)config->rays; // see adam.glsl
    model->ray_group = 1;
    model->patch_side = PATCH_SIDE;
    model->of_renderer = vw_allocate(1, sizeof(struct vw_splat_model));
    return model->of_renderer ? VW_OK : VW_ERROR_MEMORY;
}

// Returns how far from their middle the train cameras stand, in box edges.
static double measure_spread(const struct vw_model *model, const struct vw_scene *scene) {
    double middle[3] = {0.0}, farthest2 = 0.0;
    uint32_t count = 0;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        if (!vw_model_trains_on(model, scene, v)) continue;
        for (int i = 0; i < 3; i++) middle[i] += scene->views[v].camera_to_world[i][3];
        count++;
    }
    for (uint32_t v = 0; v < scene->view_count; v++) {
        double distance2 = 0.0;
        if (!vw_model_trains_on(model, scene, v)) continue;
        for (int i = 0; i < 3; i++) distance2 += pow(scene->views[v].camera_to_world[i][3] - middle[i] / count, 2);
        farthest2 = fmax(farthest2, distance2);
    }
    return sqrt(farthest2) / (2.0 * model->box.half_extent_world);
}

static void lay_out(const struct vw_scene *scene, struct vw_model *model) {
    const struct vw_config *config = model->config;
    struct vw_splat_model *splats = model->of_renderer;
    splats->source_count = config->initial[0] ? 0 : vw_splats_count_points(model, scene);
    splats->count = config->splats                        ? config->splats
                    : splats->source_count > SPLATS_LEAST ? splats->source_count
                                                          : SPLATS_LEAST;
    if (splats->count > SPLATS_MOST) splats->count = SPLATS_MOST;
    if (splats->source_count * (uint64_t)OF_POINT_MOST < splats->count) splats->source_count = 0;
    splats->degree = config->harmonics;
    double spread = measure_spread(model, scene);
    splats->extent = spread > 0.0 ? fmin(spread / SPREAD_LEAST, 1.0) : 1.0;
    uint64_t bytes = vw_splat_param_bytes(&(struct vw_splat_room){.splats = splats->count, .degree = splats->degree});
    model->weights.offset_bytes = vw_round_up(bytes, VW_PARAMS_ALIGNMENT_BYTES);
    uint64_t numbers = 11 + 3 * (splats->degree + 1) * (splats->degree + 1); // mean, opacity, scales, turn; colours
    model->param_count = numbers * splats->count;
}

static enum vw_status fit(const struct vw_device_choices *choices, const struct vw_gpu_limits *limits,
                          struct vw_model *model) {
    (void)choices;
    model->renderer_flags = 1;
    if (model->weights.offset_bytes <= limits->storage_binding_bytes) return VW_OK;
    return vw_fail(VW_ERROR_USAGE, "--splats: %u splats exceed this device's binding range; take fewer",
                   vw_splat_model_of(model)->count);
}

static enum vw_status initialise(const struct vw_model *model, const struct vw_scene *scene,
                                 const struct vw_drawn *drawn, void *params) {
    return vw_splats_start(model, scene, drawn->seed, params);
}

const struct vw_renderer_kind renderer_splats = {
    .depth_along_axis = true,
    .specialise = specialise,
    .lay_out = lay_out,
    .fit = fit,
    .initialise = initialise,
    .step = &vw_splats_renderer_step,
    .evaluation = &vw_splats_renderer_evaluation,
};
