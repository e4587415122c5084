// The passes of a drawing and of its gradient bind the same buffers.
#ifndef VIEWWORTH_TRAIN_RENDERERS_SPLATS_PRIVATE_H
#define VIEWWORTH_TRAIN_RENDERERS_SPLATS_PRIVATE_H

#include "train/renderers/splats/splats.h"

// Writes the bindings of a drawing, with list `from` of the two sorted ones as the one to read, then the caller's.
// Returns how many there are.
uint32_t vw_splat_drawing_bind(const struct vw_splat_drawing *drawing, const struct vw_splat_pass_params *params,
                               uint32_t from, struct vw_binding *bindings);
// Returns the params that all passes of splats share.
struct vw_pass_params vw_splat_common(const struct vw_splat_pass_params *params, const struct vw_binding *bindings,
                                      uint32_t count);

#endif
