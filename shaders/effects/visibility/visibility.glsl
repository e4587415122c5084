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

// Returns the weight at the step of the key. A pixel is ignored entirely if its loss reaches twice the weight, which
// happens at the same error under each loss.
float size_weight(uvec4 key) {
    float number = float(key.z) + 4294967296.0 * float(key.w);
    float of_squares = max(SIZE_WEIGHT_LEAST, SIZE_WEIGHT_MOST * exp(-SIZE_WEIGHT_RATE * number));
    if (LOSS == LOSS_L2) return of_squares;
    float value, slope;
    loss_channel(sqrt(2.0 * of_squares), value, slope);
    return 0.5 * value;
}

#ifdef VISIBILITY_NETWORK // by the passes that evaluate it
#include "networks/activations.glsl"
#include "field_mlp/positional_encoding.glsl"

BUFFER(VW_SLOT_PIXELS) readonly buffer Pixels { vw_pixel pixels[]; };
BUFFER(VW_SLOT_PHOTO_SCALES) readonly buffer PhotoScales { vec2 photo_scales[]; };
BUFFER(VW_SLOT_WEIGHTS) readonly buffer Weights { vec4 all_weights[]; };
BUFFER(VW_SLOT_VISIBILITY_CODES) readonly buffer Codes { vec4 codes[]; };
BUFFER(VW_SLOT_STEP_STATE) readonly buffer State { vw_step_state state; };

shared vec4 weight[VISIBILITY_COLUMNS];
shared vec4 code[VISIBILITY_CODE4];

// Loads the network once per workgroup; all of its invocations call this.
void load_network(uint lane, uint lanes) {
    for (uint i = lane; i < VISIBILITY_COLUMNS; i += lanes) weight[i] = all_weights[VISIBILITY_COLUMN + i];
    if (lane < VISIBILITY_CODE4) code[lane] = codes[VISIBILITY_CODE4 * state.view + lane];
    barrier();
}

mat4 weight_block(uint first, uint row, uint columns, uint column) {
    uint at = first + 4u * (row * columns + column);
    return mat4(weight[at], weight[at + 1u], weight[at + 2u], weight[at + 3u]);
}

// Encodes the network's inputs for a pixel, except its photo's code: the place, -1 to 1 across the photo, and a
// constant for the biases; then per frequency the sines and the cosines of both coordinates.
void encode_place(vw_pixel pixel, out vec4 inputs[VISIBILITY_PLACE4]) {
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

float visibility_logit(vec4 inputs[VISIBILITY_PLACE4], out vec4 hidden1[VISIBILITY4], out vec4 hidden2[VISIBILITY4]) {
    float logit = weight[VISIBILITY_LOGIT + VISIBILITY4].x;
    [[unroll]] for (uint row = 0u; row < VISIBILITY4; row++) {
        vec4 sum = vec4(0.0);
        [[unroll]] for (uint k = 0u; k < VISIBILITY_PLACE4; k++) sum +=
            weight_block(0u, row, VISIBILITY_INPUT4, k) * inputs[k];
        [[unroll]] for (uint k = 0u; k < VISIBILITY_CODE4; k++) sum +=
            weight_block(0u, row, VISIBILITY_INPUT4, VISIBILITY_PLACE4 + k) * code[k];
        hidden1[row] = rectify(sum);
    }
    [[unroll]] for (uint row = 0u; row < VISIBILITY4; row++) {
        vec4 sum = weight[VISIBILITY_BIAS2 + row];
        [[unroll]] for (uint k = 0u; k < VISIBILITY4; k++) sum +=
            weight_block(VISIBILITY_LAYER2, row, VISIBILITY4, k) * hidden1[k];
        hidden2[row] = rectify(sum);
        logit += dot(weight[VISIBILITY_LOGIT + row], hidden2[row]);
    }
    return logit;
}

// Converts the gradient by the logit to the gradients by the sums before each layer's ReLU.
void visibility_back(float d_logit, vec4 hidden1[VISIBILITY4], vec4 hidden2[VISIBILITY4], out vec4 d_sum1[VISIBILITY4],
                     out vec4 d_sum2[VISIBILITY4]) {
    [[unroll]] for (uint row = 0u; row < VISIBILITY4; row++) d_sum2[row] =
        mix(vec4(0.0), d_logit * weight[VISIBILITY_LOGIT + row], greaterThan(hidden2[row], vec4(0.0)));
    [[unroll]] for (uint k = 0u; k < VISIBILITY4; k++) {
        vec4 sum = vec4(0.0);
        [[unroll]] for (uint row = 0u; row < VISIBILITY4; row++) sum +=
            d_sum2[row] * weight_block(VISIBILITY_LAYER2, row, VISIBILITY4, k);
        d_sum1[k] = mix(vec4(0.0), sum, greaterThan(hidden1[k], vec4(0.0)));
    }
}
#endif

#endif
