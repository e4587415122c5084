// The convolutions' kernels, and the backward pass through one of them (encoder.glsl): for passes that have the buffers
// weights and d_rows.
#ifndef KERNELS_GLSL
#define KERNELS_GLSL
#include "effects/appearance_encoder/encoder.glsl"

mat4 kernel_block(uint layer, uint tap, uint out4, uint in4) {
    uint at = ENCODER_COLUMN + column_of(layer) + block_of(layer, tap, out4, in4);
    return mat4(weights[at], weights[at + 1u], weights[at + 2u], weights[at + 3u]);
}

#ifdef VW_BACK
// Returns the gradient by four inputs at a place: the sum over pixels whose kernels cover it.
vec4 input_gradient(uint layer, uvec2 at, uint in4) {
    vec4 sum = vec4(0.0);
    for (uint tap = 0u; tap < ENCODER_TAPS; tap++) {
        ivec2 twice = ivec2(at) + 1 - ivec2(tap % 3u, tap / 3u);
        if ((twice.x & 1) != 0 || (twice.y & 1) != 0 || !is_within(twice, 2u * side_of(layer))) continue;
        for (uint out4 = 0u; out4 < ENCODER4; out4++)
            sum += d_rows[row_of(layer, uvec2(twice) / 2u, out4)] * kernel_block(layer, tap, out4, in4);
    }
    return sum;
}
#endif

#endif
