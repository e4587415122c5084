// The network that says how much a ray counts: two hidden layers of 16 units and a logit. Its inputs are those of
// visibility or, in variants VW_UNCERTAINTY, of uncertainty; of the former the photo's code is the same for all rays.
#ifndef RAY_NETWORK_GLSL
#define RAY_NETWORK_GLSL
#define RAY_NETWORK
#ifdef VW_UNCERTAINTY
#include "effects/uncertainty/uncertainty.glsl"
#else
#include "effects/visibility/visibility.glsl"
#endif
#include "networks/activations.glsl"

BUFFER(VW_SLOT_WEIGHTS) readonly buffer Weights { vec4 all_weights[]; };

const uint NETWORK_LAYER2 = 4u * VISIBILITY4 * NETWORK_INPUT4,
           NETWORK_BIAS2 = NETWORK_LAYER2 + 4u * VISIBILITY4 * VISIBILITY4, NETWORK_LOGIT = NETWORK_BIAS2 + VISIBILITY4,
           NETWORK_COLUMNS = NETWORK_LOGIT + VISIBILITY4 + 1u;

shared vec4 weight[NETWORK_COLUMNS];
#ifdef NETWORK_CODE4
shared vec4 code[NETWORK_CODE4];
#endif

// Loads the network once per workgroup; all of its invocations call this.
void load_network(uint lane, uint lanes) {
    for (uint i = lane; i < NETWORK_COLUMNS; i += lanes) weight[i] = all_weights[VISIBILITY_COLUMN + i];
#ifdef NETWORK_CODE4
    if (lane < NETWORK_CODE4) code[lane] = photo_code(lane);
#endif
    barrier();
}

mat4 weight_block(uint first, uint row, uint columns, uint column) {
    uint at = first + 4u * (row * columns + column);
    return mat4(weight[at], weight[at + 1u], weight[at + 2u], weight[at + 3u]);
}

float network_logit(vec4 inputs[NETWORK_RAY4], out vec4 hidden1[VISIBILITY4], out vec4 hidden2[VISIBILITY4]) {
    float logit = weight[NETWORK_LOGIT + VISIBILITY4].x;
    [[unroll]] for (uint row = 0u; row < VISIBILITY4; row++) {
        vec4 sum = vec4(0.0);
        [[unroll]] for (uint k = 0u; k < NETWORK_RAY4; k++) sum += weight_block(0u, row, NETWORK_INPUT4, k) * inputs[k];
#ifdef NETWORK_CODE4
        [[unroll]] for (uint k = 0u; k < NETWORK_CODE4; k++) sum +=
            weight_block(0u, row, NETWORK_INPUT4, NETWORK_RAY4 + k) * code[k];
#endif
        hidden1[row] = rectify(sum);
    }
    [[unroll]] for (uint row = 0u; row < VISIBILITY4; row++) {
        vec4 sum = weight[NETWORK_BIAS2 + row];
        [[unroll]] for (uint k = 0u; k < VISIBILITY4; k++) sum +=
            weight_block(NETWORK_LAYER2, row, VISIBILITY4, k) * hidden1[k];
        hidden2[row] = rectify(sum);
        logit += dot(weight[NETWORK_LOGIT + row], hidden2[row]);
    }
    return logit;
}

// Converts the gradient by the logit to the gradients by the sums before each layer's ReLU.
void network_back(float d_logit, vec4 hidden1[VISIBILITY4], vec4 hidden2[VISIBILITY4], out vec4 d_sum1[VISIBILITY4],
                  out vec4 d_sum2[VISIBILITY4]) {
    [[unroll]] for (uint row = 0u; row < VISIBILITY4; row++) d_sum2[row] =
        mix(vec4(0.0), d_logit * weight[NETWORK_LOGIT + row], greaterThan(hidden2[row], vec4(0.0)));
    [[unroll]] for (uint k = 0u; k < VISIBILITY4; k++) {
        vec4 sum = vec4(0.0);
        [[unroll]] for (uint row = 0u; row < VISIBILITY4; row++) sum +=
            d_sum2[row] * weight_block(NETWORK_LAYER2, row, VISIBILITY4, k);
        d_sum1[k] = mix(vec4(0.0), sum, greaterThan(hidden1[k], vec4(0.0)));
    }
}

#endif
