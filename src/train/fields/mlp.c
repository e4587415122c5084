#include "train/fields/mlp.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "gpu/shaders.h"
#include "train/field.h"
#include "train/fields/registry.h"
#include "train/passes.h"

enum { SKIP_LAYER = 4, TILE4_MAX = 16 }; // TILE4_MAX: multiply_layer's, 64 x 64 weights, 16 KiB of shared memory

static const float ADAM_EPSILON = 1e-8f; // for gradients of the mean loss; sums are floats, so no quantum asks for more

// ---- The list of matrices -------------------------------------------------------------------------------------------

static uint32_t ceiling4(uint32_t count) { return (count + 3) / 4; }

static struct vw_mlp_matrix *add_matrix(struct vw_mlp_list *list, struct vw_mlp_operand in, struct vw_mlp_operand out) {
    assert(list->count < MLP_MATRICES_MAX);
    struct vw_mlp_matrix *matrix = &list->matrices[list->count++];
    *matrix = (struct vw_mlp_matrix){.first_weight = list->columns,
                                     .first_bias = MLP_NONE,
                                     .in_row = in.row,
                                     .in4 = ceiling4(in.numbers),
                                     .in = in.numbers,
                                     .d_in_row = in.d_row,
                                     .out_row = out.row,
                                     .out4 = ceiling4(out.numbers),
                                     .out = out.numbers,
                                     .d_out_row = out.d_row};
    list->columns += 4 * matrix->in4 * matrix->out4;
    return matrix;
}

// Adds a layer of `numbers` outputs from one or two operands (the second may have 0 numbers, or no gradient). Its
// output's rows follow all others; the gradients by it are at `d_row`.
static struct vw_mlp_operand add_layer(struct vw_mlp_list *list, struct vw_mlp_operand first,
                                       struct vw_mlp_operand second, uint32_t numbers, uint32_t d_row) {
    struct vw_mlp_operand out = {list->row_count, numbers, d_row};
    struct vw_mlp_matrix *matrix = add_matrix(list, first, out);
    matrix->first_bias = list->columns;
    list->columns += matrix->out4;
    list->row_count += matrix->out4;
    matrix->fan_in = first.numbers + second.numbers;
    if (second.numbers) {
        matrix = add_matrix(list, second, out);
        matrix->fan_in = first.numbers + second.numbers;
    }
    matrix->ends_layer = true;
    return out;
}

static void rectify_last(struct vw_mlp_list *list) { list->matrices[list->count - 1].rectifies = true; }

// The head of the effect transient
enum { HEAD_OUTPUTS = 5 }; // logits of rgb, raw density; raw uncertainty in a row of its own

// The head's last biases at first: little density, with colours as good as unknown, so that the field itself explains
// first what it can. With biases of 0, as NeRF-W's port has them, the head explained so much that a clean scene came to
// 16 dB in 430 steps, 23 without the effect; with these to 23.
static const float HEAD_DENSITY = -3.0f, HEAD_UNCERTAINTY = 4.0f; // before softplus

// Gradients by its hidden layers stand in two places in turn, as those of the trunk.
void vw_mlp_append_head(struct vw_mlp_list *list, struct vw_mlp_operand features, uint32_t depth, uint32_t width) {
    const struct vw_mlp_operand none = {0}, code = {list->row_count, 4 * TRANSIENT_CODE4, MLP_NONE};
    uint32_t width4 = (width + 3) / 4, d_output = list->d_row_count, places[2] = {d_output + 2, d_output + 2 + width4};
    list->row_count += TRANSIENT_CODE4;
    list->d_row_count += 2 + 2 * width4;
    struct vw_mlp_operand hidden = features;
    for (uint32_t layer = 0; layer < depth; layer++) {
        hidden = add_layer(list, hidden, layer ? none : code, width, places[(depth - layer) % 2]);
        rectify_last(list);
        if (layer) list->matrices[list->count - 1].gates_back = true;
    }
    add_layer(list, hidden, none, HEAD_OUTPUTS, d_output);
    list->matrices[list->count - 1].gates_back = true;
    list->head_depth = depth;
}

static void initialise_head(const struct vw_mlp_list *list, float *weights) {
    float *biases = weights + 4 * (uint64_t)list->matrices[list->count - 1].first_bias;
    biases[3] = HEAD_DENSITY;
    biases[4] = HEAD_UNCERTAINTY;
}

void vw_mlp_specialise_head(const struct vw_mlp_list *list, struct vw_specialization *s) {
    const struct vw_mlp_matrix *last = &list->matrices[list->count - 1], *code = last - list->head_depth,
                               *features = code - 1;
    assert(last->out == HEAD_OUTPUTS && code->in == 4 * TRANSIENT_CODE4);
    s->transient_row = last->out_row;
    s->d_transient_row = last->d_out_row;
    s->d_feature_row = features->d_in_row;
    s->transient_code_row = code->in_row;
    s->transient_column = code->first_weight;
    s->transient_bias = features->first_bias;
    s->transient_width4 = code->out4;
}

// Gradients by what layers give out stand in two places in turn, since one layer's is needed while the next is found.
void vw_mlp_list(const struct vw_model *model, bool transient, uint32_t first_column, struct vw_mlp_list *list) {
    const struct vw_volume_model *volume = vw_volume_of(model);
    const uint32_t width4 = volume->trunk4, places[2] = {2, 2 + width4},
                   frequencies = model->specialization.position_frequencies;
    const struct vw_mlp_operand none = {0}, position = {0, 3 + 6 * frequencies, MLP_NONE},
                                direction = {VW_ENCODED4(frequencies), 3 + 6 * VW_DIRECTION_FREQUENCIES, MLP_NONE};
    *list = (struct vw_mlp_list){.columns = first_column,
                                 .row_count = direction.row + VW_ENCODED4(VW_DIRECTION_FREQUENCIES),
                                 .d_row_count = 2 + 2 * width4,
                                 .d_heads = {0, 1}};
    struct vw_mlp_operand trunk = position;
    for (uint32_t layer = 0; layer < volume->depth; layer++) {
        trunk = add_layer(list, trunk, layer == SKIP_LAYER + 1 ? position : none, 4 * width4,
                          places[(volume->depth - layer) % 2]);
        rectify_last(list);
        if (layer) list->matrices[list->count - 1 - (layer == SKIP_LAYER + 1)].gates_back = true;
    }
    struct vw_mlp_operand density = add_layer(list, trunk, none, 1, list->d_heads.density_row);
    list->matrices[list->count - 1].adds_to_gradient = list->matrices[list->count - 1].gates_back = true;
    struct vw_mlp_operand feature = add_layer(list, trunk, none, 4 * width4, places[0]);
    struct vw_mlp_operand colour = add_layer(list, feature, direction, 2 * width4, places[1]);
    rectify_last(list);
    list->matrices[list->count - 2].shifts = true;
    list->matrices[list->count - 2].adds_to_gradient = transient; // the backward pass comes from the head first
    list->shift_column = list->matrices[list->count - 2].first_bias;
    struct vw_mlp_operand logit = add_layer(list, colour, none, 3, list->d_heads.logit_row);
    list->matrices[list->count - 1].gates_back = true;
    list->heads = (struct vw_push_heads){density.row, logit.row};
    if (transient) vw_mlp_append_head(list, feature, MLP_HEAD_DEPTH, 2 * width4);
}

void vw_mlp_count(const struct vw_mlp_list *list, uint32_t *partial_columns, uint64_t *param_count) {
    for (uint32_t i = 0; i < list->count; i++) {
        const struct vw_mlp_matrix *matrix = &list->matrices[i];
        bool biases = matrix->first_bias != MLP_NONE;
        uint32_t columns = matrix->out4 * (4 * matrix->in4 + biases);
        if (columns > *partial_columns) *partial_columns = columns;
        *param_count += (uint64_t)matrix->out * (matrix->in + biases);
    }
}

// ---- Layout ---------------------------------------------------------------------------------------------------------

static void lay_out(struct vw_model *model) {
    const struct vw_config *config = model->config;
    struct vw_volume_model *volume = vw_volume_of(model);
    struct vw_specialization *s = &model->specialization;
    struct vw_mlp_list list;
    volume->depth = config->mlp_depth;
    volume->trunk4 = config->width / 4;
    s->width4 = volume->trunk4 / 2; // the width of the colour layer, which codes shift
    s->position_frequencies = config->frequencies;
    if (config->coarse_network == VW_COARSE_NETWORK_OWN) {
        vw_mlp_list(model, false, 0, &list);
        vw_mlp_count(&list, &volume->partial_columns, &model->param_count);
        volume->coarse_columns = list.columns;
    }
    vw_mlp_list(model, s->effect_transient, 0, &list);
    vw_mlp_count(&list, &volume->partial_columns, &model->param_count);
    if (s->effect_transient) vw_mlp_specialise_head(&list, s);
    model->weight_columns = list.columns;
    model->weights = (struct vw_param_range){0, 16 * (uint64_t)list.columns};
    volume->row_count = s->layer_rows = list.row_count;
    volume->d_row_count = s->d_layer_rows = list.d_row_count;
    volume->row_bytes = VW_LAYER_ROW_BYTES;
    s->shift_column = list.shift_column;
    s->shift_stride = 1;
}

static enum vw_status fit(const struct vw_device_choices *choices, const struct vw_gpu_limits *limits,
                          struct vw_model *model) {
    (void)choices;
    model->specialization.gradient_quantum = ADAM_EPSILON * (float)model->config->rays; // see adam.glsl
    uint64_t slices = model->specialization.chunk_samples / model->specialization.slice_samples,
             partials = 16 * vw_volume_of(model)->partial_columns * slices, moved = 16 * (uint64_t)model->moved_columns;
    if (moved > limits->storage_binding_bytes || partials > limits->storage_binding_bytes)
        return vw_fail(VW_ERROR_USAGE,
                       "--width: the layers' gradients take %llu bytes, the device binds %llu; lower it",
                       (unsigned long long)partials, (unsigned long long)limits->storage_binding_bytes);
    return VW_OK;
}

// ---- Initial values: uniform for unit gain, biases 0, and what is padding 0 ----------------------------------------

void vw_mlp_initialise(const struct vw_mlp_list *list, const struct vw_drawn *drawn, float *weights) {
    for (uint32_t i = 0; i < list->count; i++) {
        const struct vw_mlp_matrix *matrix = &list->matrices[i];
        bool rectifies = matrix->rectifies || !matrix->ends_layer; // only layers with ReLU have two matrices
        float scale = sqrtf((rectifies ? 6.0f : 3.0f) / (float)matrix->fan_in),
              *values = weights + 4 * (uint64_t)matrix->first_weight;
        vw_fill_weights(values, drawn, 16 * (uint64_t)matrix->in4 * matrix->out4, scale);
        for (uint32_t k = 0; k < 16 * matrix->in4 * matrix->out4; k++) {
            uint32_t block = k / 16, out = 4 * (block / matrix->in4) + k % 4,
                     in = 4 * (block % matrix->in4) + k % 16 / 4;
            if (out >= matrix->out || in >= matrix->in) values[k] = 0.0f;
        }
    }
    if (list->head_depth) initialise_head(list, weights);
}

static void initialise(const struct vw_model *model, const struct vw_drawn *drawn, void *params) {
    struct vw_mlp_list list;
    float *weights = (float *)((char *)params + model->weights.offset_bytes);
    vw_mlp_list(model, model->specialization.effect_transient, 0, &list);
    memset(weights, 0, model->weights.size_bytes);
    vw_mlp_initialise(&list, drawn, weights);
    if (!vw_volume_of(model)->coarse_columns) return;
    vw_mlp_list(model, false, vw_volume_of(model)->coarse_column, &list);
    vw_mlp_initialise(&list, drawn, weights);
}

// ---- Passes ---------------------------------------------------------------------------------------------------------

enum { ENCODE, ACTIVATE, ACTIVATE_BACK, FEED, LAYERS };
enum { MULTIPLY_COUNT = (FIELD_PASSES_MAX - LAYERS - MLP_MULTIPLY) / 2 };

static struct vw_mlp_passes layers_of(const struct vw_field_passes *passes) {
    return (struct vw_mlp_passes){(struct vw_pass **)passes->passes + LAYERS, MULTIPLY_COUNT};
}

// Returns the rows of blocks of a matrix that a tile takes: as many as divide it.
static uint32_t tile_of(uint32_t rows4) {
    uint32_t tile = rows4 < TILE4_MAX ? rows4 : TILE4_MAX;
    while (rows4 % tile) tile--;
    return tile;
}

struct tile {
    uint32_t to4, from4;
};

static struct tile forward_tile(const struct vw_mlp_matrix *matrix) {
    return (struct tile){tile_of(matrix->out4), tile_of(matrix->in4)};
}

static struct tile backward_tile(const struct vw_mlp_matrix *matrix) {
    return (struct tile){tile_of(matrix->in4), tile_of(matrix->out4)};
}

// Sizes of tiles in the order in which the list first needs them, forward or back.
struct tiles {
    struct tile sizes[MULTIPLY_COUNT];
    uint32_t count;
};

static uint32_t find_tile(struct tiles *tiles, struct tile tile) {
    uint32_t i = 0;
    while (i < tiles->count && (tiles->sizes[i].to4 != tile.to4 || tiles->sizes[i].from4 != tile.from4)) i++;
    assert(i < MULTIPLY_COUNT);
    if (i == tiles->count) tiles->sizes[tiles->count++] = tile;
    return i;
}

static struct tiles list_tiles(const struct vw_mlp_list *list, bool back) {
    struct tiles tiles = {0};
    for (uint32_t i = 0; i < list->count; i++)
        if (!back) find_tile(&tiles, forward_tile(&list->matrices[i]));
        else if (list->matrices[i].d_in_row != MLP_NONE) find_tile(&tiles, backward_tile(&list->matrices[i]));
    return tiles;
}

static enum vw_status create_multiply(const struct vw_field_pass_params *params,
                                      const struct vw_specialization *specialization, const struct vw_mlp_list *list,
                                      bool back, struct vw_mlp_passes places) {
    const struct vw_shader *shader = back ? &vw_shader_multiply_layer_back : &vw_shader_multiply_layer;
    const struct tiles tiles = list_tiles(list, back);
    struct vw_pass **passes = places.passes + MLP_MULTIPLY + (back ? places.multiply_count : 0);
    struct vw_specialization tiled = *specialization;
    struct vw_pass_params common = params->common;
    common.specialization = (const uint32_t *)&tiled;
    enum vw_status status = VW_OK;
    assert(tiles.count <= places.multiply_count);
    for (uint32_t i = 0; i < tiles.count && !status; i++) {
        tiled.tile_to4 = tiles.sizes[i].to4;
        tiled.tile_from4 = tiles.sizes[i].from4;
        status = vw_pass_create_of(params->objects, &common, shader, &passes[i]);
    }
    return status;
}

enum vw_status vw_mlp_create_layers(const struct vw_field_pass_params *params,
                                    const struct vw_specialization *specialization, const struct vw_mlp_list *list,
                                    struct vw_mlp_passes places) {
    const struct vw_pass_row rows[] = {
        {&vw_shader_gradient_weights_layer, &places.passes[MLP_GRADIENT]},
        {&vw_shader_reduce_weights_layer, &places.passes[MLP_REDUCE]},
    };
    enum vw_status status =
        params->backward ? vw_passes_create(params->objects, &params->common, rows, VW_ARRAY_COUNT(rows)) : VW_OK;
    if (!status) status = create_multiply(params, specialization, list, false, places);
    if (!status && params->backward) status = create_multiply(params, specialization, list, true, places);
    return status;
}

static enum vw_status create_passes(const struct vw_radiance_field *field, const struct vw_field_pass_params *params,
                                    struct vw_field_passes *passes) {
    const struct vw_specialization *s = &passes->specialization;
    struct vw_mlp_list list;
    const struct vw_pass_row rows[] = {
        {&vw_shader_encode_samples, &passes->passes[ENCODE]},
        {&vw_shader_activate_samples, &passes->passes[ACTIVATE]},
        {params->backward ? &vw_shader_activate_samples_back : NULL, &passes->passes[ACTIVATE_BACK]},
        {s->effect_transient ? &vw_shader_feed_transient : NULL, &passes->passes[FEED]},
    };
    enum vw_status status = vw_passes_create(params->objects, &params->common, rows, VW_ARRAY_COUNT(rows));
    vw_mlp_list(field->model, s->effect_transient, passes->first_column, &list);
    return !status ? vw_mlp_create_layers(params, s, &list, layers_of(passes)) : status;
}

// ---- Recording ------------------------------------------------------------------------------------------------------

// Records a product. `push` names the whole matrix; its `from4` rows are read a tile at a time.
static void record_multiply(struct vw_submission *submission, const struct vw_pass *pass, struct tile tile,
                            uint32_t from4, struct vw_push_multiply push, uint64_t samples) {
    uint32_t begins = push.form & VW_MULTIPLY_ADDS, ends = push.form & VW_MULTIPLY_GATES;
    push.form &= ~(VW_MULTIPLY_ADDS | VW_MULTIPLY_GATES);
    for (uint32_t from = 0; from < from4; from += tile.from4) {
        struct vw_push_multiply part = push;
        part.first_weight += 4 * from * push.from_stride;
        part.from_row += from;
        part.form |= from ? VW_MULTIPLY_ADDS : begins;
        part.form |= from + tile.from4 == from4 ? ends : 0;
        vw_submission_dispatch(submission, pass, &part, sizeof part, samples * (push.to4 / tile.to4));
    }
}

void vw_mlp_record_layers(const struct vw_mlp_list *list, struct vw_mlp_passes places, struct vw_submission *submission,
                          uint64_t samples) {
    struct tiles tiles = {0};
    for (uint32_t i = 0; i < list->count; i++) {
        const struct vw_mlp_matrix *matrix = &list->matrices[i];
        struct tile tile = forward_tile(matrix);
        const struct vw_push_multiply push = {.first_weight = matrix->first_weight,
                                              .to_stride = matrix->in4,
                                              .from_stride = 1,
                                              .from_row = matrix->in_row,
                                              .to_row = matrix->out_row,
                                              .to4 = matrix->out4,
                                              .first_bias = matrix->first_bias == MLP_NONE ? 0 : matrix->first_bias,
                                              .form =
                                                  (matrix->first_bias == MLP_NONE ? VW_MULTIPLY_ADDS : 0) |
                                                  (matrix->ends_layer && matrix->rectifies ? VW_MULTIPLY_GATES : 0) |
                                                  (matrix->shifts ? VW_MULTIPLY_SHIFTS : 0)};
        record_multiply(submission, places.passes[MLP_MULTIPLY + find_tile(&tiles, tile)], tile, matrix->in4, push,
                        samples);
    }
}

static void record_forward(const struct vw_model *model, const struct vw_field_passes *passes,
                           struct vw_submission *submission, const struct vw_push_samples *rays) {
    struct vw_mlp_list list;
    uint64_t samples = (uint64_t)rays->ray_count * passes->specialization.samples;
    vw_mlp_list(model, passes->specialization.effect_transient, passes->first_column, &list);
    vw_submission_dispatch(submission, passes->passes[ENCODE], rays, sizeof *rays, samples);
    if (passes->passes[FEED]) vw_submission_dispatch(submission, passes->passes[FEED], NULL, 0, samples);
    vw_mlp_record_layers(&list, layers_of(passes), submission, samples);
    vw_submission_dispatch(submission, passes->passes[ACTIVATE], &list.heads, sizeof list.heads, samples);
}

static void record_gradient(const struct vw_specialization *specialization, struct vw_mlp_passes places,
                            struct vw_submission *submission, const struct vw_push_samples *rays,
                            const struct vw_mlp_matrix *matrix) {
    uint32_t samples = rays->ray_count * specialization->samples;
    uint64_t slices = samples / specialization->slice_samples;
    const struct vw_push_matrix push = {.first_weight = matrix->first_weight,
                                        .in_row = matrix->in_row,
                                        .out_row = matrix->d_out_row,
                                        .in4 = matrix->in4,
                                        .out4 = matrix->out4,
                                        .biases = matrix->first_bias != MLP_NONE,
                                        .samples = samples,
                                        .first_ray = rays->first_ray};
    vw_submission_dispatch(submission, places.passes[MLP_GRADIENT], &push, sizeof push,
                           slices * VW_TILES(matrix->out4, matrix->in4));
    vw_submission_dispatch(submission, places.passes[MLP_REDUCE], &push, sizeof push,
                           (uint64_t)matrix->out4 * (4 * matrix->in4 + push.biases));
}

static void record_back(const struct vw_pass *pass, struct vw_submission *submission, uint64_t samples,
                        const struct vw_mlp_matrix *matrix) {
    const struct vw_push_multiply push = {.first_weight = matrix->first_weight,
                                          .to_stride = 1,
                                          .from_stride = matrix->in4,
                                          .from_row = matrix->d_out_row,
                                          .to_row = matrix->d_in_row,
                                          .to4 = matrix->in4,
                                          .gate_row = matrix->in_row,
                                          .form = (matrix->adds_to_gradient ? VW_MULTIPLY_ADDS : 0) |
                                                  (matrix->gates_back ? VW_MULTIPLY_GATES : 0)};
    record_multiply(submission, pass, backward_tile(matrix), matrix->out4, push, samples);
}

void vw_mlp_record_layers_back(const struct vw_specialization *specialization, const struct vw_mlp_list *list,
                               struct vw_mlp_passes places, struct vw_submission *submission,
                               const struct vw_push_samples *rays) {
    struct tiles tiles = list_tiles(list, true);
    struct vw_pass **back = places.passes + MLP_MULTIPLY + places.multiply_count;
    uint64_t samples = (uint64_t)rays->ray_count * specialization->samples;
    for (uint32_t i = list->count; i-- > 0;) {
        const struct vw_mlp_matrix *matrix = &list->matrices[i];
        record_gradient(specialization, places, submission, rays, matrix);
        if (matrix->d_in_row != MLP_NONE)
            record_back(back[find_tile(&tiles, backward_tile(matrix))], submission, samples, matrix);
    }
}

static void record_backward(const struct vw_model *model, const struct vw_field_passes *passes,
                            struct vw_submission *submission, const struct vw_push_samples *rays) {
    struct vw_mlp_list list;
    uint64_t samples = (uint64_t)rays->ray_count * passes->specialization.samples;
    vw_mlp_list(model, passes->specialization.effect_transient, passes->first_column, &list);
    vw_submission_dispatch(submission, passes->passes[ACTIVATE_BACK], &list.d_heads, sizeof list.d_heads, samples);
    vw_mlp_record_layers_back(&passes->specialization, &list, layers_of(passes), submission, rays);
}

const struct vw_field_kind field_mlp = {
    .renders_in_rows = true,
    .lay_out = lay_out,
    .fit = fit,
    .initialise = initialise,
    .create_passes = create_passes,
    .record_forward = record_forward,
    .record_backward = record_backward,
};
