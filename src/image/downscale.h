// Reduces a loaded image, for --downscale.
#ifndef VIEWWORTH_DOWNSCALE_H
#define VIEWWORTH_DOWNSCALE_H

#include "viewworth/status.h"
#include "viewworth/types.h"

// Replaces the pixels by floor(size / factor), at least 1, along each axis; UINT16 for integer images. `factor` > 1.
// After a failure the image is unchanged.
enum vw_status vw_image_downscale(struct vw_image *image, uint32_t factor);
// The length of a photo's side after --downscale.
uint32_t vw_downscaled_px(uint32_t side_px, uint32_t factor);

#endif
