#include "train/pass_costs.h"

#include <assert.h>
#include <string.h>

#include "train/model.h"

struct vw_cost_sizes vw_cost_sizes_of(const struct vw_model *model, uint32_t rays) {
    const struct vw_specialization *s = &model->specialization;
    uint32_t encoding4 = s->levels * s->feature_pairs / 2;
    return (struct vw_cost_sizes){.samples = (double)rays * s->samples,
                                  .rays = rays,
                                  .encoding4 = encoding4,
                                  .width4 = s->width4,
                                  .gathers = 8.0 * s->levels * s->feature_pairs,
                                  .pairs = model->pair_count};
}

void vw_pass_cost_add(struct vw_pass_costs *costs, struct vw_pass_cost cost) {
    for (uint32_t i = 0; i < costs->count; i++) {
        struct vw_pass_cost *same = &costs->list[i];
        if (same->role != cost.role || strcmp(same->name, cost.name) != 0) continue; // roles are static texts
        same->dispatches += cost.dispatches;
        same->multiply_adds += cost.multiply_adds;
        same->bytes += cost.bytes;
        return;
    }
    assert(costs->count < VW_PASS_COSTS_MAX);
    costs->list[costs->count++] = cost;
}
