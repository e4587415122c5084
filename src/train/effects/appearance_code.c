// The effect `appearance_code`: photos differ in light. Each train photo has a code of 48 numbers that enters the
// colour network (shaders/effects/appearance_code/mix_code.comp). Only training uses codes; validation and rendering
// see the code 0.
#include <string.h>

#include "base/memory.h"
#include "gpu/shaders.h"
#include "train/effects/kind.h"
#include "train/model.h"

enum { MIX };

static void lay_out_ranges(struct vw_model *model, uint64_t trained_views) {
    uint64_t code = 4 * CODE4, width = 4 * model->specialization.width4;
    vw_model_append_range(model, VW_SLOT_CODE_WEIGHTS, sizeof(float) * code * width, code * width);
    vw_model_append_range(model, VW_SLOT_CODES, sizeof(float) * code * model->view_count, code * trained_views);
}

// Fills codes with 0 and weights with other numbers: the field starts as it would without them, and both have gradients
// from the second visit on.
static void initialise(const struct vw_model *model, const struct vw_drawn *drawn, void *params) {
    vw_fill_matrix((float *)((char *)params + model->ranges[VW_SLOT_CODE_WEIGHTS].offset_bytes), drawn,
                   model->specialization.width4, CODE4);
}

static uint32_t list_buffers(const struct vw_model *model, uint32_t padded_rays, struct vw_effect_buffer *buffers) {
    (void)padded_rays;
    uint64_t weights_bytes = model->ranges[VW_SLOT_CODE_WEIGHTS].size_bytes, photos = model->view_count;
    const struct vw_effect_buffer listed[] = {
        {VW_SLOT_CODE_SHIFT, "code_shift", weights_bytes / (4 * CODE4), VW_EFFECT_OF_STEP},
        {VW_SLOT_CODE_WEIGHT_MOMENTS, "code_weight_moments", 2 * weights_bytes, VW_EFFECT_CARRIED},
        {VW_SLOT_CODE_MOMENTS, "code_moments", sizeof(struct vw_code_moments) * photos, VW_EFFECT_CARRIED},
    };
    memcpy(buffers, listed, sizeof listed);
    return VW_ARRAY_COUNT(listed);
}

static void record_photo(const struct vw_model *model, struct vw_pass *const *passes, struct vw_submission *submission,
                         uint32_t view) {
    (void)view; // the step's, which its state says
    vw_submission_dispatch(submission, passes[MIX], NULL, 0, 4 * (uint64_t)model->specialization.width4);
}

const struct vw_effect_kind vw_effect_appearance_code = {
    .name = "appearance_code",
    .constant = VW_EFFECT_CONSTANT(appearance_code),
    .adjoint = VW_ADJOINT_FOLLOWS,
    .training_alone = true,
    .fits_views = true,
    .shaders = {[MIX] = &vw_shader_mix_code},
    .update = &vw_shader_update_code,
    .ranges = {VW_SLOT_CODE_WEIGHTS, VW_SLOT_CODES},
    .lay_out_ranges = lay_out_ranges,
    .initialise = initialise,
    .list_buffers = list_buffers,
    .record_photo = record_photo,
};
