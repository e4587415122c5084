#include "reference.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "viewworth/memory.h"

struct reference_params *reference_params_create(const struct model *model, const float *params) {
    struct reference_params *twin = vw_allocate(1, sizeof *twin);
    twin->grid = vw_allocate(2 * (size_t)model->pair_count, sizeof *twin->grid);
    for (size_t i = 0; i < 2 * (size_t)model->pair_count; i++) twin->grid[i] = params[i];
    reference_weights_from_blocks(&model->specialization, params + model->weights.offset_bytes / sizeof *params, &twin->weights);
    return twin;
}

void reference_params_destroy(struct reference_params *params) {
    if (params) free(params->grid);
    free(params);
}

struct reference_step *reference_step_create(const struct model *model, const struct vw_ray *rays, uint32_t ray_count) {
    struct reference_step *step = vw_allocate(1, sizeof *step);
    size_t samples = (size_t)ray_count * model->specialization.samples;
    *step = (struct reference_step){.model = model, .ray_count = ray_count};
    step->rays = vw_allocate(ray_count, sizeof *step->rays);
    step->samples = vw_allocate(samples, sizeof *step->samples);
    step->d_samples = vw_allocate(samples, sizeof *step->d_samples);
    step->slots = vw_allocate(samples, sizeof *step->slots);
    for (size_t i = 0; i < samples; i++) step->slots[i] = (uint32_t)i;
    step->colours = vw_allocate(ray_count, sizeof *step->colours);
    step->left = vw_allocate(ray_count, sizeof *step->left);
    step->errors = vw_allocate(ray_count, sizeof *step->errors);
    step->losses = vw_allocate(ray_count, sizeof *step->losses);
    step->d_grid = vw_allocate(2 * (size_t)model->pair_count, sizeof *step->d_grid);
    for (uint32_t i = 0; i < ray_count; i++) step->rays[i] = reference_ray_of(&rays[i]);
    return step;
}

void reference_step_destroy(struct reference_step *step) {
    if (!step) return;
    free(step->rays);
    free(step->samples);
    free(step->d_samples);
    free(step->slots);
    free(step->colours);
    free(step->left);
    free(step->errors);
    free(step->losses);
    free(step->d_grid);
    free(step);
}

// Of a ray. What is skipped has no density, and so no gradient either.
static void list_points(const struct reference_step *step, uint32_t ray, struct reference_point *points) {
    uint32_t count = step->model->specialization.samples;
    const struct reference_sample *samples = &step->samples[(size_t)ray * count];
    const uint32_t *slots = &step->slots[(size_t)ray * count];
    for (uint32_t i = 0; i < count; i++) {
        memcpy(points[i].rgb, samples[i].rgb, sizeof points[i].rgb);
        points[i].density = slots[i] == REFERENCE_SKIPPED ? 0.0 : samples[i].density;
    }
}

static void forward_ray(struct reference_step *step, uint32_t index, const double background[3], struct reference_point *points) {
    const struct vw_specialization *s = &step->model->specialization;
    const struct reference_ray *ray = &step->rays[index];
    double unused;
    list_points(step, index, points);
    step->left[index] = reference_composite(points, s->samples, ray->stride, background, step->colours[index]);
    step->losses[index] = 0.0;
    for (int c = 0; c < 3; c++) {
        step->errors[index][c] = step->colours[index][c] - ray->target[c];
        step->losses[index] += ray->weight / 3.0 * reference_loss(s->loss, step->errors[index][c], &unused);
    }
    step->loss += step->losses[index];
}

void reference_step_forward(struct reference_step *step, const struct reference_params *params, bool training, uint64_t number) {
    struct vw_specialization s = step->model->specialization;
    struct reference_point *points = vw_allocate(s.samples, sizeof *points);
    double background[3];
    s.training = training;
    reference_background(&s, background);
    step->loss = 0.0;
    for (uint32_t ray = 0; ray < step->ray_count; ray++) {
        for (uint32_t i = 0; i < s.samples; i++) {
            struct reference_sample *sample = &step->samples[(size_t)ray * s.samples + i];
            reference_sample_position(&step->rays[ray], i, reference_stratum_offset(&s, ray, i, number), sample->position);
            memcpy(sample->direction, step->rays[ray].direction, sizeof sample->direction);
            reference_grid_encode(&s, params->grid, sample->position, sample->encoding);
            reference_networks_forward(&s, &params->weights, sample);
        }
        forward_ray(step, ray, background, points);
    }
    free(points);
}

void reference_step_backward(struct reference_step *step, const struct reference_params *params) {
    const struct vw_specialization *s = &step->model->specialization;
    struct reference_point *points = vw_allocate(s->samples, sizeof *points);
    struct reference_d_point *d_points = vw_allocate(s->samples, sizeof *d_points);
    double background[3];
    reference_background(s, background);
    memset(&step->d_weights, 0, sizeof step->d_weights);
    memset(step->d_grid, 0, 2 * (size_t)step->model->pair_count * sizeof *step->d_grid);
    for (uint32_t ray = 0; ray < step->ray_count; ray++) {
        struct reference_sample *samples = &step->samples[(size_t)ray * s->samples];
        struct reference_d_sample *d_samples = &step->d_samples[(size_t)ray * s->samples];
        double d_colour[3];
        for (int c = 0; c < 3; c++) {
            reference_loss(s->loss, step->errors[ray][c], &d_colour[c]);
            d_colour[c] *= step->rays[ray].weight / 3.0;
        }
        list_points(step, ray, points);
        reference_composite_gradient(points, s->samples, step->rays[ray].stride, background, d_colour, d_points);
        for (uint32_t i = 0; i < s->samples; i++) {
            reference_networks_backward(s, &params->weights, &samples[i], d_points[i].rgb, d_points[i].raw, &d_samples[i]);
            reference_weights_gradient(s, &samples[i], &d_samples[i], &step->d_weights);
            reference_grid_scatter(s, samples[i].position, d_samples[i].encoding, step->d_grid);
        }
    }
    free(points);
    free(d_points);
}

static uint64_t adopt(const uint32_t words[2], uint32_t count, const double *before, bool *active, double tolerance) {
    uint64_t wrong = 0;
    for (uint32_t i = 0; i < count; i++) {
        bool on = words[i / 32] >> i % 32 & 1;
        wrong += on != active[i] && !(fabs(before[i]) <= tolerance);
        active[i] = on;
    }
    return wrong;
}

uint64_t reference_adopt_gates(struct reference_step *step, const vw_uint4 *bits, double tolerance) {
    const struct vw_specialization *s = &step->model->specialization;
    uint64_t wrong = 0;
    for (size_t i = 0; i < (size_t)step->ray_count * s->samples; i++) {
        struct reference_sample *sample = &step->samples[i];
        if (step->slots[i] == REFERENCE_SKIPPED) continue;
        const vw_uint4 *words = &bits[step->slots[i]];
        wrong += adopt((const uint32_t[2]){words->x, words->y}, 4 * s->width4, sample->before1, sample->active1, tolerance);
        wrong += adopt((const uint32_t[2]){words->z, words->w}, 4 * s->width4, sample->before2, sample->active2, tolerance);
    }
    return wrong;
}
