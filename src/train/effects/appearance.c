// The effect `appearance`: photos differ in exposure and white balance. Each train photo has a gain and a bias per
// channel of the rendered colours (shaders/effects/appearance/appearance.glsl). Only training uses them: validation
// fits a gain and a bias of its own to each view (shaders/effects/appearance/fit_views.comp), and rendering uses none.
#include "base/memory.h"
#include "gpu/shaders.h"
#include "train/effects/kind.h"
#include "train/model.h"
#include "train/pass_costs.h"

static void lay_out_ranges(struct vw_model *model, uint64_t trained_views) {
    vw_model_append_range(model, VW_SLOT_APPEARANCE, sizeof(struct vw_appearance) * (uint64_t)model->view_count,
                          6 * trained_views);
}

static uint32_t list_buffers(const struct vw_model *model, uint32_t padded_rays, struct vw_effect_buffer *buffers) {
    buffers[0] = (struct vw_effect_buffer){.slot = VW_SLOT_D_APPEARANCE,
                                           .name = "d_appearance",
                                           .size_bytes = sizeof(struct vw_appearance) * (uint64_t)padded_rays};
    buffers[1] =
        (struct vw_effect_buffer){.slot = VW_SLOT_APPEARANCE_MOMENTS,
                                  .name = "appearance_moments",
                                  .size_bytes = sizeof(struct vw_appearance_moments) * (uint64_t)model->view_count,
                                  .carried = true};
    return 2;
}

static void record_update(struct vw_pass *const *passes, struct vw_submission *batch,
                          const struct vw_push_update *push) {
    vw_submission_dispatch(batch, passes[0], push, sizeof *push, 1);
}

static void list_costs(const struct vw_effect_work *work, struct vw_pass_costs *costs) {
    const double bytes = work->rays * sizeof(struct vw_appearance); // per ray the gradient by gain and bias
    vw_pass_cost_add(costs, (struct vw_pass_cost){"update_appearance", NULL, 1, 0, bytes});
}

const struct vw_effect_kind vw_effect_appearance = {
    .name = "appearance",
    .constant = VW_EFFECT_CONSTANT(appearance),
    .adjoint = VW_ADJOINT_FOLLOWS,
    .gather = &vw_shader_gather_photo,
    .gathered = VW_SLOT_APPEARANCE,
    .training_alone = true,
    .fits_views = true,
    .of_rays = true,
    .shaders = {{&vw_shader_update_appearance}},
    .ranges = {VW_SLOT_APPEARANCE},
    .lay_out_ranges = lay_out_ranges,
    .list_buffers = list_buffers,
    .record_update = record_update,
    .list_costs = list_costs,
};
