// Random initial values of params, each keyed by its place in the params block.
#ifndef VIEWWORTH_TRAIN_FIELDS_INITIAL_VALUES_H
#define VIEWWORTH_TRAIN_FIELDS_INITIAL_VALUES_H

#include <stdint.h>

// One uniform number in [-scale, scale) per parameter, keyed by its index in the block.
void vw_fill_uniform(float *values, uint64_t count, uint64_t first_index, float scale, uint64_t seed);

struct vw_drawn {
    const float *weights; // the first number of the range weights, which has index
    uint64_t first_index, seed;
};
// Of `count` numbers in or behind the range weights. Returns what stands behind them.
float *vw_fill_weights(float *values, const struct vw_drawn *drawn, uint64_t count, float scale);
// Of a matrix of 4x4 blocks: He's bound for layers behind a ReLU, so that the signal keeps its size.
float *vw_fill_matrix(float *values, const struct vw_drawn *drawn, uint32_t out4, uint32_t in4);

#endif
