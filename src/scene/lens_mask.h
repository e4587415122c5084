// Pixels without a ray in the lens model: the dark corners of a circular fisheye, and pixels beyond the fold of a
// polynomial.
#ifndef VIEWWORTH_SCENE_LENS_MASK_H
#define VIEWWORTH_SCENE_LENS_MASK_H

#include "viewworth/scene.h"

// Marks them in the view's mask (creates it if there is none) and counts them. The mask has the size of the camera.
enum vw_status vw_lens_mask(struct vw_view *view, uint64_t *hidden_count);

#endif
