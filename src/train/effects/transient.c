// The effect `transient` (NeRF-W, Martin-Brualla et al., CVPR 2021): what stands in a photo but not in the scene, such
// as people and cars, is explained by a second density with its own colours and uncertainty, which only training sees.
// It comes from a head, a small network that takes in the field's features at a sample and a code of the photo. The
// head's layers are the field's business (vw_mlp_append_head() of fields/mlp.h), and its weights follow the field's.
//   feed_transient -> layers -> backward_transient (composites, takes the loss) -> layers back, into the features
// Validation and rendering see the field's own density alone.
#include "gpu/shaders.h"
#include "train/effects/kind.h"
#include "train/model.h"

static void lay_out_ranges(struct vw_model *model, uint64_t trained_views) {
    vw_model_append_range(model, VW_SLOT_TRANSIENT_CODES,
                          sizeof(vw_float4) * TRANSIENT_CODE4 * (uint64_t)model->view_count,
                          4 * TRANSIENT_CODE4 * trained_views);
}

static uint32_t list_buffers(const struct vw_model *model, uint32_t padded_rays, struct vw_effect_buffer *buffers) {
    (void)padded_rays;
    *buffers =
        (struct vw_effect_buffer){VW_SLOT_TRANSIENT_CODE_MOMENTS, "transient_code_moments",
                                  sizeof(struct vw_transient_moments) * (uint64_t)model->view_count, VW_EFFECT_CARRIED};
    return 1;
}

const struct vw_effect_kind vw_effect_transient = {
    .name = "transient",
    .constant = VW_EFFECT_CONSTANT(transient),
    .adjoint = VW_ADJOINT_REFUSES, // its loss has no curvature here
    .training_alone = true,
    .update = &vw_shader_update_transient,
    .ranges = {VW_SLOT_TRANSIENT_CODES},
    .lay_out_ranges = lay_out_ranges,
    .list_buffers = list_buffers,
};
