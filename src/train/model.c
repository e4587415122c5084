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

static void specialise(struct vw_model *model) {
    const struct vw_config *config = model->config;
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
static void choose_background(struct vw_model *model) {
    struct vw_specialization *s = &model->specialization;
    bool random = model->config->background == VW_BACKGROUND_RANDOM && !s->effect_sky;
    if (s->effect_background) s->effect_background = random ? BACKGROUND_RANDOM : BACKGROUND_FIXED;
}

static void list_effects(struct vw_model *model) {
    for (uint32_t i = 0; vw_effect_kinds[i]; i++)
        if (vw_effect_is_on(vw_effect_kinds[i], &model->specialization))
            model->effects[model->effect_count++] = vw_effect_kinds[i];
}

static void lay_out_effect_columns(bool followed, struct vw_model *model) {
    for (uint32_t i = 0; i < model->effect_count; i++) {
        const struct vw_effect_kind *kind = model->effects[i];
        if (kind->lay_out_columns && (kind->adjoint == VW_ADJOINT_FOLLOWS) == followed) kind->lay_out_columns(model);
    }
}

// Lays out all params. Columns that lasting credit goes back to come first.
static void lay_out(const struct vw_scene *scene, uint64_t trained_views, struct vw_model *model) {
    model->renderer->lay_out(scene, model);
    model->specialization.field_columns = model->moved_columns = model->weight_columns;
    model->param_bytes = model->weights.offset_bytes + model->weights.size_bytes;
    lay_out_effect_columns(true, model);
    model->followed_columns = model->moved_columns;
    if (model->renderer->lay_out_unfollowed) model->renderer->lay_out_unfollowed(model);
    lay_out_effect_columns(false, model);
    for (uint32_t i = 0; i < model->effect_count; i++)
        if (model->effects[i]->lay_out_ranges) model->effects[i]->lay_out_ranges(model, trained_views);
}

// Chooses the box. Unbounded space has its own box, also where both effects are asked for.
static enum vw_status choose_box(const struct vw_effect_decision *decisions, const struct vw_scene *scene,
                                 const uint32_t *train_views, uint32_t train_count, struct vw_model *model) {
    uint32_t count;
    vw_effects_get(&count);
    bool unbounded = model->specialization.effect_unbounded, wide = vw_effects_is_on(decisions, count, "wide_box");
    model->box_of_effect = unbounded || wide;
    if (unbounded) return vw_contraction_box(scene, train_views, train_count, &model->box);
    return wide ? vw_wide_box(scene, &model->box) : VW_OK;
}

enum vw_status vw_model_create(const struct vw_config *config, const struct vw_scene *scene,
                               const uint32_t *train_views, uint32_t train_count,
                               const struct vw_effect_decision *decisions, const struct vw_device_choices *choices,
                               const struct vw_gpu_limits *limits, struct vw_model *model) {
    uint32_t trained = train_views ? train_count : scene->split_count[VW_SPLIT_TRAIN];
    *model = (struct vw_model){.config = config,
                               .renderer = vw_renderer_kind_of(config->field),
                               .effect_table = vw_effect_kinds,
                               .seed = vw_config_seed_of(config, VW_VARY_PIXELS),
                               .view_count = scene->view_count,
                               .train_views = train_views,
                               .train_count = trained,
                               .patch_side = 1,
                               .learning_rate_decay = config->learning_rate_decay,
                               .planned_steps =
                                   (uint64_t)(config->decay_epochs ? config->decay_epochs : config->epochs) * trained};
    struct vw_specialization *s = &model->specialization;
    specialise(model);
    if (model->renderer->specialise(model)) return VW_ERROR_MEMORY;
    vw_effects_specialise(decisions, scene, s);
    list_effects(model);
    uint32_t effect_count;
    vw_effects_get(&effect_count);
    model->obeys_masks = vw_effects_obey_masks(scene, decisions, effect_count);
    model->box = scene->box;
    if (choose_box(decisions, scene, train_views, train_count, model)) return VW_ERROR_MEMORY;
    choose_background(model);
    lay_out(scene, trained, model);
    return model->renderer->fit(choices, limits, model);
}

void vw_model_destroy(struct vw_model *model) {
    free(model->of_renderer);
    model->of_renderer = NULL;
}
