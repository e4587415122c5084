// The size of a photo after --downscale.
#ifndef VIEWWORTH_IMAGE_DOWNSCALE_H
#define VIEWWORTH_IMAGE_DOWNSCALE_H

#include <stdint.h>

// Returns the length of a photo's side: floor(side / factor), at least 1.
static inline uint32_t vw_downscaled_px(uint32_t side_px, uint32_t factor) {
    if (factor <= 1) return side_px;
    return side_px > factor ? side_px / factor : 1;
}

#endif
