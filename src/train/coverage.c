#include "train/coverage.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/random.h"
#include "train/pixels.h"

// ---- From information to coverage -----------------------------------------------------------------------------------

const double coverage_prior_share = 0.1;

double vw_coverage_prior(const double *total, uint64_t count) {
    double sum = 0.0, informed = 0.0;
    for (uint64_t i = 0; i < count; i++) {
        sum += total[i];
        informed += total[i] > 0.0;
    }
    return informed > 0.0 ? coverage_prior_share * sum / informed : 1.0;
}

double vw_coverage_of(const double *total, const double *own, uint64_t count, double prior) {
    double coverage = 0.0;
    for (uint64_t i = 0; i < count; i++)
        if (own[i] > 0.0) coverage -= log1p(-own[i] / (prior + total[i]));
    return coverage;
}

// ---- Information, on the device -------------------------------------------------------------------------------------

struct measuring {
    const struct vw_probe_context *context;
    uint32_t passes;
    struct vw_gradient_passes gradient; // of slopes that are given
    struct vw_submission *batch;
    uint64_t words_bytes, entries;
    struct vw_buffer *of_device; // the grid's gradient; of a field without one, the weights'
    uint64_t *words, *zeros;     // the former as the device has it
    double *own, *total;         // information by entry
};

static enum vw_status prepare(struct measuring *measuring) {
    const struct vw_step_passes *step = measuring->context->step;
    const struct vw_model *model = step->field->model;
    struct vw_specialization given = model->specialization;
    given.loss = LOSS_GIVEN;
    given.effect_occupancy = 0; // a field that was loaded has none
    measuring->of_device = step->d_grid ? step->d_grid : step->d_weights;
    measuring->entries = step->d_grid ? 2 * (uint64_t)model->pair_count : 4 * (uint64_t)model->weight_columns;
    measuring->words_bytes = vw_buffer_size_bytes(measuring->of_device);
    measuring->words = vw_allocate(measuring->words_bytes, 1);
    measuring->zeros = vw_allocate(measuring->words_bytes, 1);
    measuring->own = vw_allocate(measuring->entries, sizeof *measuring->own);
    measuring->total = vw_allocate(measuring->entries, sizeof *measuring->total);
    if (!measuring->words || !measuring->zeros || !measuring->own || !measuring->total) return VW_ERROR_MEMORY;
    enum vw_status status = vw_gradient_create(step, &given, &measuring->gradient);
    return !status ? vw_submission_create(step->field->gpu, &measuring->batch) : status;
}

static void clean_up(struct measuring *measuring) {
    vw_submission_destroy(&measuring->batch);
    vw_gradient_destroy(&measuring->gradient);
    free(measuring->words);
    free(measuring->zeros);
    free(measuring->own);
    free(measuring->total);
}

// Signs in place of the pixels' colours. They and the pixels' places are the same for all photos.
static void draw_signs(const struct measuring *measuring, uint32_t view, uint32_t pass) {
    const struct vw_probe_context *context = measuring->context;
    uint64_t seed = vw_config_seed_of(context->config, VW_VARY_PIXELS);
    struct vw_pixel *pixels = vw_buffer_map(context->pixels);
    vw_pixels_draw(context->scene, view, &(struct vw_pixel_draw){seed, .draw = pass}, context->config->rays, pixels);
    if (!context->masks) vw_pixels_unmask(context->scene, pixels, context->config->rays);
    for (uint32_t ray = 0; ray < context->config->rays; ray++) {
        uint32_t words[4];
        vw_random_words(seed, VW_RANDOM_SIGN, pass, ray, 0, words);
        pixels[ray].rgba = (vw_float4){words[0] >> 31 ? 1.0f : -1.0f, words[1] >> 31 ? 1.0f : -1.0f,
                                       words[2] >> 31 ? 1.0f : -1.0f, 1.0f};
    }
}

static enum vw_status take_gradient(struct measuring *measuring, uint32_t pass) {
    const struct vw_step_passes *step = measuring->context->step;
    const struct vw_push_rays rays = {.ray_count = step->rays, .key = vw_model_key_of_step(step->field->model, pass)};
    vw_submission_begin(measuring->batch);
    vw_submission_dispatch(measuring->batch, measuring->gradient.generate, &rays, sizeof rays, step->padded_rays);
    vw_effects_record_photo(step->field->model, &step->effects, measuring->batch, 0);
    for (uint32_t first = 0; first < step->padded_rays; first += step->chunk_rays) {
        const struct vw_push_samples chunk = vw_gradient_chunk(step, step->padded_rays, first, rays.key);
        vw_gradient_record_chunk(step, &measuring->gradient, measuring->batch, &chunk);
    }
    enum vw_status status = vw_submission_submit(measuring->batch);
    if (!status) status = vw_submission_wait(measuring->batch);
    if (!status) status = vw_buffer_read(measuring->of_device, 0, measuring->words, measuring->words_bytes);
    return !status ? vw_buffer_write(measuring->of_device, 0, measuring->zeros, measuring->words_bytes) : status;
}

// shaders/fixed_point.glsl
static double quanta_of(const struct measuring *measuring, uint64_t entry) {
    if (measuring->context->field->model->specialization.wide_gradient) return (double)(int64_t)measuring->words[entry];
    uint64_t word = measuring->words[entry / 2];
    int64_t first = (int32_t)(uint32_t)word;
    return entry % 2 == 0 ? (double)first : (double)(int32_t)(uint32_t)((word - (uint64_t)first) >> 32);
}

// Of the sum over rays.
static double gradient_of(const struct measuring *measuring, uint64_t entry) {
    const struct vw_step_passes *step = measuring->context->step;
    if (!step->d_grid) return ((const float *)measuring->words)[entry];
    return step->field->model->specialization.gradient_quantum * quanta_of(measuring, entry);
}

// Fills `own`.
static enum vw_status take_information(struct measuring *measuring, uint32_t view) {
    memset(measuring->own, 0, measuring->entries * sizeof *measuring->own);
    for (uint32_t pass = 0; pass < measuring->passes; pass++) {
        draw_signs(measuring, view, pass);
        enum vw_status status = take_gradient(measuring, pass);
        if (status) return status;
        for (uint64_t i = 0; i < measuring->entries; i++) {
            double gradient = 3.0 * gradient_of(measuring, i); // the passes take a third of a ray's slopes
            measuring->own[i] += gradient * gradient / measuring->passes;
        }
    }
    return VW_OK;
}

// Every photo's information is taken twice, since there is no room for that of all photos.
enum vw_status vw_coverage_measure(const struct vw_probe_context *context, uint32_t passes, double *coverage) {
    struct measuring measuring = {.context = context, .passes = passes};
    const struct vw_photo_order *schedule = context->schedule;
    enum vw_status status = vw_scene_decode(context->scene, schedule->train_views, schedule->train_count);
    if (!status) status = prepare(&measuring);
    for (uint32_t i = 0; i < schedule->train_count && !status; i++) {
        status = take_information(&measuring, schedule->train_views[i]);
        for (uint64_t k = 0; k < measuring.entries && !status; k++) measuring.total[k] += measuring.own[k];
    }
    double prior = !status ? vw_coverage_prior(measuring.total, measuring.entries) : 1.0;
    for (uint32_t i = 0; i < schedule->train_count && !status; i++) {
        status = take_information(&measuring, schedule->train_views[i]);
        if (!status) coverage[i] = vw_coverage_of(measuring.total, measuring.own, measuring.entries, prior);
    }
    clean_up(&measuring);
    return status;
}
