// The effect `sky`: a learned colour by direction serves as the field's background (shaders/effects/sky/sky.glsl). Its
// coefficients follow the field's weights, are mid grey at first, and move with them.
#include "gpu/shaders.h"
#include "train/effects/kind.h"
#include "train/model.h"

static void lay_out_columns(struct vw_model *model) {
    const uint64_t params = 3 * VW_SKY_COLUMNS; // the fourth number of a column is padding
    uint32_t first = vw_model_append_columns(model, VW_SKY_COLUMNS, params);
    model->ranges[VW_SLOT_SKY] = vw_model_columns(model, first, VW_SKY_COLUMNS);
}

static uint32_t list_buffers(const struct vw_model *model, uint32_t padded_rays, struct vw_effect_buffer *buffers) {
    (void)model;
    *buffers =
        (struct vw_effect_buffer){VW_SLOT_D_SKY, "d_sky", sizeof(vw_float4) * (uint64_t)padded_rays, VW_EFFECT_OF_STEP};
    return 1;
}

const struct vw_effect_kind vw_effect_sky = {
    .name = "sky",
    .constant = VW_EFFECT_CONSTANT(sky),
    .adjoint = VW_ADJOINT_FOLLOWS,
    .binds_ray_buffers = true,
    .ranges = {VW_SLOT_SKY},
    .lay_out_columns = lay_out_columns,
    .list_buffers = list_buffers,
};
