#version 460
#extension GL_GOOGLE_include_directive : require
// Moves the code of the step's photo that the transient head takes in; those of other photos stay, as their gains do
// (update_appearance). All samples of a step take in the same code: so the gradient by it is that by the layer's biases
// times the matrix that the code is multiplied by, which moves later. One workgroup.
#include "common.glsl"
#include "effects/appearance.glsl"
#include "networks/adam.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_WEIGHTS) readonly buffer Weights { vec4 weights[]; };
BUFFER(VW_SLOT_D_WEIGHTS) readonly buffer DWeights { vec4 d_weights[]; };
BUFFER(VW_SLOT_TRANSIENT_CODES) buffer Codes { vec4 codes[]; };
BUFFER(VW_SLOT_TRANSIENT_CODE_MOMENTS) buffer Moments { vw_transient_moments moments[]; };
BUFFER(VW_SLOT_STEP_STATE) readonly buffer State { vw_step_state state; };
BUFFER(VW_SLOT_OVERFLOW) writeonly buffer Overflow { uint overflow; };
PUSH uniform Push { vw_push_update push; };

vec4 code_gradient(uint k) {
    vec4 sum = vec4(0.0);
    for (uint j = 0u; j < TRANSIENT_WIDTH4; j++) {
        uint at = TRANSIENT_COLUMN + 4u * (j * TRANSIENT_CODE4 + k);
        sum += d_weights[TRANSIENT_BIAS + j] * mat4(weights[at], weights[at + 1u], weights[at + 2u], weights[at + 3u]);
    }
    return sum * INVERSE_RAYS;
}

void main() {
    uint k = gl_LocalInvocationID.x;
    if (state.nonfinite != 0u) return; // of all invocations alike: the step is skipped
    uint visits = min(moments[state.view].visits, 0x7FFFFFFEu) + 1u;
    barrier(); // all have read the visits
    if (k >= TRANSIENT_CODE4) return;
    if (k == 0u) moments[state.view].visits = visits;
    vec4 code = codes[TRANSIENT_CODE4 * state.view + k];
    vec4 moment1 = moments[state.view].moment1[k], moment2 = moments[state.view].moment2[k];
    vec4 gradient = code_gradient(k) + PHOTO_RIDGE * code;
    vec4 moved = code - (1.0 + push.extra) * photo_rate(visits) * adam_step(gradient, visits, moment1, moment2);
    if (!finite(moved)) { // as in update_weights
        overflow = 1u;
        return;
    }
    codes[TRANSIENT_CODE4 * state.view + k] = moved;
    moments[state.view].moment1[k] = moment1;
    moments[state.view].moment2[k] = moment2;
}
