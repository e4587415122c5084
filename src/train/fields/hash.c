// The field of instant-ngp (Mueller et al., SIGGRAPH 2022): a multiresolution hash grid, a density network and a colour
// network, see shaders/field_hash/hash_grid.glsl and shaders/networks/mlp.glsl.
#include <assert.h>
#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "gpu/shaders.h"
#include "train/field.h"
#include "train/fields/mlp.h"
#include "train/fields/registry.h"
#include "train/model.h"
#include "train/passes.h"

enum {
    HEAD_DEPTH = 2,           // layers of the effect transient's head before its last, as wide as the networks
    WALK_SAMPLES_MAX = 32767, // loops take up to twice as many trips, of which some drivers take no more
};

static const float GRID_SCALE = 1e-4f; // the range of initial features

// ---- Layout ---------------------------------------------------------------------------------------------------------

static uint32_t encoding4_of(const struct vw_model *model) {
    return model->specialization.levels * model->specialization.feature_pairs / 2;
}

// Resolutions grow geometrically; a level whose lattice fits the table is dense, and those come first. A window may
// begin at any level.
static void lay_out_levels(struct vw_model *model) {
    const struct vw_config *config = model->config;
    struct vw_volume_model *volume = vw_volume_of(model);
    uint64_t table = UINT64_C(1) << config->log2_table,
             alignment_pairs = VW_PARAMS_ALIGNMENT_BYTES / VW_GRID_PAIR_BYTES;
    for (uint32_t level = 0; level < config->levels; level++) {
        uint64_t resolution = (uint64_t)floor(config->base_resolution * pow(config->growth, level) + 1e-6);
        uint64_t lattice = (resolution + 1) * (resolution + 1) * (resolution + 1);
        bool dense = lattice <= table && model->specialization.dense_levels == level;
        uint64_t entries = dense ? lattice : table;
        model->specialization.dense_levels += dense;
        model->specialization.resolution[level] = (uint32_t)resolution;
        model->specialization.first_pair[level] = volume->pair_count;
        model->param_count += entries * config->features;
        volume->pair_count += (uint32_t)vw_round_up(entries * config->features / 2, alignment_pairs);
    }
}

// Applies decision 3. A sample adds at most (its gradient + 4 for the rounding of eight corners) to an entry, so with
// every contribution clamped to `limit` quanta the sum of all samples stays within the bits, even if all fell into one
// entry. Narrow words are used while they leave 16 bits.
static void choose_fixed_point(uint32_t samples_per_step, struct vw_specialization *specialization) {
    bool narrow = samples_per_step <= 1u << 15;
    double clamp = narrow ? 16.0 : 1024.0; // far above the gradients of a sound training, which are of order 1
    double limit = (narrow ? 0x1p31 : 0x1p62) / samples_per_step - 5.0;
    double quantum = exp2(ceil(log2(clamp / limit)));
    specialization->wide_gradient = !narrow;
    specialization->gradient_quantum = (float)fmax(quantum, 0x1p-34);
    specialization->gradient_clamp = (float)clamp;
}

// Returns the columns of the networks, without the head of the effect transient.
static uint32_t own_columns(const struct vw_model *model) {
    return 4 * VW_WEIGHT_BLOCKS(encoding4_of(model), model->specialization.width4);
}

// Lists that head. It takes in the features of the density network, which are in its first rows. Its weights follow the
// others.
static void list_head(const struct vw_model *model, struct vw_mlp_list *list) {
    const struct vw_mlp_operand features = {0, 4 * GEO4, 0};
    *list = (struct vw_mlp_list){.columns = own_columns(model), .row_count = GEO4, .d_row_count = GEO4};
    vw_mlp_append_head(list, features, HEAD_DEPTH, 4 * model->specialization.width4);
}

static void lay_out_head(struct vw_model *model) {
    struct vw_volume_model *volume = vw_volume_of(model);
    struct vw_specialization *s = &model->specialization;
    struct vw_mlp_list head;
    list_head(model, &head);
    vw_mlp_count(&head, &volume->partial_columns, &model->param_count);
    vw_mlp_specialise_head(&head, s);
    model->weight_columns = head.columns;
    volume->head_row_count = s->layer_rows = head.row_count;
    volume->d_row_count = s->d_layer_rows = head.d_row_count;
}

static void lay_out_weights(struct vw_model *model) {
    struct vw_volume_model *volume = vw_volume_of(model);
    struct vw_specialization *s = &model->specialization;
    uint32_t encoding4 = encoding4_of(model), width4 = s->width4, blocks = VW_WEIGHT_BLOCKS(encoding4, width4);
    model->weight_columns = volume->partial_columns = own_columns(model);
    if (s->effect_transient) lay_out_head(model);
    volume->weight_tiles = VW_WEIGHT_TILES(encoding4, width4);
    volume->row_count = VW_ROW_COUNT(encoding4, width4);
    volume->row_bytes = VW_ROW_BYTES;
    volume->grid_row_count = VW_GRID_ROW_COUNT(encoding4);
    model->param_count += 16 * (uint64_t)blocks - 4 * width4; // the fourth output of the last matrix is padding
    volume->grid = (struct vw_param_range){0, VW_GRID_PAIR_BYTES * (uint64_t)volume->pair_count};
    model->weights = (struct vw_param_range){volume->grid.size_bytes, 16 * (uint64_t)model->weight_columns};
    // Codes shift the weights of the colour network's input 0, which is constant: the third matrix, see mlp.glsl.
    s->shift_column = 4 * width4 * (encoding4 + GEO4);
    s->shift_stride = 4 * COLOUR4;
}

static void lay_out(struct vw_model *model) {
    const struct vw_config *config = model->config;
    struct vw_specialization *s = &model->specialization;
    s->levels = config->levels;
    s->feature_pairs = config->features / 2;
    s->table_mask = (1u << config->log2_table) - 1;
    s->width4 = config->width / 4;
    lay_out_levels(model);
    lay_out_weights(model);
    model->drawn_before_weights = 2 * (uint64_t)vw_volume_of(model)->pair_count;
}

// ---- Device ---------------------------------------------------------------------------------------------------------

// Divides the grid into windows of whole levels, as many as one binding of 64-bit gradient words can contain.
static enum vw_status lay_out_windows(const struct vw_gpu_limits *limits, struct vw_model *model) {
    struct vw_volume_model *volume = vw_volume_of(model);
    uint32_t word_bytes = model->specialization.wide_gradient ? 16 : 8;
    for (uint32_t level = 0; level < model->config->levels; level++) {
        uint32_t first = model->specialization.first_pair[level];
        uint32_t end =
            level + 1 < model->config->levels ? model->specialization.first_pair[level + 1] : volume->pair_count;
        struct vw_grid_window *window = volume->window_count ? &volume->windows[volume->window_count - 1] : NULL;
        if (!window || (uint64_t)(end - window->first_pair) * word_bytes > limits->storage_binding_bytes) {
            window = &volume->windows[volume->window_count++];
            *window = (struct vw_grid_window){.first_level = level, .first_pair = first};
        }
        window->level_count++;
        window->pair_count = end - window->first_pair;
        if ((uint64_t)window->pair_count * word_bytes > limits->storage_binding_bytes)
            return vw_fail(VW_ERROR_USAGE,
                           "--log2-table: one level's gradient of %llu bytes exceeds this device's binding range of "
                           "%llu; lower it",
                           (unsigned long long)window->pair_count * word_bytes,
                           (unsigned long long)limits->storage_binding_bytes);
    }
    return VW_OK;
}

static enum vw_scatter_form choose_scatter(enum vw_scatter_form wanted, const struct vw_gpu_limits *limits,
                                           uint32_t chunk_samples) {
    if (wanted == SCATTER_WALK && limits->int64 && chunk_samples <= WALK_SAMPLES_MAX) return SCATTER_WALK;
    return limits->int64_atomics && wanted != SCATTER_SPLIT_ATOMICS ? SCATTER_ATOMICS : SCATTER_SPLIT_ATOMICS;
}

static enum vw_status fit(const struct vw_device_choices *choices, const struct vw_gpu_limits *limits,
                          struct vw_model *model) {
    struct vw_volume_model *volume = vw_volume_of(model);
    struct vw_specialization *s = &model->specialization;
    uint32_t picture_rays =
        vw_model_pad_rays(model, model->picture_side * model->picture_side); // add to the same entries
    choose_fixed_point((vw_model_pad_rays(model, model->config->rays) + picture_rays) * s->samples, s);
    volume->scatter = choose_scatter(choices->scatter, limits, s->chunk_samples);
    bool grid_too_large = volume->grid.size_bytes > limits->storage_binding_bytes; // for a storage buffer
    s->grid_texel = (choices->grid_texel || grid_too_large) && volume->pair_count <= limits->texel_elements;
    if (!s->grid_texel && grid_too_large)
        return vw_fail(VW_ERROR_USAGE,
                       "--log2-table: a grid of %llu bytes exceeds what this device binds; lower it or --levels",
                       (unsigned long long)volume->grid.size_bytes);
    if (16 * own_columns(model) > limits->shared_memory_bytes)
        return vw_fail(VW_ERROR_USAGE,
                       "--width: the networks' weights take %u bytes of shared memory, the device has %u; lower "
                       "--width or --levels",
                       16 * own_columns(model), limits->shared_memory_bytes);
    return lay_out_windows(limits, model);
}

// ---- Initial values: grid uniform in +-1e-4, weights uniform for unit gain -----------

static void initialise(const struct vw_model *model, const struct vw_drawn *drawn, void *params) {
    uint32_t width4 = model->specialization.width4;
    float *weights = (float *)((char *)params + model->weights.offset_bytes);
    vw_fill_uniform(params, 2 * (uint64_t)vw_volume_of(model)->pair_count, 0, GRID_SCALE, drawn->seed);
    float *next = vw_fill_matrix(weights, drawn, width4, encoding4_of(model));
    next = vw_fill_matrix(next, drawn, GEO4, width4);
    next = vw_fill_matrix(next, drawn, width4, COLOUR4);
    float *last = next;
    next = vw_fill_matrix(next, drawn, 1, width4);
    for (float *value = last + 3; value < next; value += 4) *value = 0.0f; // the unused fourth output
    assert(next - weights == 4 * (ptrdiff_t)own_columns(model));
    if (!model->specialization.effect_transient) return;
    struct vw_mlp_list head;
    list_head(model, &head);
    memset(next, 0, 16 * (size_t)(head.columns - own_columns(model)));
    vw_mlp_initialise(&head, drawn, weights);
}

// ---- Passes ---------------------------------------------------------------------------------------------------------

enum { FEED = HASH_SCATTER + VW_LEVELS_MAX, HEAD }; // passes of the effect transient; HEAD begins those of its layers
enum { HEAD_TILES = (FIELD_PASSES_MAX - HEAD - MLP_MULTIPLY) / 2 };
_Static_assert(HEAD_TILES >= 3, "too few places for passes");

static struct vw_mlp_passes head_of(const struct vw_field_passes *passes) {
    return (struct vw_mlp_passes){(struct vw_pass **)passes->passes + HEAD, HEAD_TILES};
}

static enum vw_status create_scatter(const struct vw_radiance_field *field, const struct vw_field_pass_params *params,
                                     uint32_t index, struct vw_pass **pass) {
    const struct vw_volume_model *volume = vw_volume_of(field->model);
    static const struct vw_shader *const scatter[] = {[SCATTER_ATOMICS] = &vw_shader_scatter_grid,
                                                      [SCATTER_SPLIT_ATOMICS] = &vw_shader_scatter_grid_split,
                                                      [SCATTER_WALK] = &vw_shader_scatter_grid_walk};
    const struct vw_grid_window *window = &volume->windows[index];
    uint64_t word = field->model->specialization.wide_gradient ? 16 : 8;
    struct vw_binding bindings[VW_SLOT_COUNT] = {{.slot = VW_SLOT_D_GRID,
                                                  .buffer = params->d_grid,
                                                  .offset_bytes = word * window->first_pair,
                                                  .size_bytes = word * window->pair_count}};
    memcpy(bindings + 1, params->common.bindings, params->common.binding_count * sizeof *bindings);
    struct vw_pass_params windowed = params->common;
    windowed.bindings = bindings;
    windowed.binding_count++;
    return vw_pass_create_of(params->objects, &windowed, scatter[volume->scatter], pass);
}

static enum vw_status create_head(const struct vw_radiance_field *field, const struct vw_field_pass_params *params,
                                  struct vw_field_passes *passes) {
    struct vw_mlp_list head;
    list_head(field->model, &head);
    enum vw_status status =
        vw_pass_create_of(params->objects, &params->common, &vw_shader_feed_transient_features, &passes->passes[FEED]);
    return !status ? vw_mlp_create_layers(params, &passes->specialization, &head, head_of(passes)) : status;
}

static enum vw_status create_passes(const struct vw_radiance_field *field, const struct vw_field_pass_params *params,
                                    struct vw_field_passes *passes) {
    const struct vw_model *model = field->model;
    bool transient = passes->specialization.effect_transient;
    const struct vw_pass_row rows[] = {
        {&vw_shader_forward_field, &passes->passes[HASH_FORWARD]},
        {transient ? &vw_shader_backward_field_transient : &vw_shader_backward_field, &passes->passes[HASH_BACKWARD]},
        {&vw_shader_gradient_weights, &passes->passes[HASH_GRADIENT]},
        {&vw_shader_reduce_weights, &passes->passes[HASH_REDUCE]},
    };
    enum vw_status status =
        vw_passes_create(params->objects, &params->common, rows, params->backward ? VW_ARRAY_COUNT(rows) : 1);
    for (uint32_t i = 0; i < vw_volume_of(model)->window_count && params->backward && !status; i++)
        status = create_scatter(field, params, i, &passes->passes[HASH_SCATTER + i]);
    return !status && transient ? create_head(field, params, passes) : status;
}

static void record_forward(const struct vw_model *model, const struct vw_field_passes *passes,
                           struct vw_submission *submission, const struct vw_push_samples *rays) {
    uint64_t samples = (uint64_t)rays->ray_count * passes->specialization.samples;
    vw_submission_dispatch(submission, passes->passes[HASH_FORWARD], rays, sizeof *rays, samples);
    if (!passes->specialization.effect_transient) return;
    struct vw_mlp_list head;
    list_head(model, &head);
    vw_submission_dispatch(submission, passes->passes[FEED], NULL, 0, samples);
    vw_mlp_record_layers(&head, head_of(passes), submission, samples);
}

static void record_head_back(const struct vw_model *model, const struct vw_field_passes *passes,
                             struct vw_submission *submission, const struct vw_push_samples *rays) {
    struct vw_mlp_list head;
    list_head(model, &head);
    vw_mlp_record_layers_back(&passes->specialization, &head, head_of(passes), submission, rays);
}

void vw_hash_record_scatter(const struct vw_model *model, const struct vw_field_passes *passes,
                            struct vw_submission *submission, uint32_t samples) {
    const struct vw_volume_model *volume = vw_volume_of(model);
    for (uint32_t i = 0; i < volume->window_count; i++) {
        const struct vw_grid_window *window = &volume->windows[i];
        uint32_t levels = window->level_count;
        struct vw_push_scatter push = {.sample_count = samples,
                                       .first_level = window->first_level,
                                       .level_count = levels,
                                       .first_pair = window->first_pair};
        vw_submission_dispatch(submission, passes->passes[HASH_SCATTER + i], &push, sizeof push,
                               volume->scatter == SCATTER_WALK ? levels : (uint64_t)samples * levels);
    }
}

static void record_backward(const struct vw_model *model, const struct vw_field_passes *passes,
                            struct vw_submission *submission, const struct vw_push_samples *rays) {
    uint32_t samples = rays->ray_count * model->specialization.samples;
    uint64_t tiles = (uint64_t)samples / model->specialization.slice_samples * vw_volume_of(model)->weight_tiles,
             parts = model->specialization.slice_parts;
    if (passes->specialization.effect_transient) record_head_back(model, passes, submission, rays);
    vw_submission_dispatch(submission, passes->passes[HASH_BACKWARD], NULL, 0, samples);
    vw_submission_dispatch(submission, passes->passes[HASH_GRADIENT], rays, sizeof *rays, parts * tiles);
    vw_hash_record_scatter(model, passes, submission, samples); // first, so that it runs beside gradient_weights
    vw_submission_dispatch(submission, passes->passes[HASH_REDUCE], rays, sizeof *rays, own_columns(model));
}

const struct vw_field_kind field_hash = {
    .lay_out = lay_out,
    .fit = fit,
    .initialise = initialise,
    .create_passes = create_passes,
    .record_forward = record_forward,
    .record_backward = record_backward,
};
