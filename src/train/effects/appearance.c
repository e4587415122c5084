// The effect `appearance`: photos differ in exposure and white balance. Each train photo has a gain and a bias per
// channel, by which training corrects it (shaders/effects/appearance/appearance.glsl). Points of structure from motion
// give them before the first step (scene/exposures.c), and nothing moves them. In a scene without points,
// shaders/effects/appearance/fit_photo.comp fits them at every visit. Validation fits a gain and a bias of its own to
// each view (shaders/effects/appearance/fit_views.comp), and rendering uses none.
#include <string.h>

#include "base/memory.h"
#include "gpu/shaders.h"
#include "train/effects/effects.h"
#include "train/model.h"

static void lay_out_ranges(struct vw_model *model, uint64_t trained_views) {
    vw_model_append_range(model, VW_SLOT_APPEARANCE, sizeof(struct vw_appearance) * (uint64_t)model->view_count,
                          6 * trained_views);
}

enum vw_status vw_appearance_take_exposures(const struct vw_model *model, const struct vw_scene *scene, void *params) {
    const struct vw_exposure *exposures = NULL;
    struct vw_appearance *photos =
        (struct vw_appearance *)((char *)params + model->ranges[VW_SLOT_APPEARANCE].offset_bytes);
    enum vw_status status = vw_scene_estimate_exposures(scene, &exposures);
    for (uint32_t v = 0; v < model->view_count && !status; v++)
        for (int i = 0; i < 3; i++) {
            (&photos[v].gain.x)[i] = (float)exposures[v].gain[i];
            (&photos[v].bias.x)[i] = (float)exposures[v].bias[i];
        }
    return status;
}

static bool is_fitted(const struct vw_model *model) {
    return model->specialization.effect_appearance == APPEARANCE_FITTED;
}

static uint32_t list_buffers(const struct vw_model *model, uint32_t padded_rays, struct vw_effect_buffer *buffers) {
    uint64_t fitted = is_fitted(model), photos = fitted * model->view_count, rays = fitted * padded_rays;
    const struct vw_effect_buffer listed[] = {
        {VW_SLOT_RENDERED, "rendered", sizeof(vw_float4) * rays, VW_EFFECT_OF_STEP},
        {VW_SLOT_PHOTO_SUMS, "photo_sums", sizeof(struct vw_photo_sums) * photos, VW_EFFECT_CARRIED},
    };
    memcpy(buffers, listed, sizeof listed);
    return VW_ARRAY_COUNT(listed);
}

const struct vw_effect_kind vw_effect_appearance = {
    .name = "appearance",
    .constant = VW_EFFECT_CONSTANT(appearance),
    .adjoint = VW_ADJOINT_HOLDS,
    .training_alone = true,
    .fits_views = true,
    .binds_ray_buffers = true,
    .update = &vw_shader_fit_photo,
    .updates = is_fitted,
    .ranges = {VW_SLOT_APPEARANCE},
    .lay_out_ranges = lay_out_ranges,
    .list_buffers = list_buffers,
};
