// Pixels that no ray of the lens model reaches: the dark corners of a circular fisheye, and what lies beyond the fold
// of a polynomial.
#ifndef VIEWWORTH_LENS_MASK_H
#define VIEWWORTH_LENS_MASK_H

#include "viewworth/scene.h"

// Hides them in the view's mask, which is made where there is none, and counts them. The mask has the size of the
// camera.
enum vw_status vw_lens_mask(struct vw_view *view, uint64_t *hidden_count);

#endif
