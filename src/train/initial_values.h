// Initial values of params: random numbers, each keyed by its place in the params block.
#ifndef VIEWWORTH_TRAIN_INITIAL_VALUES_H
#define VIEWWORTH_TRAIN_INITIAL_VALUES_H

#include <stdint.h>

// Draws one uniform number in [-scale, scale) per parameter, keyed by its index in the block.
void vw_fill_uniform(float *values, uint64_t count, uint64_t first_index, float scale, uint64_t seed);

struct vw_drawn {
    const float *weights; // the first number of the range weights, which has index
    uint64_t first_index, seed;
};
// Fills `count` numbers in or after the range weights. Returns what follows them.
float *vw_fill_weights(float *values, const struct vw_drawn *drawn, uint64_t count, float scale);
// Fills a matrix of 4x4 blocks within He's bound for layers that follow a ReLU, so that the signal keeps its size.
float *vw_fill_matrix(float *values, const struct vw_drawn *drawn, uint32_t out4, uint32_t in4);

#endif
