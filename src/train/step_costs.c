// The costs of a step with its validation (pass_costs.h), as a trainer takes it.
#include "train/effects/effects.h"
#include "train/renderers/registry.h"
#include "train/trainer.h"
#include "train/trainer_private.h"

static void add_training(const struct vw_step_passes *step, struct vw_pass_costs *costs) {
    const struct vw_model *model = step->field->model;
    double rays = step->padded_rays;
    vw_pass_cost_add(costs, (struct vw_pass_cost){"generate_rays", NULL, 1, 0,
                                                  rays * (sizeof(struct vw_pixel) + sizeof(struct vw_ray))});
    vw_effects_list_photo_costs(model, 1, false, NULL, costs);
    model->renderer->list_step_costs(step, costs);
    vw_pass_cost_add(costs, (struct vw_pass_cost){"reduce_loss", NULL, 1, 0, 4 * rays});
    if (model->moved_columns)
        vw_pass_cost_add(costs, (struct vw_pass_cost){"update_weights", NULL, 1, 0, 16.0 * model->moved_columns * 7});
}

static void add_validation(const struct vw_validation *validation, struct vw_pass_costs *costs) {
    const struct vw_evaluator *evaluator = &validation->evaluator;
    const struct vw_model *model = evaluator->field->model;
    double rays = evaluator->ray_count;
    vw_effects_list_photo_costs(model, evaluator->view_count, true, evaluator_role, costs);
    model->renderer->list_evaluation_costs(evaluator, costs);
    if (validation->view_fit.pass) // twice the rays that are not scored
        vw_pass_cost_add(costs,
                         (struct vw_pass_cost){"fit_views", NULL, 1, 0,
                                               2 * (rays - validation->ray_count) * (sizeof(struct vw_ray) + 16)});
    vw_pass_cost_add(costs, (struct vw_pass_cost){"reduce_views", NULL, 1, 0, rays * (sizeof(struct vw_ray) + 16)});
}

void vw_trainer_pass_costs(const struct vw_trainer *trainer, struct vw_pass_costs *costs) {
    costs->count = 0;
    add_training(&trainer->step, costs);
    if (trainer->validation.view_count) add_validation(&trainer->validation, costs);
}
