#include "train/fields/registry.h"

#include <assert.h>

#include "base/memory.h"

static const struct vw_field_kind *const kinds[] = {[VW_FIELD_HASH] = &field_hash, [VW_FIELD_MLP] = &field_mlp};

const struct vw_field_kind *vw_field_kind_of(enum vw_field field) {
    assert((size_t)field < VW_ARRAY_COUNT(kinds));
    return kinds[field];
}
