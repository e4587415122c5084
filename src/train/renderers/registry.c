#include "train/renderers/registry.h"

const struct vw_renderer_kind *vw_renderer_kind_of(enum vw_field field) {
    return field == VW_FIELD_SPLATS ? &renderer_splats : &renderer_volume;
}
