#include "train/fields/registry.h"

#include <assert.h>
#include <string.h>

#include "base/memory.h"
#include "train/effects/registry.h"
#include "train/passes.h"

static const struct vw_field_kind *const kinds[] = {[VW_FIELD_HASH] = &field_hash, [VW_FIELD_MLP] = &field_mlp};

const struct vw_field_kind *vw_field_kind_of(enum vw_field field) {
    assert((size_t)field < VW_ARRAY_COUNT(kinds));
    return kinds[field];
}

enum vw_status vw_effects_follow_field(const struct vw_config *config, struct vw_effect_verdict *verdicts,
                                       uint32_t count) {
    for (uint32_t i = 0; i < count; i++) {
        if (!verdicts[i].on || strcmp(verdicts[i].name, "occupancy") != 0) continue;
        bool skips = vw_field_kind_of(config->field)->skips_samples;
        if (skips && !config->importance_samples) continue;
        if (vw_effects_names(config->effects, verdicts[i].name))
            return vw_fail(VW_ERROR_USAGE, "--effects: %s is not there with --%s %s; leave it out", verdicts[i].name,
                           skips ? "importance-samples" : "field", skips ? "above 0" : vw_field_name(config->field));
        verdicts[i].on = false;
    }
    enum vw_status status = vw_effects_follow_pose(config, verdicts, count);
    if (!status) status = vw_effects_follow_transient(config, verdicts, count);
    return !status ? vw_effects_follow_encoder(config, verdicts, count) : status;
}

void vw_field_passes_destroy(struct vw_field_passes *passes) {
    for (size_t i = 0; i < FIELD_PASSES_MAX; i++) vw_pass_destroy(&passes->passes[i]);
}

enum vw_status vw_field_pass_create(struct vw_gpu *gpu, const struct vw_field_pass_params *params,
                                    const struct vw_shader *shader, const struct vw_specialization *specialization,
                                    struct vw_pass **pass) {
    const struct vw_pass_params common =
        vw_pass_params_of(specialization, params->bindings, params->binding_count, params->role);
    return vw_pass_create_of(gpu, &common, shader, pass);
}
