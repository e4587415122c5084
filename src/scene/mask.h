// Masks: which pixels of a photo are used. White keeps, black hides. A mask pixel is white if its brightness (times its
// alpha, if it has one) is at least one half.
//
// A mask has the photo's size or an exact multiple or fraction of it: each photo pixel uses the mask pixel at its
// centre. With --downscale, a pixel is kept if every photo pixel that it covers is kept.
#ifndef VIEWWORTH_MASK_H
#define VIEWWORTH_MASK_H

#include <stdint.h>

#include "viewworth/status.h"

// Finds the mask of a photo in a folder images/ of the scene folder: the file in masks/ beside it with the photo's
// name, with the name and ".png", or with ".png" in place of its extension. `*mask_path` is owned by the caller; it
// stays NULL if there is no mask.
enum vw_status vw_mask_find(const char *folder, const char *image_path, char **mask_path);
// Checks, by its header, that a mask fits a photo of this size.
enum vw_status vw_mask_probe(const char *path, uint32_t photo_width_px, uint32_t photo_height_px);
// Reads the mask of a photo of this size with --downscale: a byte per pixel, VW_MASK_HIDE or VW_MASK_KEEP, owned by the
// caller. VW_ERROR_INPUT if it hides everything.
enum vw_status vw_mask_load(const char *path, uint32_t photo_width_px, uint32_t photo_height_px, uint32_t downscale,
                            uint8_t **mask);

#endif
