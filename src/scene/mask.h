// Masks: which pixels of a photo are used. White keeps, black hides. A mask pixel is white if its brightness (times its
// alpha, if it has one) is at least one half.
//
// A mask has the photo's size or an exact multiple or fraction of it: each photo pixel uses the mask pixel at its
// centre. With --downscale, a pixel is kept if every photo pixel that it covers is kept.
#ifndef VIEWWORTH_SCENE_MASK_H
#define VIEWWORTH_SCENE_MASK_H

#include <stdint.h>

#include "image/image.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"

// Reads the header of a mask of the scene folder and checks that it fits a photo of this size.
enum vw_status vw_mask_probe(const char *folder, const char *path, uint32_t photo_width_px, uint32_t photo_height_px,
                             struct vw_image_header *header);
// Makes the mask of a photo of this size with --downscale from the file that was read, whose `path` is for messages: a
// byte per pixel, VW_MASK_HIDE or VW_MASK_KEEP, owned by the caller. VW_ERROR_INPUT if it hides everything.
enum vw_status vw_mask_make(const char *path, const struct vw_image *file, uint32_t photo_width_px,
                            uint32_t photo_height_px, uint32_t downscale, uint8_t **mask);

// Marks pixels without a ray in the lens model (the dark corners of a circular fisheye, and pixels beyond the fold of
// a polynomial) in the view's mask (creates it if there is none) and counts them. The mask has the size of the camera.
enum vw_status vw_lens_mask(struct vw_view *view, uint64_t *hidden_count);

#endif
