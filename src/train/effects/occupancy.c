// The effect `occupancy`: training leaves out samples in empty cells of the box
// (shaders/effects/occupancy/occupancy.glsl); validation never does. The kept samples of a chunk move together, by a
// prefix sum, so that the passes over them are shorter:
//   mark_samples: bits and counts per ray -> place_rays: where rays begin, how many workgroups -> list_samples: slot to
//   sample
// Every OCCUPANCY_STEPS steps the field is sampled to find what is empty; the result (VW_SLOT_OCCUPANCY) is part of the
// training's state.
#include <string.h>

#include "base/memory.h"
#include "gpu/shaders.h"
#include "train/effects/kind.h"
#include "train/model.h"
#include "train/pass_costs.h"
#include "train/step_passes.h"

enum { REFRESH, MARK, PLACE, LIST };
enum { OCCUPANCY_STEPS = 16 };

// The share of a cell's density that remains at each refresh. Short runs begin with fog everywhere, which at 0.95
// (instant-ngp's) would take 1,000 steps to be forgotten; a surface of density 30 is still believed after 20 refreshes
// that miss it.
static const float REMAINS = 0.8f;

_Static_assert(VW_OCCUPANCY_CELLS == VW_OCCUPANCY_SIDE * VW_OCCUPANCY_SIDE * VW_OCCUPANCY_SIDE, "cells fill a cube");
_Static_assert(VW_OCCUPANCY_CELLS % VW_FIELD_GROUP == 0, "cells fill workgroups");

static uint32_t list_buffers(const struct vw_model *model, uint32_t padded_rays, struct vw_effect_buffer *buffers) {
    (void)padded_rays;
    const struct vw_specialization *s = &model->specialization;
    uint64_t rays = s->chunk_samples / s->samples; // the rays of a chunk
    const struct vw_effect_buffer listed[] = {
        {VW_SLOT_OCCUPANCY, "occupancy", sizeof(float) * VW_OCCUPANCY_CELLS, VW_EFFECT_CARRIED | VW_EFFECT_OF_FIELD},
        {VW_SLOT_KEPT_BITS, "kept_bits", 4 * rays * VW_KEPT_WORDS(s->samples), VW_EFFECT_OF_STEP},
        {VW_SLOT_KEPT_BEGINS, "kept_begins", 4 * (rays + 1), VW_EFFECT_OF_STEP},
        {VW_SLOT_KEPT_SAMPLES, "kept_samples", 4 * (uint64_t)s->chunk_samples, VW_EFFECT_OF_STEP},
        {VW_SLOT_KEPT, "kept", sizeof(struct vw_kept), VW_EFFECT_OF_STEP},
    };
    memcpy(buffers, listed, sizeof listed);
    return VW_ARRAY_COUNT(listed);
}

static void record_begin(struct vw_pass *const *passes, struct vw_submission *submission, uint64_t number,
                         vw_uint4 key) {
    if (number % OCCUPANCY_STEPS) return;
    struct vw_push_refresh push = {.key = key, .remains = REMAINS};
    vw_submission_dispatch(submission, passes[REFRESH], &push, sizeof push, VW_OCCUPANCY_CELLS);
}

static void record_chunk(struct vw_pass *const *passes, struct vw_submission *submission,
                         const struct vw_push_samples *chunk) {
    vw_submission_dispatch(submission, passes[MARK], chunk, sizeof *chunk, chunk->ray_count);
    vw_submission_dispatch(submission, passes[PLACE], chunk, sizeof *chunk, 1);
    vw_submission_dispatch(submission, passes[LIST], chunk, sizeof *chunk, chunk->ray_count);
}

static void list_costs(const struct vw_effect_work *work, struct vw_pass_costs *costs) {
    const struct vw_cost_sizes n = vw_cost_sizes_of(work->model, work->rays);
    const double refreshes = 1.0 / OCCUPANCY_STEPS, cells = refreshes * VW_OCCUPANCY_CELLS;
    const struct vw_pass_cost passes[] = {
        {"mark_samples", NULL, work->chunks, 0, n.rays * sizeof(struct vw_ray) + 4 * n.samples},
        {"place_rays", NULL, work->chunks, 0, 12 * n.rays},
        {"list_samples", NULL, work->chunks, 0, 4 * n.rays + 4 * n.samples},
        {"refresh_occupancy", NULL, refreshes, cells * (16 * n.width4 * (n.encoding4 + 1) + 2 * n.gathers),
         cells * (n.pair_bytes * n.gathers + 8)},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(passes) - (work->of_picture ? 1 : 0); i++) vw_pass_cost_add(costs, passes[i]);
}

const struct vw_effect_kind vw_effect_occupancy = {
    .name = "occupancy",
    .constant = VW_EFFECT_CONSTANT(occupancy),
    .adjoint = VW_ADJOINT_FOLLOWS,
    .training_alone = true, // decision 1: validation skips nothing
    .shaders = {[REFRESH] = {&vw_shader_refresh_occupancy, &vw_shader_refresh_occupancy_half},
                [MARK] = {&vw_shader_mark_samples},
                [PLACE] = {&vw_shader_place_rays},
                [LIST] = {&vw_shader_list_samples}},
    .list_buffers = list_buffers,
    .record_begin = record_begin,
    .record_chunk = record_chunk,
    .list_costs = list_costs,
};
