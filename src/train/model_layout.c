#include <assert.h>
#include <math.h>

#include "base/random.h"
#include "train/effects/kind.h"
#include "train/model.h"

vw_uint4 vw_model_key_of_step(const struct vw_model *model, uint64_t step) {
    return (vw_uint4){(uint32_t)model->seed, (uint32_t)(model->seed >> 32), (uint32_t)step, (uint32_t)(step >> 32)};
}

// Takes logarithms here, since a device's may be worse.
struct vw_adam vw_adam_of(const struct vw_specialization *specialization) {
    const struct vw_specialization *s = specialization;
    return (struct vw_adam){s->learning_rate, s->beta1, s->beta2, log2f(s->beta1), log2f(s->beta2)};
}

double vw_model_rate_factor_of_step(const struct vw_model *model, uint64_t step) {
    uint64_t last = model->planned_steps;
    if (model->learning_rate_decay == 1.0 || step <= 1) return 1.0;
    return pow(model->learning_rate_decay, step < last ? (double)(step - 1) / (double)(last - 1) : 1.0);
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
    return (uint32_t)vw_round_up(rays, model->ray_group);
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
    struct vw_param_range range = {vw_round_up(model->param_bytes, VW_PARAMS_ALIGNMENT_BYTES), size_bytes};
    model->ranges[slot] = range;
    model->param_bytes = range.offset_bytes + size_bytes;
    model->param_count += param_count;
}

// ---- Initial values -------------------------------------------------------------------------------------------------

void vw_fill_uniform(float *values, uint64_t count, uint64_t first_index, float scale, uint64_t seed) {
    for (uint64_t i = 0; i < count; i += 4) {
        uint32_t words[4];
        vw_random_words(seed, VW_RANDOM_INITIALISATION, 0, (uint32_t)((first_index + i) / 4), 0, words);
        for (uint64_t j = 0; j < 4 && i + j < count; j++)
            values[i + j] = scale * (2.0f * vw_random_unit(words[j]) - 1.0f);
    }
}

float *vw_fill_weights(float *values, const struct vw_drawn *drawn, uint64_t count, float scale) {
    vw_fill_uniform(values, count, drawn->first_index + (uint64_t)(values - drawn->weights), scale, drawn->seed);
    return values + count;
}

float *vw_fill_matrix(float *values, const struct vw_drawn *drawn, uint32_t out4, uint32_t in4) {
    return vw_fill_weights(values, drawn, 16 * (uint64_t)out4 * in4, sqrtf(6.0f / (4.0f * (float)in4)));
}

bool vw_model_has_ray_effects(const struct vw_model *model, const struct vw_specialization *specialization) {
    bool found = false;
    for (uint32_t i = 0; i < model->effect_count; i++) {
        const struct vw_effect_kind *kind = model->effects[i];
        found |= kind->binds_ray_buffers && vw_effect_is_on(kind, specialization) &&
                 (!kind->updates || kind->updates(model));
    }
    return found;
}
