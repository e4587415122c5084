#include "train/model.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/random.h"
#include "train/effects/field_box.h"
#include "train/effects/kind.h"
#include "train/effects/registry.h"
#include "train/renderers/registry.h"

_Static_assert((int)LOSS_L1 == VW_LOSS_L1 && (int)LOSS_L2 == VW_LOSS_L2 && (int)LOSS_HUBER == VW_LOSS_HUBER,
               "losses differ");
_Static_assert((int)OPTIMIZER_LAZY_ADAM == VW_OPTIMIZER_LAZY_ADAM &&
                   (int)OPTIMIZER_DENSE_ADAM == VW_OPTIMIZER_DENSE_ADAM && (int)OPTIMIZER_SGD == VW_OPTIMIZER_SGD,
               "optimisers differ");
_Static_assert((int)RANDOM_PIXEL == VW_RANDOM_PIXEL && (int)RANDOM_JITTER == VW_RANDOM_JITTER &&
                   (int)RANDOM_BACKGROUND == VW_RANDOM_BACKGROUND && (int)RANDOM_IMPORTANCE == VW_RANDOM_IMPORTANCE,
               "random purposes differ");

static void specialise(const struct vw_config *config, struct vw_model *model) {
    struct vw_specialization *s = &model->specialization;
    s->training = 1;
    s->loss = config->loss;
    s->huber_length = (float)config->huber_length;
    s->optimizer = config->optimizer;
    s->momentum = config->beta1 > 0.0 && config->optimizer != VW_OPTIMIZER_SGD;
    s->learning_rate = (float)config->learning_rate;
    s->beta1 = (float)config->beta1;
    s->beta2 = (float)config->beta2;
    s->beta_min = (float)config->beta_min;
    s->inverse_rays = (float)(1.0 / config->rays);
}

// Chooses the background. A learned sky replaces it; no other colour may then be the target's.
static void choose_background(const struct vw_config *config, struct vw_specialization *s) {
    bool random = config->background == VW_BACKGROUND_RANDOM && !s->effect_sky;
    if (s->effect_background) s->effect_background = random ? BACKGROUND_RANDOM : BACKGROUND_FIXED;
}

static void list_effects(struct vw_model *model) {
    for (uint32_t i = 0; vw_effect_kinds[i]; i++)
        if (vw_effect_is_on(vw_effect_kinds[i], &model->specialization))
            model->effects[model->effect_count++] = vw_effect_kinds[i];
}

static void lay_out_effect_columns(const struct vw_config *config, bool followed, struct vw_model *model) {
    for (uint32_t i = 0; i < model->effect_count; i++) {
        const struct vw_effect_kind *kind = model->effects[i];
        if (kind->lay_out_columns && (kind->adjoint == VW_ADJOINT_FOLLOWS) == followed)
            kind->lay_out_columns(config, model);
    }
}

// Lays out all params. Columns that lasting credit goes back to come first.
static void lay_out(const struct vw_config *config, const struct vw_scene *scene, uint64_t trained_views,
                    struct vw_model *model) {
    model->renderer->lay_out(config, scene, model);
    model->specialization.field_columns = model->moved_columns = model->weight_columns;
    model->param_bytes = model->weights.offset_bytes + model->weights.size_bytes;
    lay_out_effect_columns(config, true, model);
    model->followed_columns = model->moved_columns;
    if (model->renderer->lay_out_unfollowed) model->renderer->lay_out_unfollowed(model);
    lay_out_effect_columns(config, false, model);
    for (uint32_t i = 0; i < model->effect_count; i++)
        if (model->effects[i]->lay_out_ranges) model->effects[i]->lay_out_ranges(model, trained_views);
}

// Chooses the box. Unbounded space has its own box, also where both effects are asked for.
static enum vw_status choose_box(const struct vw_effect_verdict *verdicts, const struct vw_scene *scene,
                                 const uint32_t *train_views, uint32_t train_count, struct vw_model *model) {
    uint32_t count;
    vw_effects_get(&count);
    bool unbounded = model->specialization.effect_unbounded, wide = vw_effects_is_on(verdicts, count, "wide_box");
    model->box_of_effect = unbounded || wide;
    if (unbounded) return vw_contraction_box(scene, train_views, train_count, &model->box);
    return wide ? vw_wide_box(scene, &model->box) : VW_OK;
}

enum vw_status vw_model_create(const struct vw_config *config, const struct vw_scene *scene,
                               const uint32_t *train_views, uint32_t train_count,
                               const struct vw_effect_verdict *verdicts, const struct vw_device_choices *choices,
                               const struct vw_gpu_limits *limits, struct vw_model *model) {
    uint32_t trained = train_views ? train_count : scene->split_count[VW_SPLIT_TRAIN];
    *model = (struct vw_model){.config = config,
                               .renderer = vw_renderer_kind_of(config->field),
                               .seed = vw_config_seed_of(config, VW_VARY_PIXELS),
                               .view_count = scene->view_count,
                               .train_views = train_views,
                               .train_count = trained,
                               .patch_side = 1,
                               .learning_rate_decay = config->learning_rate_decay,
                               .planned_steps =
                                   (uint64_t)(config->decay_epochs ? config->decay_epochs : config->epochs) * trained};
    struct vw_specialization *s = &model->specialization;
    specialise(config, model);
    if (model->renderer->specialise(config, model)) return VW_ERROR_MEMORY;
    vw_effects_specialise(verdicts, scene, s);
    list_effects(model);
    uint32_t effect_count;
    vw_effects_get(&effect_count);
    model->obeys_masks = vw_effects_obey_masks(scene, verdicts, effect_count);
    model->box = scene->box;
    if (choose_box(verdicts, scene, train_views, train_count, model)) return VW_ERROR_MEMORY;
    choose_background(config, s);
    lay_out(config, scene, trained, model);
    return model->renderer->fit(config, choices, limits, model);
}

void vw_model_destroy(struct vw_model *model) {
    free(model->of_renderer);
    model->of_renderer = NULL;
}

// ---- Layout, and numbers that follow --------------------------------------------------------------------------------

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
