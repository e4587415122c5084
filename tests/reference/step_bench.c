#include "step_bench.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "support/gpu_fixture.h"
#include "support/guard_bands.h"
#include "train/pixels.h"
#include "viewworth/memory.h"
#include "viewworth/random.h"

static void stop_unless(const struct step_bench *bench, enum vw_status status) {
    if (status != VW_OK) fail_msg("%s: %s", bench->where, vw_error_message());
}

static struct vw_config make_config(const struct step_case *c) {
    struct vw_config config = vw_config_default;
    config.seed = c->seed;
    config.rays = c->rays ? c->rays : 20;
    config.samples = c->samples ? c->samples : 32;
    config.levels = c->levels ? c->levels : 8;
    config.features = c->features ? c->features : 2;
    config.log2_table = c->one_entry ? 0 : c->log2_table ? c->log2_table : 14;
    config.base_resolution = c->base_resolution ? c->base_resolution : 8;
    config.width = c->width ? c->width : 32;
    config.loss = c->loss;
    config.optimizer = c->optimizer;
    config.beta1 = c->beta1;
    config.beta2 = c->beta2 > 0.0 ? c->beta2 : 0.99;
    snprintf(config.effects, sizeof config.effects, "%s",
             c->distortion && c->background ? "distortion,background"
             : c->distortion                ? "distortion"
             : c->background                ? "background"
                                            : "none");
    return config;
}

// What the case asks for and model_create decides by the device, the size of a step, or the range a user has.
static void override_model(const struct step_case *c, struct step_bench *bench) {
    struct vw_specialization *s = &bench->model.specialization;
    if (c->learning_rate > 0.0) s->learning_rate = (float)c->learning_rate; // also beyond what a user may set
    bench->model.scatter = c->scatter;
    s->chunk_samples = c->chunk_samples ? c->chunk_samples : bench->padded_samples;
    s->rows_texel = (uint64_t)bench->model.row_count * VW_ROW_STRIDE(s->chunk_samples) <= vw_gpu_get_limits(bench->gpu)->texel_elements;
    if (!c->wide || s->wide_gradient) return;
    s->wide_gradient = 1;
    s->gradient_quantum = 0x1p-34f;
    s->gradient_clamp = 1024.0f;
}

static void make_params(const struct step_case *c, struct step_bench *bench) {
    struct test_random random = {.seed = c->seed};
    float grid_scale = c->grid_scale > 0.0f ? c->grid_scale : 0.5f, weight_scale = c->weight_scale > 0.0f ? c->weight_scale : 1.0f;
    bench->params = vw_allocate(bench->model.param_bytes, 1);
    model_initialise(&bench->model, c->seed, bench->params);
    size_t grid = bench->model.grid.size_bytes / sizeof(float), all = bench->model.param_bytes / sizeof(float);
    for (size_t i = 0; i < grid; i++) bench->params[i] = grid_scale * test_random_next(&random);
    for (size_t i = grid; i < all; i++) bench->params[i] *= weight_scale;
}

static void make_pixels(struct step_bench *bench) {
    uint32_t rays = bench->config.rays;
    bench->pixels = vw_allocate(rays, sizeof *bench->pixels);
    pixels_draw(bench->scene, 0, bench->config.seed, 1, 0, rays / 2, bench->pixels);
    pixels_draw(bench->scene, 1, bench->config.seed, 2, 0, rays - rays / 2, bench->pixels + rays / 2);
}

static struct step_bench *open_benches[32]; // so that a failed test's objects can be destroyed before the device

static void list_open(struct step_bench *bench) {
    size_t i = 0;
    while (i < VW_ARRAY_COUNT(open_benches) && open_benches[i]) i++;
    assert_true(i < VW_ARRAY_COUNT(open_benches));
    open_benches[i] = bench;
}

static void describe(struct step_bench *bench, const struct step_case *c) {
    snprintf(bench->where, sizeof bench->where, "case \"%s\", seed %llu", c->name, (unsigned long long)c->seed);
    bench->scene = synthetic_scene(&(struct synthetic_scene_params){
        .train_views = 2, .val_views = 1, .width_px = 24, .height_px = 20, .k1 = c->distortion ? -0.15 : 0.0, .alpha = c->background});
    struct vw_effect_verdict verdicts[VW_EFFECT_COUNT_MAX];
    uint32_t count;
    stop_unless(bench, vw_config_check(&bench->config));
    stop_unless(bench, vw_effects_decide(NULL, bench->scene, bench->config.effects, verdicts, &count));
    stop_unless(bench, model_create(&bench->config, bench->scene, verdicts, vw_gpu_get_info(bench->gpu), vw_gpu_get_limits(bench->gpu),
                                    &bench->model));
    bench->padded_samples = model_pad_rays(&bench->model, bench->config.rays) * bench->config.samples;
    override_model(c, bench);
    make_params(c, bench);
    make_pixels(bench);
}

static struct step_bench *open_on(struct vw_gpu *gpu, bool owns_gpu, const struct step_case *c) {
    struct step_bench *bench = vw_allocate(1, sizeof *bench);
    *bench = (struct step_bench){.gpu = gpu, .owns_gpu = owns_gpu, .config = make_config(c)};
    list_open(bench);
    describe(bench, c);
    uint64_t pixel_bytes = bench->config.rays * sizeof *bench->pixels;
    stop_unless(bench, field_create(gpu, &bench->model, bench->scene, c->seed, &bench->field));
    stop_unless(bench,
                vw_buffer_create(gpu, &(struct vw_buffer_params){.name = "pixels", .size_bytes = pixel_bytes, .home = VW_BUFFER_UPLOAD},
                                 &bench->pixel_buffer));
    memcpy(vw_buffer_map(bench->pixel_buffer), bench->pixels, pixel_bytes);
    stop_unless(bench, vw_buffer_create(gpu, &(struct vw_buffer_params){.name = "scalars", .size_bytes = 64}, &bench->scalars));
    stop_unless(bench, step_create(&bench->field, &bench->config, bench->pixel_buffer, bench->scalars, &bench->step));
    stop_unless(bench, vw_batch_create(gpu, &bench->batch));
    step_bench_write_params(bench);
    return bench;
}

struct step_bench *step_bench_open(const struct step_case *c) {
    return open_on(test_gpu(), false, c);
}

struct step_bench *step_bench_open_clamped(const struct step_case *c, const struct vw_gpu_limits *clamp) {
    struct vw_gpu *gpu = NULL;
    if (vw_gpu_open(&(struct vw_gpu_params){.validation = true, .clamp = clamp}, &gpu)) fail_msg("%s", vw_error_message());
    return open_on(gpu, true, c);
}

struct evaluator *step_bench_evaluator(struct step_bench *bench) {
    if (bench->evaluator.field) return &bench->evaluator;
    stop_unless(bench, evaluator_create(&bench->field, bench->step.padded_rays, &bench->evaluator));
    return &bench->evaluator;
}

static enum vw_status destroy(struct step_bench *bench) {
    evaluator_destroy(&bench->evaluator);
    vw_batch_destroy(&bench->batch);
    step_destroy(&bench->step);
    field_destroy(&bench->field);
    vw_buffer_destroy(&bench->pixel_buffer);
    vw_buffer_destroy(&bench->scalars);
    vw_scene_close(&bench->scene);
    free(bench->pixels);
    free(bench->params);
    enum vw_status status = bench->owns_gpu ? vw_gpu_close(&bench->gpu) : VW_OK;
    free(bench);
    return status;
}

void step_bench_close(struct step_bench *bench) {
    char where[sizeof bench->where];
    memcpy(where, bench->where, sizeof where);
    for (size_t i = 0; i < VW_ARRAY_COUNT(open_benches); i++)
        if (open_benches[i] == bench) open_benches[i] = NULL;
    if (destroy(bench)) fail_msg("%s: %s", where, vw_error_message());
    if (guard_bands_broken()) fail_msg("%s: guard bands were written to, see stderr", where);
}

int step_bench_teardown(void **state) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(open_benches); i++) {
        if (open_benches[i]) destroy(open_benches[i]);
        open_benches[i] = NULL;
    }
    return test_gpu_close(state);
}

void step_bench_write_params(struct step_bench *bench) { step_bench_write(bench, bench->field.params, bench->params); }

void step_bench_submit(struct step_bench *bench) {
    stop_unless(bench, vw_batch_submit(bench->batch));
    stop_unless(bench, vw_batch_wait(bench->batch));
}

struct vw_push_samples step_bench_push(const struct step_bench *bench, uint64_t number) {
    return (struct vw_push_samples){
        .ray_count = bench->step.padded_rays, .step_low = (uint32_t)number, .step_high = (uint32_t)(number >> 32)};
}

// The first part of step_record, for a step in one chunk.
void step_bench_gradients(struct step_bench *bench, uint64_t number) {
    const struct step_passes *step = &bench->step;
    const struct model *model = &bench->model;
    uint32_t samples = bench->padded_samples;
    assert_int_equal(model->specialization.chunk_samples, samples);
    struct vw_push_rays rays = {.ray_count = bench->config.rays};
    struct vw_push_samples push = step_bench_push(bench, number);
    struct vw_push_reduce loss = {.count = step->padded_rays};
    vw_batch_begin(bench->batch);
    vw_batch_dispatch(bench->batch, step->generate, &rays, sizeof rays, step->padded_rays);
    vw_batch_dispatch(bench->batch, step->forward, &push, sizeof push, samples);
    vw_batch_dispatch(bench->batch, step->backward_rays, &push, sizeof push, step->padded_rays);
    vw_batch_dispatch(bench->batch, step->backward_field, NULL, 0, samples);
    vw_batch_dispatch(bench->batch, step->gradient_weights, &push, sizeof push, (uint64_t)samples / VW_SLICE_SAMPLES * model->weight_tiles);
    vw_batch_dispatch(bench->batch, step->reduce_weights, &push, sizeof push, model->weight_columns);
    for (uint32_t i = 0; i < model->window_count; i++) {
        const struct grid_window *window = &model->windows[i];
        struct vw_push_scatter scatter = {.sample_count = samples,
                                          .first_level = window->first_level,
                                          .level_count = window->level_count,
                                          .first_pair = window->first_pair};
        vw_batch_dispatch(bench->batch, step->scatter[i], &scatter, sizeof scatter, (uint64_t)samples * window->level_count);
    }
    vw_batch_dispatch(bench->batch, step->reduce_loss, &loss, sizeof loss, 1);
    step_bench_submit(bench);
}

void step_bench_step(struct step_bench *bench, uint64_t number) {
    vw_batch_begin(bench->batch);
    step_record(&bench->step, bench->batch, number, 0, 0);
    step_bench_submit(bench);
}

void step_bench_dispatch(struct step_bench *bench, const struct vw_pass *pass, const void *push, size_t push_bytes, uint64_t invocations) {
    vw_batch_begin(bench->batch);
    vw_batch_dispatch(bench->batch, pass, push, push_bytes, invocations);
    step_bench_submit(bench);
}

void *step_bench_read(struct step_bench *bench, struct vw_buffer *buffer) {
    uint64_t size_bytes = vw_buffer_size_bytes(buffer);
    void *data = vw_allocate(size_bytes, 1);
    stop_unless(bench, vw_buffer_read(buffer, 0, data, size_bytes));
    return data;
}

void step_bench_write(struct step_bench *bench, struct vw_buffer *buffer, const void *data) {
    stop_unless(bench, vw_buffer_write(buffer, 0, data, vw_buffer_size_bytes(buffer)));
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
    rows.d_encoding = rows.d_logit + 1;
    rows.position = rows.d_encoding + encoding4;
    rows.count = rows.position + 1;
    return rows;
}

const float *step_bench_row(const struct step_bench *bench, const float *rows, uint32_t row, uint32_t sample) {
    return rows + 4 * ((size_t)row * VW_ROW_STRIDE(bench->model.specialization.chunk_samples) + sample);
}

void check_value(const char *where, const char *what, uint64_t index, double device, double expected, double tolerance) {
    if (fabs(device - expected) <= tolerance) return;
    fail_msg("%s: %s[%llu] is %.9g on the device, %.9g by the twin: off by %.3g, more than %.3g", where, what, (unsigned long long)index,
             device, expected, fabs(device - expected), tolerance);
}

void check_same_bits(const char *where, const char *what, const void *device, const void *expected, size_t size_bytes) {
    const unsigned char *a = device, *b = expected;
    for (size_t i = 0; i < size_bytes; i++)
        if (a[i] != b[i]) fail_msg("%s: %s differs at byte %zu of %zu", where, what, i, size_bytes);
}

double largest(const double *values, size_t count) {
    double most = 0.0;
    for (size_t i = 0; i < count; i++) most = fmax(most, fabs(values[i]));
    return most;
}

float test_random_next(struct test_random *random) {
    uint32_t words[4];
    vw_random_words(random->seed, VW_RANDOM_INITIALISATION, 1, random->drawn++, 0, words);
    return 2.0f * vw_random_unit(words[0]) - 1.0f;
}
