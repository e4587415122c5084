// Photos in host memory, read and written with OpenImageIO (through src/image/oiio_shim.cpp).
#ifndef VIEWWORTH_IMAGE_H
#define VIEWWORTH_IMAGE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "viewworth/status.h"
#include "viewworth/types.h"

// Reads the header only.
enum vw_status vw_image_probe(const char *path, uint32_t *width_px, uint32_t *height_px);

// Reads an image of 8 or 16 bit integers or of floats, with unassociated alpha; ignores EXIF orientation. `downscale` >
// 1 filters it (premultiplied) down to floor(size / downscale) pixels, at least 1, as UINT16 (FLOAT32 for float input).
// Float values are clamped to [0,1] and counted. VW_ERROR_INPUT for more than 5 % masked pixels, more than 2^28 pixels
// or an invalid header; VW_ERROR_IO if the pixels cannot be decoded.
enum vw_status vw_image_load(const char *path, uint32_t downscale, struct vw_image *image);
// Writes 3- or 4-channel float pixels in [0,1]; the extension of `path` decides the format (PNG: 8 bit, EXR: half or
// float). Writes a temporary file and renames it, so that no incomplete file remains.
enum vw_status vw_image_save(const char *path, uint32_t width_px, uint32_t height_px, uint32_t channels,
                             const float *pixels);
// Makes a thumbnail as the bytes of a WebP file: at most `height_px` high and four times as wide; transparent pixels
// are over `background`. `*data` is owned by the caller (free). VW_ERROR_MEMORY, VW_ERROR_IO.
enum vw_status vw_image_make_thumbnail(const struct vw_image *image, uint32_t height_px, const float background[3],
                                       void **data, size_t *size_bytes);
void vw_image_clear(struct vw_image *image); // frees the pixels and zeroes the struct

// One pixel as straight-alpha RGBA in [0,1]. x_px < width_px and y_px < height_px.
void vw_image_pixel(const struct vw_image *image, uint32_t x_px, uint32_t y_px, float rgba[4]);
// Luminance of a pixel as stored (weights of Rec. 709); transparent pixels are over `background` (RGB). Same limits.
double vw_image_luminance(const struct vw_image *image, uint32_t x_px, uint32_t y_px, const float background[3]);

#endif
