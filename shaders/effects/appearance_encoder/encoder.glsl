// The network of the effect appearance_encoder: from a photo's thumbnail to its code, as HA-NeRF's convolutional
// encoder (Chen et al., CVPR 2022, section 3.1): convolutions of 3x3 places and stride 2, each followed by a ReLU, with
// inputs beyond the edge equal to 0; the mean over the last one's pixels; a matrix with biases. mix_code computes the
// vector that a code adds to the colour network. Layers count from 0.
#ifndef ENCODER_GLSL
#define ENCODER_GLSL
#include "networks/activations.glsl"

uint side_of(uint layer) { return THUMBNAIL_SIDE >> (layer + 1u); } // side of the layer's output
uint inputs4_of(uint layer) { return layer == 0u ? 1u : ENCODER4; }
uint column_of(uint layer) { return layer == 0u ? 0u : layer == 1u ? ENCODER_LAYER2 : ENCODER_LAYER3; }
uint first_row_of(uint layer) { return layer == 0u ? 0u : layer == 1u ? ENCODER_ROW_LAYER2 : ENCODER_ROW_LAYER3; }

uint row_of(uint layer, uvec2 at, uint out4) {
    return first_row_of(layer) + (at.y * side_of(layer) + at.x) * ENCODER4 + out4;
}
uint block_of(uint layer, uint tap, uint out4, uint in4) {
    return 4u * ((tap * ENCODER4 + out4) * inputs4_of(layer) + in4);
}
uint bias_of(uint layer) { return 4u * ENCODER_TAPS * ENCODER4 * inputs4_of(layer); }

// Returns the input place of a kernel tap for output pixel `at`; beyond the edge one coordinate is -1, or wraps to more
// than any side.
ivec2 place_of(uvec2 at, uint tap) { return ivec2(2u * at) + ivec2(tap % 3u, tap / 3u) - 1; }
bool is_within(ivec2 place, uint side) {
    return all(greaterThanEqual(place, ivec2(0))) && all(lessThan(place, ivec2(side)));
}

#endif
