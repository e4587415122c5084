#include "train/model.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "train/effects/contraction.h"
#include "train/effects/registry.h"
#include "train/half.h"
#include "base/memory.h"
#include "base/random.h"

_Static_assert((int)LOSS_L1 == VW_LOSS_L1 && (int)LOSS_L2 == VW_LOSS_L2 && (int)LOSS_HUBER == VW_LOSS_HUBER,
               "losses differ");
_Static_assert((int)OPTIMIZER_LAZY_ADAM == VW_OPTIMIZER_LAZY_ADAM &&
                   (int)OPTIMIZER_DENSE_ADAM == VW_OPTIMIZER_DENSE_ADAM && (int)OPTIMIZER_SGD == VW_OPTIMIZER_SGD,
               "optimisers differ");
_Static_assert((int)RANDOM_JITTER == VW_RANDOM_JITTER && (int)RANDOM_BACKGROUND == VW_RANDOM_BACKGROUND &&
                   (int)RANDOM_OCCUPANCY == VW_RANDOM_OCCUPANCY,
               "random purposes differ");

enum {
    ALIGNMENT_BYTES = 256, // the largest offset alignment Vulkan allows a device to ask for
    FLOAT_PAIR_BYTES = 8,  // of a feature pair
    HALF_PAIR_BYTES = 4,
    WALK_SAMPLES_MAX = 32767, // loops take up to twice as many trips, of which some drivers take no more
};

static const float GRID_SCALE = 1e-4f; // of initial features

static uint64_t round_up(uint64_t value, uint64_t multiple) { return (value + multiple - 1) / multiple * multiple; }

static uint32_t greatest_common_divisor(uint32_t a, uint32_t b) { return b ? greatest_common_divisor(b, a % b) : a; }

vw_uint4 model_key_of_step(const struct model *model, uint64_t step) {
    return (vw_uint4){(uint32_t)model->seed, (uint32_t)(model->seed >> 32), (uint32_t)step, (uint32_t)(step >> 32)};
}

uint32_t model_pad_rays(const struct model *model, uint32_t rays) { return (uint32_t)round_up(rays, model->ray_group); }

// Resolutions grow geometrically; a level whose lattice fits the table is dense, and those come first. A window may
// begin at any level.
static void lay_out_levels(const struct vw_config *config, struct model *model) {
    uint64_t table = UINT64_C(1) << config->log2_table, alignment_pairs = ALIGNMENT_BYTES / model->pair_bytes;
    for (uint32_t level = 0; level < config->levels; level++) {
        uint64_t resolution = (uint64_t)floor(config->base_resolution * pow(config->growth, level) + 1e-6);
        uint64_t lattice = (resolution + 1) * (resolution + 1) * (resolution + 1);
        bool dense = lattice <= table && model->specialization.dense_levels == level;
        uint64_t entries = dense ? lattice : table;
        model->specialization.dense_levels += dense;
        model->specialization.resolution[level] = (uint32_t)resolution;
        model->specialization.first_pair[level] = model->pair_count;
        model->param_count += entries * config->features;
        model->pair_count += (uint32_t)round_up(entries * config->features / 2, alignment_pairs);
        model->drawn_pair[level + 1] =
            model->drawn_pair[level] +
            (uint32_t)round_up(entries * config->features / 2, ALIGNMENT_BYTES / FLOAT_PAIR_BYTES);
    }
}

// Whole levels, as many as one binding of 64-bit gradient words holds.
static enum vw_status lay_out_windows(const struct vw_config *config, const struct vw_gpu_limits *limits,
                                      struct model *model) {
    uint32_t word_bytes = model->specialization.wide_gradient ? 16 : 8;
    for (uint32_t level = 0; level < config->levels; level++) {
        uint32_t first = model->specialization.first_pair[level];
        uint32_t end = level + 1 < config->levels ? model->specialization.first_pair[level + 1] : model->pair_count;
        struct grid_window *window = model->window_count ? &model->windows[model->window_count - 1] : NULL;
        if (!window || (uint64_t)(end - window->first_pair) * word_bytes > limits->storage_binding_bytes) {
            window = &model->windows[model->window_count++];
            *window = (struct grid_window){.first_level = level, .first_pair = first};
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

// Decision 3. A sample adds at most (its gradient + 4 for the rounding of eight corners) to an entry, so with every
// contribution clamped to `limit` quanta the sum of all samples stays within the bits, even if all fell into one entry.
// Narrow words are used while they leave 16 bits.
static void choose_fixed_point(uint32_t samples_per_step, struct vw_specialization *specialization) {
    bool narrow = samples_per_step <= 1u << 15;
    double clamp = narrow ? 16.0 : 1024.0; // far above the gradients of a sound training, which are of order 1
    double limit = (narrow ? 0x1p31 : 0x1p62) / samples_per_step - 5.0;
    double quantum = exp2(ceil(log2(clamp / limit)));
    specialization->wide_gradient = !narrow;
    specialization->gradient_quantum = (float)fmax(quantum, 0x1p-34);
    specialization->gradient_clamp = (float)clamp;
}

static enum scatter_form choose_scatter(enum scatter_form wanted, const struct vw_gpu_limits *limits,
                                        uint32_t chunk_samples) {
    if (wanted == SCATTER_WALK && limits->int64 && chunk_samples <= WALK_SAMPLES_MAX) return SCATTER_WALK;
    return limits->int64_atomics && wanted != SCATTER_SPLIT_ATOMICS ? SCATTER_ATOMICS : SCATTER_SPLIT_ATOMICS;
}

static void specialise(const struct vw_config *config, struct model *model) {
    struct vw_specialization *s = &model->specialization;
    s->samples = config->samples;
    s->levels = config->levels;
    s->feature_pairs = config->features / 2;
    s->table_mask = (1u << config->log2_table) - 1;
    s->width4 = config->width / 4;
    s->training = s->stores_rows = 1;
    s->loss = config->loss;
    s->huber_length = (float)config->huber_length;
    s->optimizer = config->optimizer;
    s->momentum = config->beta1 > 0.0 && config->optimizer != VW_OPTIMIZER_SGD;
    s->learning_rate = (float)config->learning_rate;
    s->beta1 = (float)config->beta1;
    s->beta2 = (float)config->beta2;
    s->inverse_rays = (float)(1.0 / config->rays);
}

// A learned sky stands behind the field in the background's place, before which no other colour may be the target's.
static void choose_background(const struct vw_config *config, struct vw_specialization *s) {
    bool random = config->background == VW_BACKGROUND_RANDOM && !s->effect_sky;
    if (s->effect_background) s->effect_background = random ? BACKGROUND_RANDOM : BACKGROUND_FIXED;
}

static void lay_out_weights(struct model *model) {
    uint32_t encoding4 = model->specialization.levels * model->specialization.feature_pairs / 2;
    uint32_t width4 = model->specialization.width4;
    uint32_t blocks = VW_WEIGHT_BLOCKS(encoding4, width4);
    model->weight_columns = 4 * blocks;
    model->weight_tiles = VW_WEIGHT_TILES(encoding4, width4);
    model->row_count = VW_ROW_COUNT(encoding4, width4);
    model->grid_row_count = VW_GRID_ROW_COUNT(encoding4);
    model->param_count += 16 * (uint64_t)blocks - 4 * width4; // the fourth output of the last matrix is padding
    model->grid = (struct param_range){"grid", 0, model->pair_bytes * (uint64_t)model->pair_count};
    model->weights = (struct param_range){"weights", model->grid.size_bytes, 16 * (uint64_t)model->weight_columns};
    model->moved_columns = model->weight_columns;
    model->param_bytes = model->weights.offset_bytes + model->weights.size_bytes;
}

static void lay_out_sky(struct model *model) {
    uint32_t columns = model->specialization.effect_sky ? VW_SKY_COLUMNS : 0;
    assert(model->param_bytes ==
           model->weights.offset_bytes + model->weights.size_bytes); // update_weights moves both as one
    model->param_count += 3 * (uint64_t)columns;                     // the fourth number is padding
    model->sky = (struct param_range){"sky", model->param_bytes, 16 * (uint64_t)columns};
    model->moved_columns += columns;
    model->param_bytes += model->sky.size_bytes;
}

// Behind all that is laid out already.
static struct param_range append_range(struct model *model, const char *name, uint64_t size_bytes) {
    struct param_range range = {name, round_up(model->param_bytes, ALIGNMENT_BYTES), size_bytes};
    model->param_bytes = range.offset_bytes + size_bytes;
    return range;
}

static void lay_out_photos(const struct vw_scene *scene, uint64_t trained, struct model *model) {
    const struct vw_specialization *s = &model->specialization;
    uint64_t views = scene->view_count, code = 4 * CODE4, width = 4 * s->width4;
    if (s->effect_appearance) {
        model->appearance = append_range(model, "appearance", sizeof(struct vw_appearance) * views);
        model->param_count += 6 * trained;
    }
    if (s->effect_appearance_code) {
        model->code_weights = append_range(model, "code_weights", 4 * code * width);
        model->codes = append_range(model, "codes", 4 * code * views);
        model->param_count += code * (width + trained);
    }
}

enum vw_status model_create(const struct vw_config *config, const struct vw_scene *scene, const uint32_t *train_views,
                            uint32_t train_count, const struct vw_effect_verdict *verdicts,
                            const struct device_choices *choices, const struct vw_gpu_limits *limits,
                            struct model *model) {
    *model = (struct model){.half_grid = config->table_precision == VW_TABLE_FLOAT16,
                            .seed = vw_config_seed_of(config, VW_VARY_PIXELS)};
    model->pair_bytes = model->half_grid ? HALF_PAIR_BYTES : FLOAT_PAIR_BYTES;
    struct vw_specialization *s = &model->specialization;
    specialise(config, model);
    effects_specialize(verdicts, scene, s);
    model->box = scene->box;
    if (s->effect_unbounded && contraction_box(scene, train_views, train_count, &model->box)) return VW_ERROR_MEMORY;
    lay_out_levels(config, model);
    choose_background(config, s);
    lay_out_weights(model);
    lay_out_sky(model);
    lay_out_photos(scene, train_views ? train_count : scene->split_count[VW_SPLIT_TRAIN], model);
    model->ray_group = VW_FIELD_GROUP / greatest_common_divisor(VW_FIELD_GROUP, config->samples);
    choose_fixed_point(model_pad_rays(model, config->rays) * config->samples, s);

    uint32_t chunk = choices->chunk_samples;
    uint32_t group_samples = model->ray_group * config->samples,
             step_samples = model_pad_rays(model, config->rays) * config->samples;
    if (VW_ROW_BYTES * VW_ROWS_SIZE((uint64_t)model->row_count, group_samples) > limits->storage_binding_bytes)
        return vw_fail(
            VW_ERROR_USAGE,
            "--samples: %u per ray make groups of %u samples, too many for this device; take a multiple of 16",
            config->samples, group_samples);
    uint64_t fits = VW_FIELD_GROUP *
                    (limits->storage_binding_bytes / (VW_ROW_BYTES * VW_ROWS_SIZE(model->row_count, VW_FIELD_GROUP)));
    if (chunk > fits) chunk = (uint32_t)fits; // samples whose rows one binding holds
    if (chunk > step_samples) chunk = step_samples;
    assert(group_samples > 0); // the configuration has samples
    s->chunk_samples = chunk < group_samples ? group_samples : chunk / group_samples * group_samples;
    model->scatter = choose_scatter(choices->scatter, limits, s->chunk_samples);
    s->skip_zeros = choices->skip_zeros;
    s->fold_rows = choices->fold_rows;
    s->slice_samples = choices->slice_samples;
    s->rows_texel =
        choices->rows_texel && VW_ROWS_SIZE((uint64_t)model->row_count, s->chunk_samples) <= limits->texel_elements;
    bool grid_too_large = model->grid.size_bytes > limits->storage_binding_bytes; // for a storage buffer
    s->grid_texel = (choices->grid_texel || grid_too_large) && model->pair_count <= limits->texel_elements;
    if (!s->grid_texel && grid_too_large)
        return vw_fail(VW_ERROR_USAGE,
                       "--log2-table: a grid of %llu bytes exceeds what this device binds; lower it or --levels",
                       (unsigned long long)model->grid.size_bytes);
    if (16 * model->weight_columns > limits->shared_memory_bytes)
        return vw_fail(VW_ERROR_USAGE,
                       "--width: the networks' weights take %u bytes of shared memory, the device has %u; lower "
                       "--width or --levels",
                       16 * model->weight_columns, limits->shared_memory_bytes);
    return lay_out_windows(config, limits, model);
}

// One uniform number in [-scale, scale) per parameter, keyed by its index in the block.
static void fill_uniform(float *values, uint64_t count, uint64_t first_index, float scale, uint64_t seed) {
    for (uint64_t i = 0; i < count; i += 4) {
        uint32_t words[4];
        vw_random_words(seed, VW_RANDOM_INITIALISATION, 0, (uint32_t)((first_index + i) / 4), 0, words);
        for (uint64_t j = 0; j < 4 && i + j < count; j++)
            values[i + j] = scale * (2.0f * vw_random_unit(words[j]) - 1.0f);
    }
}

static void fill_halves(uint16_t *halves, uint64_t count, uint64_t first_index, uint64_t seed) {
    for (uint64_t i = 0; i < count; i += 4) {
        float values[4];
        fill_uniform(values, 4, first_index + i, GRID_SCALE, seed);
        for (uint64_t j = 0; j < 4; j++) halves[i + j] = half_nearest(values[j]);
    }
}

// The grid, whose draws come first. Levels have whole fours; what a level of halves has more of padding is 0.
static void fill_grid(const struct model *model, uint64_t seed, void *grid) {
    memset(grid, 0, model->grid.size_bytes);
    for (uint32_t level = 0; level < model->specialization.levels; level++) {
        uint64_t first = 2 * (uint64_t)model->specialization.first_pair[level],
                 first_drawn = 2 * (uint64_t)model->drawn_pair[level];
        uint64_t count = 2 * (uint64_t)model->drawn_pair[level + 1] - first_drawn;
        if (model->half_grid) fill_halves((uint16_t *)grid + first, count, first_drawn, seed);
        else fill_uniform((float *)grid + first, count, first_drawn, GRID_SCALE, seed);
    }
}

// Behind the grid: its numbers are keyed as if the grid's were floats, too.
struct drawn {
    const float *weights;
    uint64_t first_index, seed;
};

// He's bound for layers behind a ReLU, so that the signal keeps its size; `inputs` is the fan-in.
static float *fill_matrix(float *values, const struct drawn *drawn, uint32_t out4, uint32_t in4) {
    uint64_t count = 16 * (uint64_t)out4 * in4, index = drawn->first_index + (uint64_t)(values - drawn->weights);
    fill_uniform(values, count, index, sqrtf(6.0f / (4.0f * (float)in4)), drawn->seed);
    return values + count;
}

void model_initialise(const struct model *model, uint64_t seed, void *params) {
    uint32_t width4 = model->specialization.width4,
             encoding4 = model->specialization.levels * model->specialization.feature_pairs / 2;
    float *weights = (float *)((char *)params + model->weights.offset_bytes);
    const struct drawn drawn = {weights, 2 * (uint64_t)model->drawn_pair[model->specialization.levels], seed};
    fill_grid(model, seed, params);
    float *next = fill_matrix(weights, &drawn, width4, encoding4);
    next = fill_matrix(next, &drawn, GEO4, width4);
    next = fill_matrix(next, &drawn, width4, COLOUR4);
    float *last = next;
    next = fill_matrix(next, &drawn, 1, width4);
    for (float *value = last + 3; value < next; value += 4) *value = 0.0f; // the unused fourth output
    uint64_t filled = (uint64_t)((char *)next - (char *)params);
    assert(filled == model->weights.offset_bytes + model->weights.size_bytes);
    memset(next, 0, model->param_bytes - filled);
    // Codes of 0 and weights that are not: the field starts as it would without them, and both have gradients from the
    // second visit on.
    if (model->code_weights.size_bytes)
        fill_matrix((float *)((char *)params + model->code_weights.offset_bytes), &drawn, width4, CODE4);
}
