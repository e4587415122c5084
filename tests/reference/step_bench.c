#include "step_bench.h"
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "base/random.h"
#include "base/text.h"
#include "detect/decide.h"
#include "gpu/compute.h"
#include "support/gpu_fixture.h"
#include "support/guard_bands.h"
#include "support/plain_config.h"
#include "train/model.h"
#include "train/pixels.h"

static void stop_unless(const struct step_bench *bench, enum vw_status status) {
    if (status != VW_OK) fail_msg("%s: %s", bench->where, vw_error_message());
}

static void choose_effects(const struct step_case *c, struct vw_config *config) {
    const char *effects = c->effects          ? c->effects
                          : c->another_effect ? ""
                                              : "none",
               *another = c->another_effect ? c->another_effect : "";
    snprintf(config->effects, sizeof config->effects, "%s%s%s", effects, *effects && *another ? "," : "", another);
}

static struct vw_config make_config(const struct step_case *c) {
    struct vw_config config = plain_config();
    config.seed = c->seed;
    config.rays = c->rays ? c->rays : 20;
    config.samples = c->samples ? c->samples : 32;
    config.importance_samples = c->importance_samples;
    config.coarse_network = c->own_coarse ? VW_COARSE_NETWORK_OWN : VW_COARSE_NETWORK_SHARED;
    config.levels = c->levels ? c->levels : c->field == VW_FIELD_HASH ? 8 : config.levels;
    config.features = c->features ? c->features : 2;
    config.log2_table = c->one_entry ? 0 : c->log2_table ? c->log2_table : 14;
    config.base_resolution = c->base_resolution ? c->base_resolution : 8;
    config.width = c->width ? c->width : 32;
    config.field = c->field;
    if (c->mlp_depth) config.mlp_depth = c->mlp_depth;
    if (c->frequencies) config.frequencies = c->frequencies;
    config.loss = c->loss;
    config.consistency_weight = c->consistency_weight;
    if (c->beta_min > 0.0) config.beta_min = c->beta_min;
    if (c->huber_length > 0.0) config.huber_length = c->huber_length;
    config.optimizer = c->optimizer;
    config.beta1 = c->beta1;
    config.beta2 = c->beta2 > 0.0 ? c->beta2 : 0.99;
    config.background = c->random_background ? VW_BACKGROUND_RANDOM : VW_BACKGROUND_FIXED;
    choose_effects(c, &config);
    return config;
}

// Sets what the case asks for in place of what vw_model_create decides by the device, the size of a step, or the range
// a user has.
static void override_model(const struct step_case *c, struct step_bench *bench) {
    struct vw_specialization *s = &bench->model.specialization;
    if (c->learning_rate > 0.0) s->learning_rate = (float)c->learning_rate; // also beyond what a user may set
    const struct vw_gpu_limits *limits = vw_gpu_get_limits(bench->gpu);
    bool can = c->scatter == SCATTER_WALK ? limits->int64 : limits->int64_atomics;
    bench->layout->scatter = can ? c->scatter : SCATTER_SPLIT_ATOMICS;
    s->chunk_samples = c->chunk_samples
                           ? c->chunk_samples
                           : vw_model_pad_rays(&bench->model, bench->config.rays) * bench->layout->ray_samples;
    if (c->slice_samples) s->slice_samples = c->slice_samples;
    if (c->slice_parts) s->slice_parts = c->slice_parts;
    if (c->ray_lanes) s->ray_lanes = c->ray_lanes;
    if (c->distortion) s->effect_distortion = c->distortion;
    s->rows_texel = !c->as_on_gpus && VW_ROWS_SIZE((uint64_t)bench->layout->row_count, s->chunk_samples) <=
                                          vw_gpu_get_limits(bench->gpu)->texel_elements;
    if (!c->wide || s->wide_gradient) return;
    s->wide_gradient = 1;
    s->gradient_quantum = 0x1p-34f;
    s->gradient_clamp = 1024.0f;
}

// Draws the params of photos as if they had been trained for a while; they start at 0.
static void draw_photos(struct step_bench *bench, const struct vw_param_range *range, float scale,
                        struct test_random *random) {
    float *values = bench->params + range->offset_bytes / sizeof(float);
    bool padded = range == &bench->model.ranges[VW_SLOT_APPEARANCE] || range == &bench->model.ranges[VW_SLOT_POSES];
    for (size_t i = 0; i < range->size_bytes / sizeof(float); i++)
        values[i] = padded && i % 4 == 3 ? 0.0f : scale * test_random_next(random);
}

static void make_params(const struct step_case *c, struct step_bench *bench) {
    struct test_random random = {.seed = c->seed};
    float grid_scale = c->grid_scale > 0.0f ? c->grid_scale : 0.5f,
          weight_scale = c->weight_scale > 0.0f ? c->weight_scale : 1.0f;
    bench->params = test_allocate(bench->model.param_bytes, 1);
    stop_unless(bench, vw_model_initialise(&bench->model, bench->scene, c->seed, bench->params));
    size_t grid = bench->layout->grid.size_bytes / sizeof(float),
           sky = bench->model.ranges[VW_SLOT_SKY].offset_bytes / sizeof(float);
    size_t sky_end = sky + bench->model.ranges[VW_SLOT_SKY].size_bytes / sizeof(float);
    for (size_t i = 0; i < 2 * (size_t)bench->layout->pair_count; i++)
        bench->params[i] = grid_scale * test_random_next(&random);
    size_t all = bench->model.param_bytes / sizeof(float);
    for (size_t i = grid; i < all; i++) bench->params[i] *= weight_scale;
    for (size_t i = sky; i < sky_end; i++)
        bench->params[i] = i % 4 < 3 ? weight_scale * test_random_next(&random) : 0.0f;
    draw_photos(bench, &bench->model.ranges[VW_SLOT_APPEARANCE], 0.3f, &random);
    draw_photos(bench, &bench->model.ranges[VW_SLOT_CODES], 0.5f, &random);
    draw_photos(bench, &bench->model.ranges[VW_SLOT_VISIBILITY_CODES], 0.5f, &random);
    draw_photos(bench, &bench->model.ranges[VW_SLOT_TRANSIENT_CODES], 0.5f, &random);
    draw_photos(bench, &bench->model.ranges[VW_SLOT_POSES], 0.05f, &random);
    const struct vw_param_range encoder = vw_encoder_network(&bench->model);
    draw_photos(bench, &encoder, 0.15f, &random);
}

static void make_pixels(struct step_bench *bench) {
    uint32_t rays = bench->config.rays;
    bench->pixels = test_allocate(rays, sizeof *bench->pixels);
    bench->view = bench->model.ranges[VW_SLOT_APPEARANCE].size_bytes || bench->model.ranges[VW_SLOT_CODES].size_bytes ||
                  bench->model.ranges[VW_SLOT_VISIBILITY_CODES].size_bytes ||
                  bench->model.ranges[VW_SLOT_TRANSIENT_CODES].size_bytes ||
                  bench->model.ranges[VW_SLOT_POSES].size_bytes ||
                  vw_encoder_network(&bench->model).size_bytes; // not 0, where it matters
    const struct vw_pixel_draw first = {bench->config.seed, 1, 0, 0}, second = {bench->config.seed, 2, 0, 0};
    vw_pixels_draw(bench->scene, bench->view, &first, rays / 2, bench->pixels);
    vw_pixels_draw(bench->scene, 1 - bench->view, &second, rays - rays / 2, bench->pixels + rays / 2);
}

static void describe(struct step_bench *bench, const struct step_case *c) {
    snprintf(bench->where, sizeof bench->where, "case \"%s\", seed %llu", c->name, (unsigned long long)c->seed);
    bench->scene =
        synthetic_scene(&(struct synthetic_scene_params){.train_views = 2,
                                                         .val_views = 1,
                                                         .width_px = 24,
                                                         .height_px = 20,
                                                         .k1 = vw_word_list_has(c->effects, "distortion") ? -0.15 : 0.0,
                                                         .alpha = vw_word_list_has(c->effects, "background")});
    struct vw_effect_decision decisions[VW_EFFECT_COUNT_MAX];
    uint32_t count;
    stop_unless(bench, vw_config_check(&bench->config));
    stop_unless(bench, vw_effects_find_facts(bench->scene, bench->config.effects, decisions, &count));
    struct vw_gpu_info device = *vw_gpu_get_info(bench->gpu);
    if (c->as_on_gpus) device.kind = VW_GPU_DISCRETE;
    struct vw_device_choices choices;
    vw_device_choose(&device, &choices);
    stop_unless(bench, vw_model_create(&bench->config, bench->scene, NULL, 0, decisions, &choices,
                                       vw_gpu_get_limits(bench->gpu), &bench->model));
    bench->layout = vw_volume_of(&bench->model);
    bench->padded_samples = vw_model_pad_rays(&bench->model, bench->config.rays) * bench->model.specialization.samples;
    override_model(c, bench);
    make_params(c, bench);
    make_pixels(bench);
}

static void close_bench(void *opened) {
    struct step_bench *bench = opened;
    char where[sizeof bench->where];
    memcpy(where, bench->where, sizeof where);
    vw_evaluator_destroy(&bench->evaluator);
    vw_submission_destroy(&bench->submission);
    vw_step_destroy(&bench->step);
    vw_photo_order_destroy(&bench->photo_order);
    vw_field_destroy(&bench->field);
    vw_model_destroy(&bench->model);
    vw_buffer_destroy(&bench->pixel_buffer);
    vw_buffer_destroy(&bench->scalars);
    free(bench);
    if (guard_bands_broken()) fail_msg("%s: guard bands were written to, see stderr", where);
}

static void draw_features(struct step_bench *bench) {
    struct vw_buffer *features = bench->step.effect_buffers[VW_SLOT_FEATURES];
    struct test_random random = {.seed = bench->config.seed + 7};
    float *numbers = features ? vw_buffer_map(features) : NULL;
    for (uint32_t i = 0; numbers && i < bench->config.rays * 4 * FEATURE4; i++)
        numbers[i] = i % (4 * FEATURE4) + 1 < 4 * FEATURE4 ? test_random_next(&random) : 1.0f;
}

static struct step_bench *open_on(struct vw_gpu *gpu, const struct step_case *c) {
    struct step_bench *bench = vw_allocate(1, sizeof *bench);
    *bench = (struct step_bench){.gpu = gpu, .config = make_config(c)};
    describe(bench, c);
    test_own(bench, close_bench); // closed before its scene
    uint64_t pixel_bytes = bench->config.rays * sizeof *bench->pixels;
    stop_unless(bench, vw_field_create(gpu, &bench->model, bench->scene, c->seed, &bench->field));
    stop_unless(bench, vw_buffer_create(gpu,
                                        &(struct vw_buffer_params){
                                            .name = "pixels", .size_bytes = pixel_bytes, .memory = VW_BUFFER_UPLOAD},
                                        &bench->pixel_buffer));
    memcpy(vw_buffer_map(bench->pixel_buffer), bench->pixels, pixel_bytes);
    stop_unless(
        bench, vw_buffer_create(gpu, &(struct vw_buffer_params){.name = "scalars", .size_bytes = 64}, &bench->scalars));
    stop_unless(bench, vw_photo_order_create(bench->scene, NULL, 0, &bench->config, &bench->photo_order));
    stop_unless(bench, vw_step_create(&bench->field, &bench->photo_order, bench->pixel_buffer, bench->scalars, NULL,
                                      &bench->step));
    bench->volume = vw_volume_step_of(&bench->step);
    stop_unless(bench, vw_submission_create(gpu, &bench->submission));
    step_bench_write_params(bench);
    draw_features(bench);
    return bench;
}

struct step_bench *step_bench_open(const struct step_case *c) {
    return open_on(test_gpu(), c);
}

struct step_bench *step_bench_open_clamped(const struct step_case *c, const struct vw_gpu_limits *clamp) {
    return open_on(test_gpu_open((struct vw_gpu_params){.validation = true, .clamp = clamp}), c);
}

struct vw_evaluator *step_bench_evaluator(struct step_bench *bench) {
    if (bench->evaluator.field) return &bench->evaluator;
    stop_unless(bench, vw_evaluator_create(&bench->field, bench->step.padded_rays, false, &bench->evaluator));
    return &bench->evaluator;
}

struct vw_evaluator *step_bench_evaluate(struct step_bench *bench) {
    struct vw_evaluator *evaluator = step_bench_evaluator(bench);
    stop_unless(bench, vw_evaluator_set_pixels(evaluator, bench->pixels, bench->config.rays));
    vw_submission_begin(bench->submission);
    vw_evaluator_record(evaluator, bench->submission);
    test_submit(bench->submission);
    return evaluator;
}

void step_bench_write_params(struct step_bench *bench) { test_write(bench->field.params, bench->params); }

struct vw_push_samples step_bench_push(const struct step_bench *bench, uint64_t number) {
    return (struct vw_push_samples){.ray_count = bench->step.padded_rays,
                                    .key = vw_model_key_of_step(&bench->model, number)};
}

uint64_t step_bench_lanes(const struct step_bench *bench, uint32_t rays) {
    return (uint64_t)rays * bench->model.specialization.ray_lanes;
}

void step_bench_gradients(struct step_bench *bench, uint64_t number) {
    assert_int_equal(bench->volume->chunk_rays,
                     bench->step.padded_rays); // so that activations of all samples are left
    vw_submission_begin(bench->submission);
    vw_step_record_gradients(&bench->step, bench->submission, number, 0);
    vw_step_record_loss(&bench->step, bench->submission, 0, 0);
    test_submit(bench->submission);
}

void step_bench_step(struct step_bench *bench, uint64_t number) {
    vw_submission_begin(bench->submission);
    vw_step_record_passes(&bench->step, bench->submission, number, 0, 0);
    test_submit(bench->submission);
}

void step_bench_dispatch(struct step_bench *bench, const struct vw_pass *pass, const void *push, size_t push_bytes,
                         uint64_t invocations) {
    vw_submission_begin(bench->submission);
    vw_submission_dispatch(bench->submission, pass, push, push_bytes, invocations);
    test_submit(bench->submission);
}

static bool is_named(const struct vw_pass *pass, const char *name) {
    return pass && !strncmp(vw_pass_name(pass), name, strlen(name));
}

const struct vw_pass *step_bench_effect_pass(const struct step_bench *bench, const char *name) {
    const struct vw_pass *sky = bench->volume->gradient.of_rays.gradient_sky;
    for (uint32_t i = 0; i < bench->model.effect_count; i++)
        for (uint32_t k = 0; k < VW_EFFECT_PASSES_MAX; k++)
            if (is_named(bench->step.effects.sets[i].passes[k], name)) return bench->step.effects.sets[i].passes[k];
    return is_named(sky, name) ? sky : NULL;
}

// Finds where in its photo the pixel of a ray lies, -1 to 1 across it.
static void find_place(const struct step_bench *bench, uint32_t ray, double place[2]) {
    const struct vw_pixel *pixel = &bench->pixels[ray < bench->config.rays ? ray : bench->config.rays - 1];
    const struct vw_image *image = &bench->scene->views[bench->view].image;
    place[0] = 2.0 * pixel->x_px / image->width_px - 1.0;
    place[1] = 2.0 * pixel->y_px / image->height_px - 1.0;
}

// Finds the features of its pixel, with the effect uncertainty.
static void list_features(const struct step_bench *bench, uint32_t ray, double features[REFERENCE_FEATURES]) {
    struct vw_buffer *buffer = bench->step.effect_buffers[VW_SLOT_FEATURES];
    uint32_t drawn = ray < bench->config.rays ? ray : bench->config.rays - 1;
    const float *of_ray = buffer ? (const float *)vw_buffer_map(buffer) + REFERENCE_FEATURES * drawn : NULL;
    for (uint32_t k = 0; of_ray && k < REFERENCE_FEATURES; k++) features[k] = of_ray[k];
}

double *step_bench_sample_places(struct vw_buffer *places) {
    if (!places) return NULL;
    float *listed = test_read(places);
    size_t count = vw_buffer_size_bytes(places) / sizeof *listed;
    double *exact = test_allocate(count, sizeof *exact);
    for (size_t i = 0; i < count; i++) exact[i] = listed[i];
    return exact;
}

struct reference_step *step_bench_reference(struct step_bench *bench) {
    struct vw_ray *rays = test_read(bench->step.ray_buffer);
    struct reference_step *reference = reference_step_create(&bench->model, rays, bench->step.padded_rays);
    reference->view = bench->view;
    for (uint32_t ray = 0; ray < bench->step.padded_rays; ray++) {
        find_place(bench, ray, reference->places[ray]);
        list_features(bench, ray, reference->features[ray]);
    }
    reference->sample_places = step_bench_sample_places(bench->volume->places);
    return reference;
}

uint32_t step_bench_take_overflows(struct step_bench *bench) {
    uint64_t words = vw_buffer_size_bytes(bench->step.overflow) / 4;
    uint32_t *flags = test_read(bench->step.overflow), count = 0;
    for (uint64_t i = 0; i < words; i += VW_OVERFLOW_STRIDE) count += flags[i] != 0;
    memset(flags, 0, 4 * words);
    test_write(bench->step.overflow, flags);
    return count;
}

struct step_rows step_bench_rows(const struct step_bench *bench) {
    uint32_t encoding4 = bench->config.levels * bench->config.features / 4, width4 = bench->config.width / 4;
    struct step_rows rows = {0};
    rows.hidden1 = rows.encoding + encoding4;
    rows.colour_in = rows.hidden1 + width4;
    rows.hidden2 = rows.colour_in + COLOUR4;
    rows.d_hidden1 = rows.hidden2 + width4;
    rows.d_geo = rows.d_hidden1 + width4;
    rows.d_hidden2 = rows.d_geo + GEO4;
    rows.d_logit = rows.d_hidden2 + width4;
    rows.d_encoding = rows.d_logit + 1; // on the device the two rows of bits stand there
    rows.position = rows.d_encoding + encoding4;
    rows.count = rows.position + 1;
    return rows;
}

float *step_bench_new_rows(const struct step_bench *bench, size_t *count) {
    *count = 4 * (size_t)step_bench_rows(bench).count * bench->model.specialization.chunk_samples;
    return test_allocate(*count, sizeof(float));
}

float *step_bench_row(const struct step_bench *bench, const float *rows, uint32_t row, uint32_t slot) {
    return (float *)rows + 4 * ((size_t)row * bench->model.specialization.chunk_samples + slot);
}

// Rounds to the nearest, halves away from 0; what is not finite stays so.
static uint16_t to_bfloat(float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return (uint16_t)((bits + (isfinite(value) ? 0x8000u : 0)) >> 16);
}

static float from_bfloat(uint16_t half) {
    uint32_t bits = (uint32_t)half << 16;
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static uint16_t *bfloats_at(const struct step_bench *bench, uint16_t *rows, uint32_t row, uint32_t slot) {
    return rows + 4 * (size_t)VW_ROW_PLACE(bench->layout->row_count, row, slot);
}

static float *grid_row_at(const struct step_bench *bench, float *grid_rows, uint32_t row, uint32_t slot) {
    return grid_rows + 4 * (size_t)VW_ROW_PLACE(bench->layout->grid_row_count, row, slot);
}

// Converts the device's form of one slot to floats; pack_slot() converts back.
static void unpack_slot(const struct step_bench *bench, uint16_t *packed, float *grid_rows, uint32_t slot,
                        float *rows) {
    struct step_rows row = step_bench_rows(bench);
    for (uint32_t r = 0; r < row.d_encoding; r++)
        for (int i = 0; i < 4; i++)
            step_bench_row(bench, rows, r, slot)[i] = from_bfloat(bfloats_at(bench, packed, r, slot)[i]);
    for (uint32_t r = row.d_encoding; r < row.count; r++)
        memcpy(step_bench_row(bench, rows, r, slot), grid_row_at(bench, grid_rows, r - row.d_encoding, slot), 16);
}

static void pack_slot(const struct step_bench *bench, const float *rows, uint32_t slot, uint16_t *packed,
                      float *grid_rows) {
    struct step_rows row = step_bench_rows(bench);
    for (uint32_t r = 0; r < row.d_encoding; r++)
        for (int i = 0; i < 4; i++)
            bfloats_at(bench, packed, r, slot)[i] = to_bfloat(step_bench_row(bench, rows, r, slot)[i]);
    for (uint32_t r = row.d_encoding; r < row.count; r++)
        memcpy(grid_row_at(bench, grid_rows, r - row.d_encoding, slot), step_bench_row(bench, rows, r, slot), 16);
}

float *step_bench_read_rows(struct step_bench *bench) {
    size_t count;
    uint16_t *packed = test_read(bench->field.rows);
    float *rows = step_bench_new_rows(bench, &count), *grid_rows = test_read(bench->field.grid_rows);
    for (uint32_t slot = 0; slot < bench->model.specialization.chunk_samples; slot++)
        unpack_slot(bench, packed, grid_rows, slot, rows);
    return rows;
}

void step_bench_write_rows(struct step_bench *bench, float *rows) {
    uint16_t *packed = test_read(bench->field.rows);
    float *grid_rows = test_read(bench->field.grid_rows);
    for (uint32_t slot = 0; slot < bench->model.specialization.chunk_samples; slot++) {
        pack_slot(bench, rows, slot, packed, grid_rows);
        unpack_slot(bench, packed, grid_rows, slot, rows);
    }
    test_write(bench->field.rows, packed);
    test_write(bench->field.grid_rows, grid_rows);
}

vw_uint4 *step_bench_read_active(struct step_bench *bench) {
    uint32_t samples = bench->model.specialization.chunk_samples, row = step_bench_rows(bench).d_encoding;
    uint16_t *packed = test_read(bench->field.rows);
    vw_uint4 *active = test_allocate(samples, sizeof *active);
    for (uint32_t slot = 0; slot < samples; slot++) { // two rows of two words
        memcpy(&active[slot].x, bfloats_at(bench, packed, row, slot), 8);
        memcpy(&active[slot].z, bfloats_at(bench, packed, row + 1, slot), 8);
    }
    return active;
}

// ---- Gradients ------------------------------------------------------------------------------------------------------

static const double WEIGHT_TOLERANCE = 0x1p-7; // two bfloats, each good to 2^-8
static const double SKY_TOLERANCE = 1e-4;
static const double RAY_NETWORK_TOLERANCE = 5e-4; // a unit near the kink may fall to either side

static float *floats_of(const double *values, size_t count) {
    float *floats = test_allocate(count, sizeof *floats);
    for (size_t i = 0; i < count; i++) floats[i] = (float)values[i];
    return floats;
}

static float *d_matrix(const struct vw_specialization *s, const float *d_weights, uint32_t m,
                       const struct reference_matrix *matrix) {
    float *gradient = test_allocate((size_t)matrix->out * matrix->in, sizeof *gradient);
    for (uint32_t i = 0; i < matrix->out * matrix->in; i++)
        gradient[i] = d_weights[reference_block_index(s, m, i / matrix->in, i % matrix->in)];
    return gradient;
}

static float *d_sky(const struct vw_model *model, const float *d_weights) {
    float *gradient = test_allocate(3 * VW_SKY_COLUMNS, sizeof *gradient);
    for (uint32_t i = 0; i < 3 * VW_SKY_COLUMNS; i++)
        gradient[i] = d_weights[4 * (model->weight_columns + i / 3) + i % 3];
    return gradient;
}

// Finds the gradient by a photo's code of visibility from that by the biases of the first layer's units.
static float *d_visibility_code(const double *network, const float *d_network) {
    float *gradient = test_allocate(REFERENCE_VISIBILITY_CODE, sizeof *gradient);
    for (uint32_t k = 0; k < REFERENCE_VISIBILITY_CODE; k++)
        for (uint32_t unit = 0; unit < 4 * VISIBILITY4; unit++) { // blocks of the first layer, rows of 40 inputs
            uint32_t row = 16 * (unit / 4) * VISIBILITY_INPUT4 + unit % 4, in4 = VISIBILITY_PLACE4 + k / 4;
            gradient[k] += (float)(d_network[row + 4 * 2] * network[row + 16 * in4 + 4 * (k % 4)]);
        }
    return gradient;
}

// Lists code weights and the photo's code, whose gradients follow from that of the colour network's input 0.
static uint32_t list_codes(const struct step_bench *bench, struct reference_step *reference,
                           struct reference_params *params, const float *d_weights, struct step_range *ranges) {
    const struct vw_specialization *s = &bench->model.specialization;
    uint32_t width = 4 * s->width4, weights = width * REFERENCE_CODE;
    double d_shift[REFERENCE_WIDTH_MAX], d_code[REFERENCE_CODE],
        *d_code_weights = test_allocate(weights, sizeof *d_code_weights), *code = params->photos[bench->view].code;
    for (uint32_t i = 0; i < width; i++) d_shift[i] = d_weights[reference_block_index(s, 2, i, 0)];
    reference_mix_code_gradient(width, params->code_weights, code, d_shift, d_code_weights, d_code);
    ranges[0] = (struct step_range){
        "code weights", params->code_weights, reference->d_code_weights, floats_of(d_code_weights, weights),
        weights,        WEIGHT_TOLERANCE};
    ranges[1] = (struct step_range){
        "code", code, reference->d_code, floats_of(d_code, REFERENCE_CODE), REFERENCE_CODE, WEIGHT_TOLERANCE};
    return 2;
}

uint32_t step_bench_ranges(const struct step_bench *bench, struct reference_step *reference,
                           struct reference_params *params, const float *d_weights,
                           struct step_range ranges[STEP_RANGES_MAX]) {
    const struct vw_specialization *s = &bench->model.specialization;
    struct reference_matrix values[REFERENCE_MATRICES], gradients[REFERENCE_MATRICES];
    float *d_network = (float *)d_weights + 4 * (size_t)s->visibility_column;
    uint32_t count = REFERENCE_MATRICES;
    reference_matrices(s, &params->weights, values);
    reference_matrices(s, &reference->d_weights, gradients);
    for (uint32_t m = 0; m < REFERENCE_MATRICES; m++)
        ranges[m] = (struct step_range){values[m].name,
                                        values[m].values,
                                        gradients[m].values,
                                        d_matrix(s, d_weights, m, &values[m]),
                                        (size_t)values[m].out * values[m].in,
                                        WEIGHT_TOLERANCE};
    if (s->effect_sky)
        ranges[count++] = (struct step_range){
            "sky",        params->sky[0], reference->d_sky[0], d_sky(&bench->model, d_weights), 3 * VW_SKY_COLUMNS,
            SKY_TOLERANCE};
    if (s->effect_visibility) {
        double *code = params->visibility_codes[bench->view];
        ranges[count++] = (struct step_range){"visibility", params->visibility,   reference->d_visibility,
                                              d_network,    REFERENCE_VISIBILITY, RAY_NETWORK_TOLERANCE};
        ranges[count++] =
            (struct step_range){"code of visibility",         code,
                                reference->d_visibility_code, d_visibility_code(params->visibility, d_network),
                                REFERENCE_VISIBILITY_CODE,    2.0 * RAY_NETWORK_TOLERANCE};
    }
    if (s->effect_uncertainty)
        ranges[count++] = (struct step_range){"uncertainty", params->uncertainty,   reference->d_uncertainty,
                                              d_network,     REFERENCE_UNCERTAINTY, RAY_NETWORK_TOLERANCE};
    if (s->effect_appearance_code) count += list_codes(bench, reference, params, d_weights, &ranges[count]);
    return count;
}

// ---- Comparison -----------------------------------------------------------------------------------------------------

void check_value(const char *where, const char *what, uint64_t index, double device, double expected,
                 double tolerance) {
    if (fabs(device - expected) <= tolerance) return;
    fail_msg("%s: %s[%llu] is %.9g on the device, %.9g by the reference: off by %.3g, more than %.3g", where, what,
             (unsigned long long)index, device, expected, fabs(device - expected), tolerance);
}

void check_same_bits(const char *where, const char *what, const void *device, const void *expected, size_t size_bytes) {
    const unsigned char *a = device, *b = expected;
    for (size_t i = 0; i < size_bytes; i++)
        if (a[i] != b[i]) fail_msg("%s: %s differs at byte %zu of %zu", where, what, i, size_bytes);
}

void step_bench_check_skipped(struct step_bench *bench, uint64_t number) {
    step_bench_write_params(bench);
    step_bench_step(bench, number);
    vw_float4 *scalars = test_read(bench->scalars);
    float *after = test_read(bench->field.params);
    assert_true(scalars->z != 0.0f);
    check_same_bits(bench->where, "params of a skipped step", after, bench->params, bench->model.param_bytes);
}

void step_bench_check_chunks(const struct step_case *setup, uint32_t chunk_samples, uint64_t number) {
    struct step_case chunked = *setup;
    chunked.chunk_samples = chunk_samples;
    struct step_bench *whole = step_bench_open(setup), *parts = step_bench_open(&chunked);
    assert_true(parts->volume->chunk_rays < parts->step.padded_rays);
    step_bench_step(whole, number);
    step_bench_step(parts, number);
    float *expected = test_read(whole->field.params), *params = test_read(parts->field.params);
    assert_memory_not_equal(expected, whole->params, whole->model.param_bytes);
    check_same_bits(parts->where, "params of a step in chunks", params, expected, whole->model.param_bytes);
    test_release(whole);
    test_release(parts);
}

double largest(const double *values, size_t count) {
    double most = 0.0;
    for (size_t i = 0; i < count; i++) most = fmax(most, fabs(values[i]));
    return most;
}

double check_slope(const struct slope_check *check, const char *what, double *values, const float *gradient,
                   size_t count) {
    double *kept = test_allocate(count, sizeof *kept), magnitudes = 0.0, losses[2];
    memcpy(kept, values, count * sizeof *kept);
    for (size_t i = 0; i < count; i++) magnitudes += fabs((double)gradient[i]);
    for (int ahead = 0; ahead < 2; ahead++) {
        double by = ahead ? check->distance : -check->distance;
        for (size_t i = 0; i < count; i++) values[i] = kept[i] + by * ((gradient[i] > 0.0f) - (gradient[i] < 0.0f));
        losses[ahead] = check->loss(check->step);
    }
    memcpy(values, kept, count * sizeof *kept);
    check_value(check->where, what, 0, magnitudes, (losses[1] - losses[0]) / (2.0 * check->distance),
                check->tolerance * magnitudes + check->least);
    return magnitudes;
}

float test_random_next(struct test_random *random) {
    uint32_t words[4];
    vw_random_words(random->seed, VW_RANDOM_INITIALISATION, 1, random->drawn++, 0, words);
    return 2.0f * vw_random_unit(words[0]) - 1.0f;
}
