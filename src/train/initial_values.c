#include "train/initial_values.h"

#include <math.h>

#include "base/random.h"

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
