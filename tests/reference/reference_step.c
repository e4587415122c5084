#include "reference.h"
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "train/effects/effects.h"
#include "train/fields/registry.h"

struct reference_params *reference_params_create(const struct vw_model *model, const float *params) {
    struct reference_params *reference = test_allocate(1, sizeof *reference);
    size_t features = model->config->field == VW_FIELD_SPLATS ? 0 : 2 * (size_t)vw_volume_of(model)->pair_count;
    reference->grid = test_allocate(features, sizeof *reference->grid);
    for (size_t i = 0; i < features; i++) reference->grid[i] = params[i];
    reference_weights_from_blocks(&model->specialization, params + model->weights.offset_bytes / sizeof *params,
                                  &reference->weights);
    reference_sky_read(model, params, reference->sky);
    uint32_t photos = reference_photo_count(model);
    if (photos) reference->photos = test_allocate(photos, sizeof *reference->photos);
    for (uint32_t i = 0; i < photos; i++) reference->photos[i] = reference_photo_of(model, params, i);
    for (size_t i = 0; i < model->ranges[VW_SLOT_CODE_WEIGHTS].size_bytes / sizeof *params; i++)
        reference->code_weights[i] = params[model->ranges[VW_SLOT_CODE_WEIGHTS].offset_bytes / sizeof *params + i];
    size_t codes = model->ranges[VW_SLOT_VISIBILITY_CODES].size_bytes / sizeof *params;
    for (size_t i = 0; i < REFERENCE_VISIBILITY && codes; i++)
        reference->visibility[i] = params[vw_visibility_network(model).offset_bytes / sizeof *params + i];
    if (codes) reference->visibility_codes = test_allocate(codes, sizeof(double));
    for (size_t i = 0; i < codes; i++)
        reference->visibility_codes[i / REFERENCE_VISIBILITY_CODE][i % REFERENCE_VISIBILITY_CODE] =
            params[model->ranges[VW_SLOT_VISIBILITY_CODES].offset_bytes / sizeof *params + i];
    const struct vw_param_range doubts = vw_uncertainty_network(model);
    if (doubts.size_bytes) reference->uncertainty = test_allocate(REFERENCE_UNCERTAINTY, sizeof(double));
    for (size_t i = 0; i < doubts.size_bytes / sizeof *params; i++)
        reference->uncertainty[i] = params[doubts.offset_bytes / sizeof *params + i];
    return reference;
}

struct reference_step *reference_step_create(const struct vw_model *model, const struct vw_ray *rays,
                                             uint32_t ray_count) {
    struct reference_step *step = test_allocate(1, sizeof *step);
    size_t samples = (size_t)ray_count * model->specialization.samples;
    *step = (struct reference_step){.model = model, .ray_count = ray_count};
    step->rays = test_allocate(ray_count, sizeof *step->rays);
    step->samples = test_allocate(samples, sizeof *step->samples);
    step->d_samples = test_allocate(samples, sizeof *step->d_samples);
    step->colours = test_allocate(ray_count, sizeof *step->colours);
    step->backdrops = test_allocate(ray_count, sizeof *step->backdrops);
    step->left = test_allocate(ray_count, sizeof *step->left);
    step->errors = test_allocate(ray_count, sizeof *step->errors);
    step->losses = test_allocate(ray_count, sizeof *step->losses);
    step->places = test_allocate(ray_count, sizeof *step->places);
    step->features = test_allocate(ray_count, sizeof *step->features);
    step->visible = test_allocate(ray_count, sizeof *step->visible);
    step->d_grid = test_allocate(2 * (size_t)vw_volume_of(model)->pair_count, sizeof *step->d_grid);
    for (uint32_t i = 0; i < ray_count; i++) step->rays[i] = reference_ray_of(&rays[i]);
    return step;
}

static void list_points(const struct reference_step *step, uint32_t ray, struct reference_point *points) {
    const struct vw_specialization *s = &step->model->specialization;
    const struct reference_sample *samples = &step->samples[(size_t)ray * s->samples];
    for (uint32_t i = 0; i < s->samples; i++) {
        memcpy(points[i].rgb, samples[i].rgb, sizeof points[i].rgb);
        points[i].density = samples[i].density;
        points[i].length =
            step->sample_places
                ? reference_listed_length(s, &step->rays[ray], &step->sample_places[(size_t)ray * s->samples], i)
                : reference_stratum_length(s, &step->rays[ray], i);
    }
}

// Returns what it costs that a ray counts so much, and its slope.
static double weight_cost(const struct reference_step *step, double weight, double *slope) {
    double hidden = 1.0 - weight;
    if (step->model->specialization.effect_uncertainty) {
        double certain = fmax(weight, 1e-30);
        *slope = -step->certain_loss / certain;
        return -step->certain_loss * log(certain);
    }
    *slope = -2.0 * step->size_weight * hidden;
    return hidden != 0.0 ? step->size_weight * hidden * hidden : 0.0;
}

static void forward_ray(struct reference_step *step, uint32_t index, struct reference_point *points) {
    const struct vw_specialization *s = &step->model->specialization;
    const struct reference_ray *ray = &step->rays[index];
    double unused;
    list_points(step, index, points);
    step->left[index] = reference_composite(points, s->samples, step->backdrops[index], step->colours[index]);
    double loss = 0.0;
    for (int c = 0; c < 3; c++) {
        step->errors[index][c] = step->colours[index][c] - ray->target[c];
        loss += ray->weight / 3.0 * reference_loss(s, step->errors[index][c], &unused);
    }
    step->losses[index] = step->visible[index] * loss + ray->weight * weight_cost(step, step->visible[index], &unused);
    step->loss += step->losses[index];
}

// Returns the weights as the step's photo sees them.
static struct reference_weights *mix_weights(const struct reference_step *step, const struct reference_params *params,
                                             bool training) {
    struct reference_weights *mixed = vw_allocate(1, sizeof *mixed);
    double shift[REFERENCE_WIDTH_MAX] = {0};
    uint32_t width = 4 * step->model->specialization.width4;
    *mixed = params->weights;
    if (training && params->photos)
        reference_mix_code(width, params->code_weights, params->photos[step->view].code, shift);
    for (uint32_t i = 0; i < width; i++) mixed->colour1[i * REFERENCE_COLOUR_IN] += shift[i];
    return mixed;
}

void reference_step_forward(struct reference_step *step, const struct reference_params *params, bool training,
                            uint64_t number) {
    struct vw_specialization s = step->model->specialization;
    vw_uint4 key = vw_model_key_of_step(step->model, number);
    struct reference_point *points = vw_allocate(s.samples, sizeof *points);
    struct reference_weights *weights = mix_weights(step, params, training);
    s.training = training;
    step->loss = 0.0;
    step->size_weight = reference_size_weight(&s, number);
    step->certain_loss = reference_certain_loss(&s, number);
    for (uint32_t ray = 0; ray < step->ray_count; ray++) {
        for (uint32_t i = 0; i < s.samples; i++) {
            struct reference_sample *sample = &step->samples[(size_t)ray * s.samples + i];
            double place = step->sample_places ? step->sample_places[(size_t)ray * s.samples + i]
                                               : i + reference_stratum_offset(&s, ray, i, key);
            reference_position_at(&s, &step->rays[ray], place, sample->position);
            memcpy(sample->direction, step->rays[ray].direction, sizeof sample->direction);
            reference_grid_encode(&s, params->grid, sample->position, sample->encoding);
            reference_networks_forward(&s, weights, sample);
        }
        step->visible[ray] =
            training && params->visibility_codes
                ? reference_visibility(params->visibility, params->visibility_codes[step->view], step->places[ray])
                : 1.0;
        if (training && params->uncertainty)
            step->visible[ray] = reference_certainty(params->uncertainty, step->features[ray]);
        reference_backdrop(&s, params->sky, step->rays[ray].direction, ray, key, step->backdrops[ray]);
        forward_ray(step, ray, points);
    }
    free(points);
    free(weights);
}

// Propagates the gradient by how much a ray counts to the network that says so, and to the photo's code.
static void weight_backward(struct reference_step *step, const struct reference_params *params, uint32_t ray) {
    double d_weight, unused;
    weight_cost(step, step->visible[ray], &d_weight);
    for (int c = 0; c < 3; c++)
        d_weight += reference_loss(&step->model->specialization, step->errors[ray][c], &unused) / 3.0;
    d_weight *= step->rays[ray].weight;
    if (params->uncertainty)
        reference_certainty_gradient(params->uncertainty, step->features[ray], d_weight, step->d_uncertainty);
    else
        reference_visibility_gradient(params->visibility, params->visibility_codes[step->view], step->places[ray],
                                      d_weight, step->d_visibility, step->d_visibility_code);
}

void reference_step_backward(struct reference_step *step, const struct reference_params *params) {
    const struct vw_specialization *s = &step->model->specialization;
    struct reference_point *points = vw_allocate(s->samples, sizeof *points);
    struct reference_d_point *d_points = vw_allocate(s->samples, sizeof *d_points);
    double d_shift[REFERENCE_WIDTH_MAX];
    memset(step->d_sky, 0, sizeof step->d_sky);
    memset(step->d_code, 0, sizeof step->d_code);
    memset(&step->d_weights, 0, sizeof step->d_weights);
    memset(step->d_visibility, 0, sizeof step->d_visibility);
    memset(step->d_uncertainty, 0, sizeof step->d_uncertainty);
    memset(step->d_visibility_code, 0, sizeof step->d_visibility_code);
    memset(step->d_grid, 0, 2 * (size_t)vw_volume_of(step->model)->pair_count * sizeof *step->d_grid);
    for (uint32_t ray = 0; ray < step->ray_count; ray++) {
        struct reference_sample *samples = &step->samples[(size_t)ray * s->samples];
        struct reference_d_sample *d_samples = &step->d_samples[(size_t)ray * s->samples];
        double d_colour[3], d_logit[3];
        for (int c = 0; c < 3; c++) {
            reference_loss(s, step->errors[ray][c], &d_colour[c]);
            d_colour[c] *= step->visible[ray] * step->rays[ray].weight / 3.0;
        }
        if (params->visibility_codes || params->uncertainty) weight_backward(step, params, ray);
        list_points(step, ray, points);
        reference_composite_gradient(points, s->samples, step->backdrops[ray], d_colour, d_points);
        reference_sky_d_logit(step->backdrops[ray], step->left[ray], d_colour, d_logit);
        reference_sky_gradient(step->rays[ray].direction, d_logit, step->d_sky);
        for (uint32_t i = 0; i < s->samples; i++) {
            reference_networks_backward(s, &params->weights, &samples[i], d_points[i].rgb, d_points[i].raw,
                                        &d_samples[i]);
            reference_weights_gradient(s, &samples[i], &d_samples[i], &step->d_weights);
            reference_grid_scatter(s, samples[i].position, d_samples[i].encoding, step->d_grid);
        }
    }
    free(points);
    free(d_points);
    if (!params->photos) return;
    for (uint32_t i = 0; i < 4 * s->width4; i++) d_shift[i] = step->d_weights.colour1[i * REFERENCE_COLOUR_IN];
    reference_mix_code_gradient(4 * s->width4, params->code_weights, params->photos[step->view].code, d_shift,
                                step->d_code_weights, step->d_code);
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
        const vw_uint4 *words = &bits[i];
        wrong +=
            adopt((const uint32_t[2]){words->x, words->y}, 4 * s->width4, sample->before1, sample->active1, tolerance);
        wrong +=
            adopt((const uint32_t[2]){words->z, words->w}, 4 * s->width4, sample->before2, sample->active2, tolerance);
    }
    return wrong;
}
