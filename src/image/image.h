// Photos in host memory, read and written through OpenImageIO (behind src/image/oiio_shim.cpp).
#ifndef VIEWWORTH_IMAGE_H
#define VIEWWORTH_IMAGE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "viewworth/status.h"
#include "viewworth/types.h"

// Reads the header only.
enum vw_status vw_image_probe(const char *path, uint32_t *width_px, uint32_t *height_px);

// Reads a whole image of 8 or 16 bit integers or of floats, as unassociated alpha, ignoring EXIF orientation. With
// `downscale` > 1 it is filtered (on premultiplied colour) down to floor(size / downscale) pixels, at least 1, and kept
// as UINT16 (FLOAT32 for float input). Float values are clamped to [0,1] and counted. More than 5 % masked pixels, more
// than 2^28 pixels or a wrong header is VW_ERROR_INPUT; pixels that cannot be decoded are VW_ERROR_IO.
enum vw_status vw_image_load(const char *path, uint32_t downscale, struct vw_image *image);
// Writes 3- or 4-channel float pixels in [0,1] as the extension of `path` says (PNG: 8 bit, EXR: half or float),
// through a temporary file that is renamed, so no half-written output is left.
enum vw_status vw_image_save(const char *path, uint32_t width_px, uint32_t height_px, uint32_t channels,
                             const float *pixels);
// A small picture of the image as the bytes of a WebP file, for pages and lists: at most `height_px` high and four
// times as wide, before `background` where it is transparent. `*data` is owned by the caller (free). VW_ERROR_MEMORY,
// VW_ERROR_IO.
enum vw_status vw_image_make_thumbnail(const struct vw_image *image, uint32_t height_px, const float background[3],
                                       void **data, size_t *size_bytes);
void vw_image_clear(struct vw_image *image); // frees the pixels and zeroes the struct

// One pixel as straight-alpha RGBA in [0,1]. x_px < width_px and y_px < height_px.
void vw_image_pixel(const struct vw_image *image, uint32_t x_px, uint32_t y_px, float rgba[4]);
// Luminance of a pixel as stored (weights of Rec. 709), over `background` (RGB) where it is transparent; same limits.
double vw_image_luminance(const struct vw_image *image, uint32_t x_px, uint32_t y_px, const float background[3]);

#endif
