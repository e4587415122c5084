#include "train/model.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "base/random.h"
#include "train/effects/contraction.h"
#include "train/effects/kind.h"
#include "train/effects/registry.h"
#include "train/effects/wide_box.h"
#include "train/fields/initial_values.h"
#include "train/fields/registry.h"

_Static_assert((int)LOSS_L1 == VW_LOSS_L1 && (int)LOSS_L2 == VW_LOSS_L2 && (int)LOSS_HUBER == VW_LOSS_HUBER,
               "losses differ");
_Static_assert((int)OPTIMIZER_LAZY_ADAM == VW_OPTIMIZER_LAZY_ADAM &&
                   (int)OPTIMIZER_DENSE_ADAM == VW_OPTIMIZER_DENSE_ADAM && (int)OPTIMIZER_SGD == VW_OPTIMIZER_SGD,
               "optimisers differ");
_Static_assert((int)RANDOM_JITTER == VW_RANDOM_JITTER && (int)RANDOM_BACKGROUND == VW_RANDOM_BACKGROUND &&
                   (int)RANDOM_OCCUPANCY == VW_RANDOM_OCCUPANCY && (int)RANDOM_IMPORTANCE == VW_RANDOM_IMPORTANCE,
               "random purposes differ");

enum {
    ALIGNMENT_BYTES = 256, // the largest offset alignment Vulkan allows a device to ask for
};
static const uint64_t ROWS_BYTES_MAX = 1 << 28; // the rows of a chunk: enough samples to fill a large device

static uint64_t round_up(uint64_t value, uint64_t multiple) { return (value + multiple - 1) / multiple * multiple; }

static uint32_t greatest_common_divisor(uint32_t a, uint32_t b) { return b ? greatest_common_divisor(b, a % b) : a; }

vw_uint4 vw_model_key_of_step(const struct vw_model *model, uint64_t step) {
    return (vw_uint4){(uint32_t)model->seed, (uint32_t)(model->seed >> 32), (uint32_t)step, (uint32_t)(step >> 32)};
}

double vw_model_rate_of_step(const struct vw_model *model, uint64_t step) {
    uint64_t last = model->planned_steps;
    if (model->learning_rate_decay == 1.0 || step <= 1) return 1.0;
    return pow(model->learning_rate_decay, step < last ? (double)(step - 1) / (double)(last - 1) : 1.0);
}

uint32_t vw_model_pad_rays(const struct vw_model *model, uint32_t rays) {
    return (uint32_t)round_up(rays, model->ray_group);
}

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

// Columns that lasting credit goes back to come first.
static void lay_out(const struct vw_config *config, uint64_t trained_views, struct vw_model *model) {
    model->kind->lay_out(config, model);
    model->specialization.field_columns = model->moved_columns = model->weight_columns;
    model->param_bytes = model->weights.offset_bytes + model->weights.size_bytes;
    vw_effects_lay_out_columns(config, true, &model->specialization, model);
    model->followed_columns = model->moved_columns;
    if (model->coarse_columns) {
        model->coarse_column = vw_model_append_columns(model, model->coarse_columns, 0); // the field counts its params
        model->coarse = vw_model_columns(model, model->coarse_column, model->coarse_columns);
    }
    vw_effects_lay_out_columns(config, false, &model->specialization, model);
    vw_effects_lay_out_ranges(trained_views, &model->specialization, model);
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
    vw_effects_specialize(verdicts, scene, s);
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

void vw_model_initialise(const struct vw_model *model, uint64_t seed, void *params) {
    uint64_t end = model->weights.offset_bytes + model->weights.size_bytes;
    const struct vw_drawn drawn = {(float *)((char *)params + model->weights.offset_bytes), model->drawn_before_weights,
                                   seed};
    memset((char *)params + end, 0, model->param_bytes - end);
    model->kind->initialise(model, &drawn, params);
    vw_effects_initialise(model, &model->specialization, &drawn, params);
}
