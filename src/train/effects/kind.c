#include "train/effects/kind.h"

#include <string.h>

bool vw_effect_kind_is_on(const struct vw_effect_kind *kind, const struct vw_specialization *specialization) {
    uint32_t value;
    memcpy(&value, (const char *)specialization + kind->constant, sizeof value);
    return value != 0;
}

const struct vw_effect_kind *vw_effect_kind_on(uint32_t index, const struct vw_specialization *specialization) {
    return vw_effect_kind_is_on(vw_effect_kinds[index], specialization) ? vw_effect_kinds[index] : NULL;
}

void vw_effects_lay_out_columns(const struct vw_config *config, bool followed,
                                const struct vw_specialization *specialization, struct vw_model *model) {
    for (uint32_t i = 0; i < vw_effect_kind_count; i++) {
        const struct vw_effect_kind *kind = vw_effect_kind_on(i, specialization);
        if (kind && kind->lay_out_columns && (kind->adjoint == VW_ADJOINT_FOLLOWS) == followed)
            kind->lay_out_columns(config, model);
    }
}

void vw_effects_lay_out_ranges(uint64_t trained_views, const struct vw_specialization *specialization,
                               struct vw_model *model) {
    for (uint32_t i = 0; i < vw_effect_kind_count; i++) {
        const struct vw_effect_kind *kind = vw_effect_kind_on(i, specialization);
        if (kind && kind->lay_out_ranges) kind->lay_out_ranges(model, trained_views);
    }
}

void vw_effects_initialise(const struct vw_model *model, const struct vw_specialization *specialization,
                           const struct vw_drawn *drawn, void *params) {
    for (uint32_t i = 0; i < vw_effect_kind_count; i++) {
        const struct vw_effect_kind *kind = vw_effect_kind_on(i, specialization);
        if (kind && kind->initialise) kind->initialise(model, drawn, params);
    }
}

bool vw_effects_are_of_rays(const struct vw_specialization *specialization) {
    for (uint32_t i = 0; i < vw_effect_kind_count; i++)
        if (vw_effect_kind_on(i, specialization) && vw_effect_kinds[i]->of_rays) return true;
    return false;
}

bool vw_effects_fit(const struct vw_specialization *specialization) {
    for (uint32_t i = 0; i < vw_effect_kind_count; i++)
        if (vw_effect_kind_on(i, specialization) && vw_effect_kinds[i]->fits_views) return true;
    return false;
}

bool vw_effects_see_photos(const struct vw_specialization *specialization) {
    for (uint32_t i = 0; i < vw_effect_kind_count; i++)
        if (vw_effect_kind_on(i, specialization) && vw_effect_kinds[i]->sees_photos) return true;
    return false;
}

void vw_effects_leave_training(struct vw_specialization *specialization) {
    for (uint32_t i = 0; i < vw_effect_kind_count; i++)
        if (vw_effect_kinds[i]->training_alone)
            memset((char *)specialization + vw_effect_kinds[i]->constant, 0, sizeof(uint32_t));
}

enum vw_status vw_effects_check_adjoint(const struct vw_specialization *specialization) {
    for (uint32_t i = 0; i < vw_effect_kind_count; i++) {
        const struct vw_effect_kind *kind = vw_effect_kind_on(i, specialization);
        if (kind && kind->adjoint == VW_ADJOINT_REFUSES)
            return vw_fail(VW_ERROR_USAGE,
                           "lasting credit cannot go back through the effect %s; value the scene with --effects -%s",
                           kind->name, kind->name);
    }
    return VW_OK;
}
