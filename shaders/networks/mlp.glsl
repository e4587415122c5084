// The two small networks, one sample per invocation: density MLP (encoding -> hidden -> raw density and 15 features)
// and colour MLP (features and direction -> hidden -> rgb), ReLU between, no biases (spherical-harmonic band 0 serves
// as one).
//
// A weight matrix is stored as 4x4 blocks, row of blocks by row of blocks; a block is four vec4 columns. So forward is
// block * vector and backward is vector * block, with the same addresses. Weights sit in shared memory and are read at
// constant offsets.
#ifndef MLP_GLSL
#define MLP_GLSL
#include "networks/activations.glsl"

const uint ENC4 = LEVELS * FEATURE_PAIRS / 2u; // encoding / 4
// First vec4 of each matrix.
const uint DENSITY1 = 0u;                             // WIDTH4 x ENC4 blocks
const uint DENSITY2 = DENSITY1 + 4u * WIDTH4 * ENC4;  // GEO4 x WIDTH4
const uint COLOUR1 = DENSITY2 + 4u * GEO4 * WIDTH4;   // WIDTH4 x COLOUR4
const uint COLOUR2 = COLOUR1 + 4u * WIDTH4 * COLOUR4; // 1 x WIDTH4; the fourth output is unused and stays 0
const uint WEIGHT_COLUMNS = 4u * VW_WEIGHT_BLOCKS(ENC4, WIDTH4);

// Activation rows, each with four numbers of a sample: the inputs of the four matrices, the gradients of their outputs,
// and which hidden units are above 0, as bits: two words per layer.
const uint ROW_ENCODING = 0u;
const uint ROW_HIDDEN1 = ROW_ENCODING + ENC4;
const uint ROW_COLOUR_IN = ROW_HIDDEN1 + WIDTH4;
const uint ROW_HIDDEN2 = ROW_COLOUR_IN + COLOUR4;
const uint ROW_D_HIDDEN1 = ROW_HIDDEN2 + WIDTH4;
const uint ROW_D_GEO = ROW_D_HIDDEN1 + WIDTH4;
const uint ROW_D_HIDDEN2 = ROW_D_GEO + GEO4;
const uint ROW_D_LOGIT = ROW_D_HIDDEN2 + WIDTH4;
const uint ROW_ACTIVE1 = ROW_D_LOGIT + 1u;
const uint ROW_ACTIVE2 = ROW_ACTIVE1 + 1u;
const uint ROW_COUNT = VW_ROW_COUNT(ENC4, WIDTH4);

// Rows that scatter_grid reads.
const uint GRID_ROW_D_ENCODING = 0u;
const uint GRID_ROW_POSITION = GRID_ROW_D_ENCODING + ENC4; // w: 0
const uint GRID_ROW_COUNT = VW_GRID_ROW_COUNT(ENC4);

#ifdef WEIGHTS_SHARED // by the passes that evaluate the networks
shared vec4 weight[WEIGHT_COLUMNS];

mat4 weight_block(uint first, uint row, uint columns, uint column) {
    uint at = first + 4u * (row * columns + column);
    return mat4(weight[at], weight[at + 1u], weight[at + 2u], weight[at + 3u]);
}
#endif

#endif
