#include "train/initial_values.h"

#include <math.h>
#include <string.h>

#include "base/random.h"

enum { LEAST_NORMAL = 0x38800000, INFINITE = 0x7C00 }; // 2^-14 as a float, infinity as a half

void vw_fill_uniform(float *values, uint64_t count, uint64_t first_index, float scale, uint64_t seed) {
    for (uint64_t i = 0; i < count; i += 4) {
        uint32_t words[4];
        vw_random_words(seed, VW_RANDOM_INITIALISATION, 0, (uint32_t)((first_index + i) / 4), 0, words);
        for (uint64_t j = 0; j < 4 && i + j < count; j++)
            values[i + j] = scale * (2.0f * vw_random_unit(words[j]) - 1.0f);
    }
}

float *vw_fill_weights(float *values, const struct vw_drawn *drawn, uint64_t count, float scale) {
    vw_fill_uniform(values, count, drawn->first_index + (uint64_t)(values - drawn->weights), scale, drawn->seed);
    return values + count;
}

float *vw_fill_matrix(float *values, const struct vw_drawn *drawn, uint32_t out4, uint32_t in4) {
    return vw_fill_weights(values, drawn, 16 * (uint64_t)out4 * in4, sqrtf(6.0f / (4.0f * (float)in4)));
}

uint16_t vw_half_nearest(float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    uint32_t size = bits & 0x7FFFFFFF, sign = bits >> 16 & 0x8000;
    if (size < LEAST_NORMAL) return (uint16_t)(sign | (uint32_t)lrintf(fabsf(value) * 0x1p24f)); // a multiple of 2^-24
    uint32_t rounded =
        (size + 0xFFF + (size >> 13 & 1) - 0x38000000) >> 13; // 13 digits fewer, and an exponent's bias 112 lower
    return (uint16_t)(sign | (rounded < INFINITE ? rounded : INFINITE));
}
