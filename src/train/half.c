#include "train/half.h"

#include <math.h>
#include <string.h>

enum { LEAST_NORMAL = 0x38800000, INFINITE = 0x7C00 }; // 2^-14 as a float, infinity as a half

uint16_t vw_half_nearest(float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    uint32_t size = bits & 0x7FFFFFFF, sign = bits >> 16 & 0x8000;
    if (size < LEAST_NORMAL) return (uint16_t)(sign | (uint32_t)lrintf(fabsf(value) * 0x1p24f)); // a multiple of 2^-24
    uint32_t rounded =
        (size + 0xFFF + (size >> 13 & 1) - 0x38000000) >> 13; // 13 digits fewer, and an exponent's bias 112 lower
    return (uint16_t)(sign | (rounded < INFINITE ? rounded : INFINITE));
}
