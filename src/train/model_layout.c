// The numbers that follow from a model, and the pieces by which fields and effects lay out the params.
#include <assert.h>
#include <math.h>
#include <string.h>

#include "train/effects/effects.h"
#include "train/model.h"
#include "train/renderers/registry.h"

enum { ALIGNMENT_BYTES = 256 }; // the largest offset alignment Vulkan allows a device to ask for

static uint64_t round_up(uint64_t value, uint64_t multiple) { return (value + multiple - 1) / multiple * multiple; }

vw_uint4 vw_model_key_of_step(const struct vw_model *model, uint64_t step) {
    return (vw_uint4){(uint32_t)model->seed, (uint32_t)(model->seed >> 32), (uint32_t)step, (uint32_t)(step >> 32)};
}

double vw_model_decay_at_step(const struct vw_model *model, double decay, uint64_t step) {
    uint64_t last = model->planned_steps;
    if (decay == 1.0 || step <= 1) return 1.0;
    return pow(decay, step < last ? (double)(step - 1) / (double)(last - 1) : 1.0);
}

// Takes logarithms here, since a device's may be worse.
struct vw_adam vw_adam_of(const struct vw_specialization *specialization) {
    const struct vw_specialization *s = specialization;
    return (struct vw_adam){s->learning_rate, s->beta1, s->beta2, log2f(s->beta1), log2f(s->beta2)};
}

double vw_model_rate_factor_of_step(const struct vw_model *model, uint64_t step) {
    return vw_model_decay_at_step(model, model->learning_rate_decay, step);
}

bool vw_model_trains_on(const struct vw_model *model, const struct vw_scene *scene, uint32_t view) {
    if (!model->train_views) return scene->views[view].split == VW_SPLIT_TRAIN;
    for (uint32_t low = 0, high = model->train_count; low < high;) {
        uint32_t middle = (low + high) / 2;
        if (model->train_views[middle] == view) return true;
        if (model->train_views[middle] < view) low = middle + 1;
        else high = middle;
    }
    return false;
}

uint32_t vw_model_pad_rays(const struct vw_model *model, uint32_t rays) {
    return (uint32_t)round_up(rays, model->ray_group);
}

uint32_t vw_model_append_columns(struct vw_model *model, uint32_t columns, uint64_t param_count) {
    uint32_t first = model->moved_columns;
    assert(model->param_bytes == vw_model_columns(model, first, 0).offset_bytes); // update_weights moves all as one
    model->moved_columns += columns;
    model->param_bytes += sizeof(vw_float4) * (uint64_t)columns;
    model->param_count += param_count;
    return first;
}

struct vw_param_range vw_model_columns(const struct vw_model *model, uint32_t first, uint32_t count) {
    return (struct vw_param_range){model->weights.offset_bytes + sizeof(vw_float4) * (uint64_t)first,
                                   sizeof(vw_float4) * (uint64_t)count};
}

void vw_model_append_range(struct vw_model *model, uint32_t slot, uint64_t size_bytes, uint64_t param_count) {
    struct vw_param_range range = {round_up(model->param_bytes, ALIGNMENT_BYTES), size_bytes};
    model->ranges[slot] = range;
    model->param_bytes = range.offset_bytes + size_bytes;
    model->param_count += param_count;
}

enum vw_status vw_model_initialise(const struct vw_model *model, const struct vw_scene *scene, uint64_t seed,
                                   void *params) {
    uint64_t end = model->weights.offset_bytes + model->weights.size_bytes;
    const struct vw_drawn drawn = {(float *)((char *)params + model->weights.offset_bytes), model->drawn_before_weights,
                                   seed};
    memset((char *)params + end, 0, model->param_bytes - end);
    enum vw_status status = model->renderer->initialise(model, scene, &drawn, params);
    if (!status) status = vw_effects_initialise(model, scene, &drawn, params);
    return status;
}
