// Masks: which pixels of a photo may be looked at. White keeps, black hides; a mask pixel is white when its brightness
// (times its alpha, if it has one) is at least one half.
//
// A mask has the photo's size, or that size by an exact scale: then each photo pixel takes the mask pixel at its
// centre. Under --downscale a pixel is kept when every photo pixel that it covers is kept.
#ifndef VIEWWORTH_MASK_H
#define VIEWWORTH_MASK_H

#include <stdint.h>

#include "viewworth/status.h"

// The mask of a photo in a folder images/ of the scene folder: the file in masks/ beside it with the photo's name, the
// name and ".png", or the name with ".png" in place of its extension. `*mask_path` (owned by the caller) stays NULL
// when there is none.
enum vw_status vw_mask_find(const char *folder, const char *image_path, char **mask_path);
// Checks, from its header alone, that a mask fits a photo of this size.
enum vw_status vw_mask_probe(const char *path, uint32_t photo_width_px, uint32_t photo_height_px);
// The mask of a photo of this size under --downscale: a byte per pixel, VW_MASK_HIDE or VW_MASK_KEEP, owned by the
// caller. One that hides everything is refused.
enum vw_status vw_mask_load(const char *path, uint32_t photo_width_px, uint32_t photo_height_px, uint32_t downscale,
                            uint8_t **mask);

#endif
