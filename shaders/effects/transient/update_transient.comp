// Moves the code of the step's photo that the transient head takes in (photo_adam.glsl). All samples of a step take in
// the same code: so the gradient by it is that by the layer's biases times the matrix that the code is multiplied by,
// which moves later. One workgroup.
#define PHOTO_CODE4 TRANSIENT_CODE4
#define PHOTO_CODES VW_SLOT_TRANSIENT_CODES
#define PHOTO_CODE_MOMENTS VW_SLOT_TRANSIENT_CODE_MOMENTS
#define PHOTO_MOMENTS_TYPE vw_transient_moments
#include "networks/photo_adam.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_WEIGHTS) readonly buffer Weights { vec4 weights[]; };
BUFFER(VW_SLOT_D_WEIGHTS) readonly buffer DWeights { vec4 d_weights[]; };
BUFFER(VW_SLOT_STEP_STATE) readonly buffer State { vw_step_state state; };

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
    if (state.nonfinite != 0u) return; // in all invocations alike: the step is skipped
    uint visits = next_visit(moments[state.view].visits);
    memoryBarrierBuffer();
    barrier(); // all have read the visits
    if (k >= TRANSIENT_CODE4) return;
    if (k == 0u) moments[state.view].visits = visits;
    move_code(state.view, k, visits, code_gradient(k));
}
