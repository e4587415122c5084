// Reducing a loaded image, for --downscale.
#ifndef VIEWWORTH_DOWNSCALE_H
#define VIEWWORTH_DOWNSCALE_H

#include "viewworth/status.h"
#include "viewworth/types.h"

// Replaces the pixels by floor(size / factor) of them, at least 1 each way, UINT16 for integer images. `factor` > 1.
// On failure the image is as before.
enum vw_status vw_image_downscale(struct vw_image *image, uint32_t factor);
// What a photo side becomes under --downscale.
uint32_t vw_downscaled_px(uint32_t side_px, uint32_t factor);

#endif
