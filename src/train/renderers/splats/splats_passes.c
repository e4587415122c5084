// Params of the passes of splats that a step and an evaluator share.
#include "train/model.h"
#include "train/renderers/splats/splats.h"

struct vw_splat_pass_params vw_splats_pass_params(const struct vw_radiance_field *field,
                                                  const struct vw_specialization *run,
                                                  struct vw_splat_specialization *specialization) {
    const struct vw_splat_model *splats = vw_splat_model_of(field->model);
    *specialization = vw_splat_specialise(run, vw_gpu_get_info(field->gpu)->kind == VW_GPU_CPU);
    specialization->ssim_weight = (float)field->model->config->ssim_weight;
    return (struct vw_splat_pass_params){.gpu = field->gpu,
                                         .specialization = specialization,
                                         .room = {.splats = splats->count, .degree = splats->degree}};
}

uint32_t vw_splats_pair_room(const struct vw_radiance_field *field, const struct vw_splat_room *room) {
    enum { PAIRS_PER_TILE = 2048, PAIRS_PER_SIGHTING = 4, PAIRS_MOST = 1 << 22 };
    uint64_t sightings = (uint64_t)room->splats * room->views;
    uint64_t pairs = (uint64_t)room->tiles * PAIRS_PER_TILE, every = (uint64_t)room->tiles * room->splats;
    if (pairs < sightings * PAIRS_PER_SIGHTING) pairs = sightings * PAIRS_PER_SIGHTING;
    if (pairs > every) pairs = every;
    uint64_t fit = vw_gpu_get_limits(field->gpu)->storage_binding_bytes / (sizeof(vw_float4) * VW_SPLAT_PAIR4);
    if (pairs > fit) pairs = fit;
    return (uint32_t)(pairs < PAIRS_MOST ? pairs : PAIRS_MOST);
}

struct vw_binding vw_splats_binding(const struct vw_radiance_field *field) {
    const struct vw_splat_model *splats = vw_splat_model_of(field->model);
    const struct vw_splat_room room = {.splats = splats->count, .degree = splats->degree};
    return (struct vw_binding){
        .slot = VW_SLOT_SPLATS, .buffer = field->params, .size_bytes = vw_splat_param_bytes(&room)};
}

struct vw_push_splats vw_splats_push(const struct vw_model *model) {
    const struct vw_splat_model *splats = vw_splat_model_of(model);
    return (struct vw_push_splats){
        .count = splats->count, .stride = splats->count, .degree = splats->degree, .view_count = 1};
}
