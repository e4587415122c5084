// The pixel formats of files, and channel values of each as floats in [0,1] (floats: as they are).
#ifndef VIEWWORTH_IMAGE_PIXEL_H
#define VIEWWORTH_IMAGE_PIXEL_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>

#include "viewworth/types.h"

// The header of an image file.
struct vw_image_header {
    uint32_t width_px, height_px, channels;
    enum vw_pixel_format format;
    uint32_t orientation; // by EXIF, 1 to 8; 0: not given. Pixels are as stored, whatever it is
};

static inline size_t vw_pixel_channel_bytes(enum vw_pixel_format format) {
    return format == VW_PIXEL_UINT8 ? 1 : format == VW_PIXEL_UINT16 ? 2 : 4;
}

static inline float vw_pixel_get(enum vw_pixel_format format, const void *values, size_t index) {
    switch (format) {
    case VW_PIXEL_UINT8: return (float)((const uint8_t *)values)[index] / 255.0f;
    case VW_PIXEL_UINT16: return (float)((const uint16_t *)values)[index] / 65535.0f;
    default: return ((const float *)values)[index];
    }
}

// Stores `value`, which is in [0,1]; integers are rounded to nearest, so that a value from vw_pixel_get is restored
// exactly.
static inline void vw_pixel_set(enum vw_pixel_format format, void *values, size_t index, float value) {
    switch (format) {
    case VW_PIXEL_UINT8: ((uint8_t *)values)[index] = (uint8_t)lrintf(value * 255.0f); break;
    case VW_PIXEL_UINT16: ((uint16_t *)values)[index] = (uint16_t)lrintf(value * 65535.0f); break;
    default: ((float *)values)[index] = value;
    }
}

// Encodes linear light by the sRGB curve. Float files (EXR, HDR, float TIFF) have linear light; everything inside works
// on encoded values.
static inline float vw_srgb_encode(float linear) {
    return linear <= 0.0031308f ? 12.92f * linear : 1.055f * powf(linear, 1.0f / 2.4f) - 0.055f;
}

static inline float vw_srgb_decode(float encoded) {
    return encoded <= 0.04045f ? encoded / 12.92f : powf((encoded + 0.055f) / 1.055f, 2.4f);
}

// Returns the length of a photo's side after --downscale: floor(side / factor), at least 1.
static inline uint32_t vw_downscaled_px(uint32_t side_px, uint32_t factor) {
    if (factor <= 1) return side_px;
    return side_px > factor ? side_px / factor : 1;
}

#endif
