// Visibility of the field at a pixel (Chen et al., "Hallucinated Neural Radiance Fields in the Wild", CVPR 2022,
// equations 6 and 7): a small network M of the pixel's place in its photo and of a code of the photo, with a sigmoid at
// its end. A ray's loss is
//   M * loss + size_weight * (1 - M)^2,
// so that an object in front of the scene in a single photo is ignored, but only if that saves more than it costs.
#ifndef VISIBILITY_GLSL
#define VISIBILITY_GLSL
#include "rays/loss.glsl"

// The published weight: 0.05 at first, then falling by a factor of e per 1,000 steps, to 0.006 at least; of squared
// errors.
const float SIZE_WEIGHT_MOST = 5e-2, SIZE_WEIGHT_LEAST = 6e-3, SIZE_WEIGHT_RATE = 1e-3;

// Returns the weight at the step of the key, before it reaches the least.
float early_square(uvec4 key) {
    float number = float(key.z) + 4294967296.0 * float(key.w);
    return SIZE_WEIGHT_MOST * exp(-SIZE_WEIGHT_RATE * number);
}

// Returns the weight at the step of the key. A pixel is ignored entirely if its loss reaches twice the weight, which
// happens at the same error under each loss.
float size_weight(uvec4 key) {
    float of_squares = max(SIZE_WEIGHT_LEAST, early_square(key));
    if (LOSS == LOSS_L2) return of_squares;
    float value, slope;
    loss_channel(sqrt(2.0 * of_squares), value, slope);
    return 0.5 * value;
}

#ifdef RAY_NETWORK // the inputs of ray_network.glsl: a pixel's place, and its photo's code
#include "field_mlp/positional_encoding.glsl"

BUFFER(VW_SLOT_PIXELS) readonly buffer Pixels { vw_pixel pixels[]; };
BUFFER(VW_SLOT_PHOTO_SCALES) readonly buffer PhotoScales { vec2 photo_scales[]; };
BUFFER(VW_SLOT_VISIBILITY_CODES) readonly buffer Codes { vec4 codes[]; };
BUFFER(VW_SLOT_STEP_STATE) readonly buffer State { vw_step_state state; };

#define NETWORK_CODE4 VISIBILITY_CODE4
const uint NETWORK_RAY4 = VISIBILITY_PLACE4, NETWORK_INPUT4 = VISIBILITY_INPUT4;

vec4 photo_code(uint k) { return codes[VISIBILITY_CODE4 * state.view + k]; }

// Encodes the place of a pixel, -1 to 1 across the photo, and a constant for the biases; then per frequency the sines
// and the cosines of both coordinates.
void encode_pixel(uint index, out vec4 inputs[NETWORK_RAY4]) {
    vw_pixel pixel = pixels[index];
    vec2 place = vec2(pixel.x_px, pixel.y_px) * photo_scales[state.view] - 1.0;
    vec3 flat_place = vec3(place, 0.0);
    inputs[0] = vec4(place, 1.0, 0.0);
    [[unroll]] for (uint k = 0u; k < VISIBILITY_FREQUENCIES;
                    k++) { // four of its six numbers: without the third coordinate
        inputs[1u + k].x = encoded(flat_place, 3u + 6u * k, VISIBILITY_FREQUENCIES);
        inputs[1u + k].y = encoded(flat_place, 4u + 6u * k, VISIBILITY_FREQUENCIES);
        inputs[1u + k].z = encoded(flat_place, 6u + 6u * k, VISIBILITY_FREQUENCIES);
        inputs[1u + k].w = encoded(flat_place, 7u + 6u * k, VISIBILITY_FREQUENCIES);
    }
}
#endif

#endif
