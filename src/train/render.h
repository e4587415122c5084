// Whole views, tile by tile, through an evaluator of its own: the same passes as validation.
#ifndef VIEWWORTH_TRAIN_RENDER_H
#define VIEWWORTH_TRAIN_RENDER_H

#include "train/field.h"

// Renders a view as rgb floats, width * height * 3, rows top to bottom, owned by the caller. `size_px` is at most the
// view's width and height: a smaller render takes the photo's pixel in the middle of each of its own.
enum vw_status vw_trainer_render_view(struct vw_radiance_field *field, const struct vw_scene *scene, uint32_t view,
                                      const uint32_t size_px[2], float **rgb);

#endif
