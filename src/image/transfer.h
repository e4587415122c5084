// The sRGB transfer curve. Float files (EXR, HDR, float TIFF) hold linear light; everything inside works on encoded
// values.
#ifndef VIEWWORTH_IMAGE_TRANSFER_H
#define VIEWWORTH_IMAGE_TRANSFER_H

#include <math.h>

static inline float vw_srgb_encode(float linear) {
    return linear <= 0.0031308f ? 12.92f * linear : 1.055f * powf(linear, 1.0f / 2.4f) - 0.055f;
}

static inline float vw_srgb_decode(float encoded) {
    return encoded <= 0.04045f ? encoded / 12.92f : powf((encoded + 0.055f) / 1.055f, 2.4f);
}

#endif
