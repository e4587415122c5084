// Uncertainty of a pixel by its features (Ren et al., "NeRF On-the-go", CVPR 2024): a small network, the same for all
// photos, says which error a pixel has to be expected to have, as a standard deviation beta. Published is the loss
//   loss / (2 beta^2) + log beta,
// which weighs the pixel. Times twice the square of the least beta, and with certain = (least beta / beta)^2, it is
//   certain * loss - certain_loss * log certain,
// the loss itself where a pixel is certain (ray_weights.glsl). A logistic function keeps `certain` between 0 and 1,
// where the paper has a softplus and a floor. Best is certain = certain_loss / loss: a pixel counts the less the larger
// its loss is, where its features tell it from pixels of small loss.
#ifndef UNCERTAINTY_GLSL
#define UNCERTAINTY_GLSL

BUFFER(VW_SLOT_FEATURES) readonly buffer Features { vec4 features[]; };

const uint NETWORK_RAY4 = FEATURE4, NETWORK_INPUT4 = FEATURE4;

void encode_pixel(uint index, out vec4 inputs[NETWORK_RAY4]) {
    [[unroll]] for (uint k = 0u; k < FEATURE4; k++) inputs[k] = features[FEATURE4 * index + k];
}

#endif
