#include "train/pass_costs.h"

#include <assert.h>
#include <string.h>

#include "train/effects/appearance_encoder.h"
#include "train/effects/consistency.h"
#include "train/effects/visibility_network.h"

// Multiply-adds of all convolutions of the effect appearance_encoder.
#define ENCODER_PRODUCTS                                                                                               \
    (16.0 * ENCODER_TAPS * ENCODER4 *                                                                                  \
     (THUMBNAIL_PIXELS / 4 + ENCODER4 * (THUMBNAIL_PIXELS / 16 + THUMBNAIL_PIXELS / 64)))

// Per sample, and sizes of the model; those of the grid are of the field hash.
struct sizes {
    double samples, rays, encoding4, width4, gathers, pairs, pair_bytes;
};

static struct sizes sizes_of(const struct vw_model *model, uint32_t rays) {
    const struct vw_specialization *s = &model->specialization;
    uint32_t encoding4 = s->levels * s->feature_pairs / 2;
    return (struct sizes){.samples = (double)rays * s->samples,
                          .rays = rays,
                          .encoding4 = encoding4,
                          .width4 = s->width4,
                          .gathers = 8.0 * s->levels * s->feature_pairs,
                          .pairs = model->pair_count,
                          .pair_bytes = model->pair_bytes};
}

void vw_pass_cost_add(struct vw_pass_cost *costs, uint32_t *count, struct vw_pass_cost cost) {
    for (uint32_t i = 0; i < *count; i++) {
        bool same_role = costs[i].role == cost.role; // roles are static texts
        if (!same_role || strcmp(costs[i].name, cost.name) != 0) continue;
        costs[i].dispatches += cost.dispatches;
        costs[i].multiply_adds += cost.multiply_adds;
        costs[i].bytes += cost.bytes;
        return;
    }
    assert(*count < VW_PASS_COSTS_MAX);
    costs[(*count)++] = cost;
}

static void add_skipping(const struct sizes *n, uint32_t chunks, struct vw_pass_cost *costs, uint32_t *count) {
    vw_pass_cost_add(
        costs, count,
        (struct vw_pass_cost){"mark_samples", NULL, chunks, 0, n->rays * sizeof(struct vw_ray) + 4 * n->samples});
    vw_pass_cost_add(costs, count, (struct vw_pass_cost){"place_rays", NULL, chunks, 0, 12 * n->rays});
    vw_pass_cost_add(costs, count,
                     (struct vw_pass_cost){"list_samples", NULL, chunks, 0, 4 * n->rays + 4 * n->samples});
}

static void add_occupancy(const struct sizes *n, uint32_t chunks, struct vw_pass_cost *costs, uint32_t *count) {
    const double refreshes = 1.0 / OCCUPANCY_STEPS, cells = refreshes * VW_OCCUPANCY_CELLS;
    vw_pass_cost_add(costs, count,
                     (struct vw_pass_cost){"refresh_occupancy", NULL, refreshes,
                                           cells * (16 * n->width4 * (n->encoding4 + 1) + 2 * n->gathers),
                                           cells * (n->pair_bytes * n->gathers + 8)});
    add_skipping(n, chunks, costs, count);
}

static void add_sky(const struct sizes *n, struct vw_pass_cost *costs, uint32_t *count) {
    vw_pass_cost_add(costs, count,
                     (struct vw_pass_cost){"gradient_sky", NULL, 1, n->rays * 4 * VW_SKY_COLUMNS,
                                           n->rays * VW_SKY_COLUMNS * (sizeof(struct vw_ray) + 16)});
}

static void add_visibility(const struct sizes *n, struct vw_pass_cost *costs, uint32_t *count) {
    double network = VISIBILITY_NETWORK_PARAMS + 16 * VISIBILITY4 * VISIBILITY_CODE4,
           groups = n->rays / VISIBILITY_GROUP, columns = 16.0 * VISIBILITY_COLUMNS,
           pixels = n->rays * (sizeof(struct vw_pixel) + 8);
    const struct vw_pass_cost passes[] = {
        {"predict_visibility", NULL, 1, n->rays * network, pixels + n->rays / 64 * columns},
        {"gradient_visibility", NULL, 1, 3 * n->rays * network, pixels + 2 * groups * columns},
        {"reduce_visibility", NULL, 1, 0, (groups + 1) * columns},
        {"update_visibility", NULL, 1, 0, columns},
    };
    for (size_t i = 0; i < sizeof passes / sizeof *passes; i++) vw_pass_cost_add(costs, count, passes[i]);
}

// A convolution reads a block of four columns and an input per product of 16.
static void add_encoding(const struct vw_model *model, double photos, const char *role, struct vw_pass_cost *costs,
                         uint32_t *count) {
    const double products = ENCODER_PRODUCTS * photos,
                 matrices = 16.0 * CODE4 * (ENCODER4 + model->specialization.width4) * photos;
    vw_pass_cost_add(costs, count,
                     (struct vw_pass_cost){"convolve_photo", role, ENCODER_LAYERS * photos, products, 5 * products});
    vw_pass_cost_add(costs, count, (struct vw_pass_cost){"pool_photo", role, photos, matrices, 4 * matrices});
}

static void add_encoder_gradient(const struct vw_model *model, struct vw_pass_cost *costs, uint32_t *count) {
    const double all = ENCODER_PRODUCTS, behind_first = all - 16.0 * ENCODER_TAPS * ENCODER4 * (THUMBNAIL_PIXELS / 4),
                 matrices = 16.0 * CODE4 * (ENCODER4 + model->specialization.width4);
    const struct vw_pass_cost passes[] = {
        {"spread_photo", NULL, 1, 2 * matrices, 8 * matrices},
        {"convolve_photo", NULL, ENCODER_LAYERS - 1, behind_first, 5 * behind_first},
        {"gradient_photo", NULL, 1, all, 8 * all},
    };
    for (size_t i = 0; i < sizeof passes / sizeof *passes; i++) vw_pass_cost_add(costs, count, passes[i]);
}

// Of the even samples of `rays`, by which importance samples are placed. None of them has transients. `trains`: where
// there is a coarse network, it learns by them.
static void add_placing(const struct vw_model *model, double rays, uint32_t chunks, const char *role, bool trains,
                        struct vw_pass_cost *costs, uint32_t *count) {
    const struct vw_specialization *s = &model->specialization;
    if (!s->importance) return;
    struct vw_model even = *model;
    even.specialization.effect_transient = 0;
    const struct vw_field_work work = {.samples = rays * s->strata,
                                       .chunks = chunks,
                                       .role = role ? even_validation_role : even_role,
                                       .stores_rows = trains && model->coarse_columns};
    model->kind->list_forward_costs(&even, &work, costs, count);
    if (work.stores_rows) {
        vw_pass_cost_add(costs, count, (struct vw_pass_cost){"backward_rays", work.role, chunks, 0, work.samples * 56});
        model->kind->list_backward_costs(&even, &work, costs, count);
    }
    vw_pass_cost_add(costs, count,
                     (struct vw_pass_cost){"place_samples", role, chunks, 0,
                                           rays * (sizeof(struct vw_ray) + 2 * 16 * s->strata + 4 * s->samples)});
}

static void add_pose(const struct sizes *n, uint32_t chunks, struct vw_pass_cost *costs, uint32_t *count) {
    double position = sizeof(vw_float4), d_position = sizeof(vw_float4), d_encoding = 16 * n->encoding4;
    vw_pass_cost_add(
        costs, count,
        (struct vw_pass_cost){"gradient_positions", NULL, chunks, n->samples * 8 * n->gathers,
                              n->samples * (position + d_encoding + n->pair_bytes * n->gathers + d_position)});
    vw_pass_cost_add(costs, count,
                     (struct vw_pass_cost){"gradient_pose", NULL, chunks, n->samples * 9,
                                           n->samples * (position + d_position) + n->rays * sizeof(struct vw_pose)});
    vw_pass_cost_add(costs, count, (struct vw_pass_cost){"update_pose", NULL, 1, 0, n->rays * sizeof(struct vw_pose)});
}

// backward_transient reads a sample twice: 16 bytes of the field and two rows; it writes as much, and the sum of tau.
static void add_transient(const struct vw_model *model, double samples, uint32_t chunks, struct vw_pass_cost *costs,
                          uint32_t *count) {
    double code_weights = 16.0 * model->specialization.transient_width4 * TRANSIENT_CODE4;
    vw_pass_cost_add(costs, count, (struct vw_pass_cost){"backward_transient", NULL, chunks, 0, samples * 152});
    vw_pass_cost_add(costs, count, (struct vw_pass_cost){"update_transient", NULL, 1, code_weights, 4 * code_weights});
}

// Beside the field's.
static void add_picture(const struct vw_model *model, const struct sizes *n, uint32_t chunks,
                        struct vw_pass_cost *costs, uint32_t *count) {
    double pixels = 16.0 * (THUMBNAIL_PIXELS + n->rays), kernels = 4.0 * ENCODER_TAPS * ENCODER4 * THUMBNAIL_PIXELS;
    const struct vw_pass_cost passes[] = {
        {"generate_rays", NULL, 1, 0, n->rays * (sizeof(struct vw_pixel) + sizeof(struct vw_ray))},
        {"difference_rays", NULL, chunks, 0, n->samples * 16 + n->rays * (sizeof(struct vw_ray) + 16)},
        {"shrink_colours", NULL, 1, 0, pixels},
        {"spread_colours", NULL, 1, kernels, 5 * kernels + pixels},
        {"backward_rays", NULL, chunks, 0, n->samples * 56},
        {"add_gradients", NULL, 1, 0, 48.0 * model->moved_columns},
    };
    for (size_t i = 0; i < sizeof passes / sizeof *passes; i++) vw_pass_cost_add(costs, count, passes[i]);
    add_encoding(model, 2, NULL, costs, count);
    add_encoder_gradient(model, costs, count);
    if (model->sky.size_bytes) add_sky(n, costs, count);
}

// Of more than one chunk, a picture is rendered twice.
static void add_consistency(const struct vw_step_passes *step, struct vw_pass_cost *costs, uint32_t *count) {
    const struct vw_model *model = step->field->model;
    const struct sizes n = sizes_of(model, step->consistency->padded_rays);
    uint32_t chunks = (step->consistency->padded_rays + step->chunk_rays - 1) / step->chunk_rays;
    const struct vw_field_work once = {.samples = n.samples, .chunks = chunks, .stores_rows = true},
                               again = {.samples = n.samples, .chunks = chunks};
    for (uint32_t time = 0; time < (chunks > 1 ? 2 : 1); time++) {
        if (step->occupancy.kept) add_skipping(&n, chunks, costs, count);
        add_placing(model, n.rays, chunks, NULL, false, costs, count);
        model->kind->list_forward_costs(model, time ? &again : &once, costs, count);
    }
    add_picture(model, &n, chunks, costs, count);
    model->kind->list_backward_costs(model, &once, costs, count);
}

static void add_training(const struct vw_step_passes *step, struct vw_pass_cost *costs, uint32_t *count) {
    const struct vw_model *model = step->field->model;
    const struct sizes n = sizes_of(model, step->padded_rays);
    uint32_t chunks = (step->padded_rays + step->chunk_rays - 1) / step->chunk_rays, windows = model->window_count;
    const struct vw_field_work work = {.samples = n.samples, .chunks = chunks, .stores_rows = true};
    double word_bytes = model->specialization.wide_gradient ? 16 : 8, moments = model->specialization.momentum ? 2 : 1;
    if (step->occupancy.kept) add_occupancy(&n, chunks, costs, count);
    vw_pass_cost_add(
        costs, count,
        (struct vw_pass_cost){"generate_rays", NULL, 1, 0, n.rays * (sizeof(struct vw_pixel) + sizeof(struct vw_ray))});
    add_placing(model, n.rays, chunks, NULL, true, costs, count);
    model->kind->list_forward_costs(model, &work, costs, count);
    if (step->transient.update) add_transient(model, n.samples, chunks, costs, count);
    else vw_pass_cost_add(costs, count, (struct vw_pass_cost){"backward_rays", NULL, chunks, 0, n.samples * 56});
    model->kind->list_backward_costs(model, &work, costs, count);
    if (model->sky.size_bytes) add_sky(&n, costs, count);
    vw_pass_cost_add(costs, count, (struct vw_pass_cost){"reduce_loss", NULL, 1, 0, 4 * n.rays});
    if (step->appearance.update_appearance) // per ray the gradient by gain and bias
        vw_pass_cost_add(costs, count,
                         (struct vw_pass_cost){"update_appearance", NULL, 1, 0, n.rays * sizeof(struct vw_appearance)});
    if (step->appearance.update_code) { // a code times its weights, and back
        double code_weights = (double)model->code_weights.size_bytes / 4;
        vw_pass_cost_add(costs, count, (struct vw_pass_cost){"mix_code", NULL, 1, code_weights, 4 * code_weights});
        vw_pass_cost_add(costs, count,
                         (struct vw_pass_cost){"update_code", NULL, 1, 2 * code_weights, 4 * code_weights * 7});
    }
    if (step->pose.update) add_pose(&n, chunks, costs, count);
    if (step->visibility.predict) add_visibility(&n, costs, count);
    if (step->encoder.pool) {
        add_encoding(model, 1, NULL, costs, count);
        add_encoder_gradient(model, costs, count);
    }
    if (step->consistency) add_consistency(step, costs, count);
    vw_pass_cost_add(costs, count,
                     (struct vw_pass_cost){"update_weights", NULL, 1, 0, 16.0 * model->moved_columns * 7});
    if (windows)
        vw_pass_cost_add(costs, count,
                         (struct vw_pass_cost){"update_grid", NULL, windows, 0,
                                               n.pairs * (2 * word_bytes + 2 * n.pair_bytes + 16 * moments + 8)});
}

static void add_validation(const struct vw_validation *validation, struct vw_pass_cost *costs, uint32_t *count) {
    const struct vw_evaluator *evaluator = &validation->evaluator;
    const struct sizes n = sizes_of(evaluator->field->model, evaluator->ray_count);
    uint32_t chunks = vw_evaluator_count_chunks(evaluator);
    const struct vw_field_work work = {.samples = n.samples, .chunks = chunks, .role = evaluator_role};
    if (evaluator->views) add_encoding(evaluator->field->model, evaluator->view_count, evaluator_role, costs, count);
    add_placing(evaluator->field->model, n.rays, chunks, evaluator_role, false, costs, count);
    evaluator->field->model->kind->list_forward_costs(evaluator->field->model, &work, costs, count);
    vw_pass_cost_add(costs, count,
                     (struct vw_pass_cost){"composite_rays", evaluator_role, chunks, 0, n.samples * 16 + n.rays * 16});
    if (validation->view_fit.pass) // twice the rays that are not scored
        vw_pass_cost_add(costs, count,
                         (struct vw_pass_cost){"fit_views", NULL, 1, 0,
                                               2 * (n.rays - validation->ray_count) * (sizeof(struct vw_ray) + 16)});
    vw_pass_cost_add(costs, count,
                     (struct vw_pass_cost){"reduce_views", NULL, 1, 0, n.rays * (sizeof(struct vw_ray) + 16)});
}

void vw_pass_costs_list(const struct vw_costed_passes *passes, struct vw_pass_cost costs[VW_PASS_COSTS_MAX],
                        uint32_t *count) {
    *count = 0;
    add_training(passes->step, costs, count);
    if (passes->validation->view_count) add_validation(passes->validation, costs, count);
}
