// The effect `appearance`: photos differ in exposure and white balance. Each train photo has a gain and a bias per
// channel of the rendered colours (shaders/effects/appearance/appearance.glsl). Only training uses them: validation
// fits a gain and a bias of its own to each view (shaders/effects/appearance/fit_views.comp), and rendering uses none.
#include <string.h>

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
    uint64_t photos = model->view_count, rays = padded_rays;
    const struct vw_effect_buffer listed[] = {
        {VW_SLOT_D_APPEARANCE, "d_appearance", sizeof(struct vw_appearance) * rays, VW_EFFECT_OF_STEP},
        {VW_SLOT_APPEARANCE_MOMENTS, "appearance_moments", sizeof(struct vw_appearance_moments) * photos,
         VW_EFFECT_CARRIED},
    };
    memcpy(buffers, listed, sizeof listed);
    return VW_ARRAY_COUNT(listed);
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
    .binds_ray_buffers = true,
    .update = &vw_shader_update_appearance,
    .ranges = {VW_SLOT_APPEARANCE},
    .lay_out_ranges = lay_out_ranges,
    .list_buffers = list_buffers,
    .list_costs = list_costs,
};
