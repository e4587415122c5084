// Floats as halves: binary16 of IEEE 754, as `--table-precision float16` keeps the hash grid.
// shaders/field_hash/grid_pair.glsl does the same.
#ifndef VIEWWORTH_TRAIN_HALF_H
#define VIEWWORTH_TRAIN_HALF_H

#include <stdint.h>

// Returns the bits of the half nearest to `value`, of two the even one; infinity for values that round beyond the
// largest (65504), and for NaN.
uint16_t vw_half_nearest(float value);

#endif
