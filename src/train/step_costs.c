// The costs of a step with its validation (pass_costs.h), as a trainer takes it.
#include "train/effects/effects.h"
#include "train/importance.h"
#include "train/trainer.h"
#include "train/trainer_private.h"

static void add_training(const struct vw_step_passes *step, struct vw_pass_costs *costs) {
    const struct vw_model *model = step->field->model;
    const struct vw_cost_sizes n = vw_cost_sizes_of(model, step->padded_rays);
    uint32_t chunks = (step->padded_rays + step->chunk_rays - 1) / step->chunk_rays, windows = model->window_count;
    const struct vw_field_work work = {.samples = n.samples, .chunks = chunks, .stores_rows = true};
    double word_bytes = model->specialization.wide_gradient ? 16 : 8, moments = model->specialization.momentum ? 2 : 1;
    vw_pass_cost_add(costs, (struct vw_pass_cost){"generate_rays", NULL, 1, 0,
                                                  n.rays * (sizeof(struct vw_pixel) + sizeof(struct vw_ray))});
    vw_importance_list_costs(model, n.rays, chunks, NULL, true, costs);
    model->kind->list_forward_costs(model, &work, costs);
    // backward_transient reads a sample twice: 16 bytes of the field and two rows; it writes as much, and the sum of
    // tau.
    const struct vw_pass_cost rays = {"backward_rays", NULL, chunks, 0, n.samples * 56},
                              both = {"backward_transient", NULL, chunks, 0, n.samples * 152};
    vw_pass_cost_add(costs, model->specialization.effect_transient ? both : rays);
    model->kind->list_backward_costs(model, &work, costs);
    vw_pass_cost_add(costs, (struct vw_pass_cost){"reduce_loss", NULL, 1, 0, 4 * n.rays});
    vw_effects_list_photo_costs(model, 1, false, NULL, costs);
    vw_effects_list_costs(
        &(struct vw_effect_work){.step = step, .model = model, .rays = step->padded_rays, .chunks = chunks}, costs);
    vw_pass_cost_add(costs, (struct vw_pass_cost){"update_weights", NULL, 1, 0, 16.0 * model->moved_columns * 7});
    if (windows)
        vw_pass_cost_add(costs,
                         (struct vw_pass_cost){"update_grid", NULL, windows, 0,
                                               n.pairs * (2 * word_bytes + 2 * n.pair_bytes + 16 * moments + 8)});
}

static void add_validation(const struct vw_validation *validation, struct vw_pass_costs *costs) {
    const struct vw_evaluator *evaluator = &validation->evaluator;
    const struct vw_cost_sizes n = vw_cost_sizes_of(evaluator->field->model, evaluator->ray_count);
    uint32_t chunks = vw_evaluator_count_chunks(evaluator);
    const struct vw_field_work work = {.samples = n.samples, .chunks = chunks, .role = evaluator_role};
    vw_effects_list_photo_costs(evaluator->field->model, evaluator->view_count, true, evaluator_role, costs);
    vw_importance_list_costs(evaluator->field->model, n.rays, chunks, evaluator_role, false, costs);
    evaluator->field->model->kind->list_forward_costs(evaluator->field->model, &work, costs);
    vw_pass_cost_add(costs,
                     (struct vw_pass_cost){"composite_rays", evaluator_role, chunks, 0, n.samples * 16 + n.rays * 16});
    if (validation->view_fit.pass) // twice the rays that are not scored
        vw_pass_cost_add(costs,
                         (struct vw_pass_cost){"fit_views", NULL, 1, 0,
                                               2 * (n.rays - validation->ray_count) * (sizeof(struct vw_ray) + 16)});
    vw_pass_cost_add(costs, (struct vw_pass_cost){"reduce_views", NULL, 1, 0, n.rays * (sizeof(struct vw_ray) + 16)});
}

void vw_trainer_pass_costs(const struct vw_trainer *trainer, struct vw_pass_costs *costs) {
    costs->count = 0;
    add_training(&trainer->step, costs);
    if (trainer->validation.view_count) add_validation(&trainer->validation, costs);
}
