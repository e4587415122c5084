// Whole views, tile by tile, through an evaluator of its own: the same passes as validation.
#ifndef VIEWWORTH_TRAIN_RENDER_H
#define VIEWWORTH_TRAIN_RENDER_H

#include "train/field.h"

// rgb floats, width * height * 3, rows top to bottom, owned by the caller.
enum vw_status render_view(struct field *field, const struct vw_scene *scene, uint32_t view, float **rgb);

#endif
