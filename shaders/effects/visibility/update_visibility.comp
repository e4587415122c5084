// Moves the code by which the network of visibility knows the step's photo (photo_adam.glsl). The gradient
// by the sums in the first layer is that by its biases, since their input is 1; from there it goes back through the
// code's weights, which update_weights has not moved yet. One workgroup.
#define PHOTO_CODE4 VISIBILITY_CODE4
#define PHOTO_CODES VW_SLOT_VISIBILITY_CODES
#define PHOTO_CODE_MOMENTS VW_SLOT_VISIBILITY_MOMENTS
#define PHOTO_MOMENTS_TYPE vw_visibility_moments
#include "networks/photo_adam.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_WEIGHTS) readonly buffer Weights { vec4 weights[]; };
BUFFER(VW_SLOT_D_WEIGHTS) readonly buffer DWeights { vec4 d_weights[]; };
BUFFER(VW_SLOT_STEP_STATE) readonly buffer State { vw_step_state state; };

const uint BIAS_INPUT = 2u; // which input is the constant

vec4 code_gradient(uint k) {
    vec4 sum = vec4(0.0);
    for (uint row = 0u; row < VISIBILITY4; row++) {
        uint first = VISIBILITY_COLUMN + 4u * row * VISIBILITY_INPUT4, at = first + 4u * (VISIBILITY_PLACE4 + k);
        sum += d_weights[first + BIAS_INPUT] * mat4(weights[at], weights[at + 1u], weights[at + 2u], weights[at + 3u]);
    }
    return sum * INVERSE_RAYS;
}

void main() {
    uint k = gl_LocalInvocationID.x, view = state.view;
    if (state.nonfinite != 0u) return; // in all invocations alike: the step is skipped
    uint visits = next_visit(moments[view].visits);
    memoryBarrierBuffer();
    barrier(); // all have read the visits
    if (k == 0u) moments[view].visits = visits;
    if (k >= VISIBILITY_CODE4) return;
    vec4 moment1 = moments[view].moment1[k], moment2 = moments[view].moment2[k];
    vec4 by = photo_rate(visits) * adam_step(push.adam, code_gradient(k), visits, moment1, moment2);
    vec4 moved = codes[VISIBILITY_CODE4 * view + k] - (1.0 + push.extra) * by;
    store_code(view, k, moved, moment1, moment2);
}
