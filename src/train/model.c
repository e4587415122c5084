#include "train/model.h"

#include <assert.h>
#include <string.h>

#include "base/memory.h"
#include "base/random.h"
#include "train/effects/contraction.h"
#include "train/effects/kind.h"
#include "train/effects/registry.h"
#include "train/effects/wide_box.h"
#include "train/fields/registry.h"
#include "train/initial_values.h"

_Static_assert((int)LOSS_L1 == VW_LOSS_L1 && (int)LOSS_L2 == VW_LOSS_L2 && (int)LOSS_HUBER == VW_LOSS_HUBER,
               "losses differ");
_Static_assert((int)OPTIMIZER_LAZY_ADAM == VW_OPTIMIZER_LAZY_ADAM &&
                   (int)OPTIMIZER_DENSE_ADAM == VW_OPTIMIZER_DENSE_ADAM && (int)OPTIMIZER_SGD == VW_OPTIMIZER_SGD,
               "optimisers differ");
_Static_assert((int)RANDOM_JITTER == VW_RANDOM_JITTER && (int)RANDOM_BACKGROUND == VW_RANDOM_BACKGROUND &&
                   (int)RANDOM_OCCUPANCY == VW_RANDOM_OCCUPANCY && (int)RANDOM_IMPORTANCE == VW_RANDOM_IMPORTANCE,
               "random purposes differ");

static const uint64_t ROWS_BYTES_MAX = 1 << 28; // the rows of a chunk: enough samples to fill a large device

static uint32_t greatest_common_divisor(uint32_t a, uint32_t b) { return b ? greatest_common_divisor(b, a % b) : a; }

static void specialise(const struct vw_config *config, struct vw_model *model) {
    struct vw_specialization *s = &model->specialization;
    s->strata = config->samples;
    s->importance = config->importance_samples > 0;
    s->samples = s->importance ? config->importance_samples : s->strata;
    model->ray_samples = s->samples > s->strata ? s->samples : s->strata;
    s->training = s->stores_rows = 1;
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
    model->effect_table = vw_effect_kinds;
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
static void lay_out(const struct vw_config *config, uint64_t trained_views, struct vw_model *model) {
    model->kind->lay_out(config, model);
    model->specialization.field_columns = model->moved_columns = model->weight_columns;
    model->param_bytes = model->weights.offset_bytes + model->weights.size_bytes;
    lay_out_effect_columns(config, true, model);
    model->followed_columns = model->moved_columns;
    if (model->coarse_columns) {
        model->coarse_column = vw_model_append_columns(model, model->coarse_columns, 0); // the field counts its params
        model->coarse = vw_model_columns(model, model->coarse_column, model->coarse_columns);
    }
    lay_out_effect_columns(config, false, model);
    for (uint32_t i = 0; i < model->effect_count; i++)
        if (model->effects[i]->lay_out_ranges) model->effects[i]->lay_out_ranges(model, trained_views);
}

// Chooses whole groups of rays whose rows fit into one binding, and no more than a step has.
static enum vw_status choose_chunk(const struct vw_config *config, const struct vw_device_choices *choices,
                                   const struct vw_gpu_limits *limits, struct vw_model *model) {
    uint32_t samples = model->ray_samples, chunk = choices->chunk_samples, group_samples = model->ray_group * samples,
             step_samples = vw_model_pad_rays(model, config->rays) * samples;
    uint64_t row_bytes = (uint64_t)model->row_bytes * model->row_count,
             layer_row_bytes = (uint64_t)VW_LAYER_ROW_BYTES * model->head_row_count,
             bytes = VW_ROWS_SIZE(row_bytes > layer_row_bytes ? row_bytes : layer_row_bytes, VW_FIELD_GROUP),
             most = limits->storage_binding_bytes < ROWS_BYTES_MAX ? limits->storage_binding_bytes : ROWS_BYTES_MAX;
    assert(group_samples > 0); // the configuration has samples
    if (bytes * (group_samples / VW_FIELD_GROUP) > limits->storage_binding_bytes)
        return vw_fail(
            VW_ERROR_USAGE,
            "--samples: %u per ray make groups of %u samples, too many for this device; take a multiple of 16", samples,
            group_samples);
    uint64_t fits = VW_FIELD_GROUP * (most / bytes);
    if (chunk > fits) chunk = (uint32_t)fits;
    if (chunk > step_samples) chunk = step_samples;
    model->specialization.chunk_samples = chunk < group_samples ? group_samples : chunk / group_samples * group_samples;
    return VW_OK;
}

static void specialise_for_device(const struct vw_device_choices *choices, const struct vw_gpu_limits *limits,
                                  struct vw_model *model) {
    struct vw_specialization *s = &model->specialization;
    s->skip_zeros = choices->skip_zeros;
    s->slice_samples = choices->slice_samples;
    uint64_t rows = model->row_count > model->head_row_count ? model->row_count : model->head_row_count;
    s->rows_texel = choices->rows_texel && VW_ROWS_SIZE(rows, s->chunk_samples) <= limits->texel_elements;
}

// Chooses the box. Unbounded space has its own box, also where both effects are asked for.
static enum vw_status choose_box(const struct vw_effect_verdict *verdicts, const struct vw_scene *scene,
                                 const uint32_t *train_views, uint32_t train_count, struct vw_model *model) {
    uint32_t count;
    vw_effects_get(&count);
    bool unbounded = model->specialization.effect_unbounded, wide = vw_effects_is_on(verdicts, count, "wide_box");
    model->box_of_effect = unbounded || wide;
    if (unbounded) return vw_contraction_box(scene, train_views, train_count, &model->box);
    return wide ? wide_box(scene, &model->box) : VW_OK;
}

enum vw_status vw_model_create(const struct vw_config *config, const struct vw_scene *scene,
                               const uint32_t *train_views, uint32_t train_count,
                               const struct vw_effect_verdict *verdicts, const struct vw_device_choices *choices,
                               const struct vw_gpu_limits *limits, struct vw_model *model) {
    uint32_t trained = train_views ? train_count : scene->split_count[VW_SPLIT_TRAIN];
    *model = (struct vw_model){.kind = vw_field_kind_of(config->field),
                               .seed = vw_config_seed_of(config, VW_VARY_PIXELS),
                               .view_count = scene->view_count,
                               .learning_rate_decay = config->learning_rate_decay,
                               .planned_steps = (uint64_t)config->epochs * trained};
    struct vw_specialization *s = &model->specialization;
    specialise(config, model);
    vw_effects_specialise(verdicts, scene, s);
    list_effects(model);
    uint32_t effect_count;
    vw_effects_get(&effect_count);
    model->obeys_masks = vw_effects_obey_masks(scene, verdicts, effect_count);
    assert(!s->effect_occupancy || (model->kind->skips_samples && !s->effect_transient)); // vw_effects_follow_field
    model->box = scene->box;
    if (choose_box(verdicts, scene, train_views, train_count, model)) return VW_ERROR_MEMORY;
    choose_background(config, s);
    lay_out(config, trained, model);
    uint32_t both = greatest_common_divisor(s->samples, s->strata); // the even samples fill whole workgroups, too
    model->ray_group = VW_FIELD_GROUP / greatest_common_divisor(VW_FIELD_GROUP, both);
    enum vw_status status = choose_chunk(config, choices, limits, model);
    if (status) return status;
    specialise_for_device(choices, limits, model);
    return model->kind->fit(config, choices, limits, model);
}
