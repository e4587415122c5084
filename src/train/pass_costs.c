#include "train/pass_costs.h"

#include <assert.h>
#include <string.h>

#include "train/effects/parts.h"

struct vw_cost_sizes vw_cost_sizes_of(const struct vw_model *model, uint32_t rays) {
    const struct vw_specialization *s = &model->specialization;
    uint32_t encoding4 = s->levels * s->feature_pairs / 2;
    return (struct vw_cost_sizes){.samples = (double)rays * s->samples,
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

// Adds the placing of samples. The even samples have no transients.
void vw_pass_costs_add_placing(const struct vw_model *model, double rays, uint32_t chunks, const char *role,
                               bool trains, struct vw_pass_cost *costs, uint32_t *count) {
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

static void add_training(const struct vw_step_passes *step, struct vw_pass_cost *costs, uint32_t *count) {
    const struct vw_model *model = step->field->model;
    const struct vw_cost_sizes n = vw_cost_sizes_of(model, step->padded_rays);
    uint32_t chunks = (step->padded_rays + step->chunk_rays - 1) / step->chunk_rays, windows = model->window_count;
    const struct vw_field_work work = {.samples = n.samples, .chunks = chunks, .stores_rows = true};
    double word_bytes = model->specialization.wide_gradient ? 16 : 8, moments = model->specialization.momentum ? 2 : 1;
    vw_pass_cost_add(
        costs, count,
        (struct vw_pass_cost){"generate_rays", NULL, 1, 0, n.rays * (sizeof(struct vw_pixel) + sizeof(struct vw_ray))});
    vw_pass_costs_add_placing(model, n.rays, chunks, NULL, true, costs, count);
    model->kind->list_forward_costs(model, &work, costs, count);
    // backward_transient reads a sample twice: 16 bytes of the field and two rows; it writes as much, and the sum of
    // tau.
    const struct vw_pass_cost rays = {"backward_rays", NULL, chunks, 0, n.samples * 56},
                              both = {"backward_transient", NULL, chunks, 0, n.samples * 152};
    vw_pass_cost_add(costs, count, model->specialization.effect_transient ? both : rays);
    model->kind->list_backward_costs(model, &work, costs, count);
    vw_pass_cost_add(costs, count, (struct vw_pass_cost){"reduce_loss", NULL, 1, 0, 4 * n.rays});
    vw_effects_list_photo_costs(model, 1, false, NULL, costs, count);
    vw_effects_list_costs(
        &(struct vw_effect_work){.step = step, .model = model, .rays = step->padded_rays, .chunks = chunks}, costs,
        count);
    vw_pass_cost_add(costs, count,
                     (struct vw_pass_cost){"update_weights", NULL, 1, 0, 16.0 * model->moved_columns * 7});
    if (windows)
        vw_pass_cost_add(costs, count,
                         (struct vw_pass_cost){"update_grid", NULL, windows, 0,
                                               n.pairs * (2 * word_bytes + 2 * n.pair_bytes + 16 * moments + 8)});
}

static void add_validation(const struct vw_validation *validation, struct vw_pass_cost *costs, uint32_t *count) {
    const struct vw_evaluator *evaluator = &validation->evaluator;
    const struct vw_cost_sizes n = vw_cost_sizes_of(evaluator->field->model, evaluator->ray_count);
    uint32_t chunks = vw_evaluator_count_chunks(evaluator);
    const struct vw_field_work work = {.samples = n.samples, .chunks = chunks, .role = evaluator_role};
    vw_effects_list_photo_costs(evaluator->field->model, evaluator->view_count, true, evaluator_role, costs, count);
    vw_pass_costs_add_placing(evaluator->field->model, n.rays, chunks, evaluator_role, false, costs, count);
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
