#include "train/renderers/registry.h"

const struct vw_renderer_kind *vw_renderer_kind_of(enum vw_field field) {
    (void)field; // every field so far is one of the volume
    return &renderer_volume;
}
