#include "train/fields/registry.h"

#include <assert.h>

#include "base/memory.h"

static const struct field_kind *const kinds[] = {[VW_FIELD_HASH] = &field_hash, [VW_FIELD_MLP] = &field_mlp};

const struct field_kind *field_kind_of(enum vw_field field) {
    assert((size_t)field < VW_ARRAY_COUNT(kinds));
    return kinds[field];
}

void field_passes_destroy(struct field_passes *passes) {
    for (size_t i = 0; i < FIELD_PASSES_MAX; i++) vw_pass_destroy(&passes->passes[i]);
}

enum vw_status field_pass_create(const struct field *field, const struct field_pass_params *params,
                                 const struct vw_shader *shader, const struct vw_specialization *specialization,
                                 struct vw_pass **pass) {
    const struct vw_pass_params created = {.shader = shader,
                                           .specialization = (const uint32_t *)specialization,
                                           .specialization_count = VW_SPECIALIZATION_COUNT,
                                           .bindings = params->bindings,
                                           .binding_count = params->binding_count,
                                           .role = params->role};
    return vw_pass_create(field->gpu, &created, pass);
}
