// The backward pass of mix_code, and the step: the gradient by the vector that was added is that by the weights it was
// added to, of which follow those by the code weights (vector x code) and by the photo's code (code weights transposed
// times vector). The code weights move at every step, the code lazily. One workgroup.
#define PHOTO_CODE4 CODE4
#define PHOTO_CODES VW_SLOT_CODES
#define PHOTO_CODE_MOMENTS VW_SLOT_CODE_MOMENTS
#define PHOTO_MOMENTS_TYPE vw_code_moments
#include "networks/photo_adam.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_CODE_WEIGHTS) buffer CodeWeights { vec4 code_weights[]; };
BUFFER(VW_SLOT_D_WEIGHTS) readonly buffer DWeights { vec4 d_weights[]; };
BUFFER(VW_SLOT_CODE_WEIGHT_MOMENTS) buffer WeightMoments { vec4 weight_moments[]; };
BUFFER(VW_SLOT_STEP_STATE) readonly buffer State { vw_step_state state; };

const uint UNITS = 4u * WIDTH4, COUNT = UNITS * CODE4;
shared vec4 code[CODE4];
shared float d_shift[UNITS];

// Returns the gradient by the code, with the code weights of the forward pass.
vec4 code_gradient(uint k) {
    vec4 sum = vec4(0.0);
    for (uint unit = 0u; unit < UNITS; unit++) sum += d_shift[unit] * code_weights[CODE4 * unit + k];
    return sum;
}

void move_weights(uint at) {
    vec4 gradient = d_shift[at / CODE4] * code[at % CODE4], moment1 = weight_moments[at],
         moment2 = weight_moments[COUNT + at];
    vec4 moved =
        code_weights[at] - (1.0 + push.extra) * adam_step(push.adam, gradient, push.step_low, moment1, moment2);
    if (!stays_finite(finite(moved))) return;
    code_weights[at] = moved;
    weight_moments[at] = moment1;
    weight_moments[COUNT + at] = moment2;
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    if (state.nonfinite != 0u) return; // in all invocations alike: the step is skipped
    if (lane < CODE4) code[lane] = codes[CODE4 * state.view + lane];
    for (uint unit = lane; unit < UNITS; unit += 64u)
        d_shift[unit] = d_weights[SHIFT_COLUMN + SHIFT_STRIDE * (unit / 4u)][unit % 4u] * INVERSE_RAYS;
    barrier();
    vec4 d_code = lane < CODE4 ? code_gradient(lane) : vec4(0.0);
    memoryBarrierBuffer();
    barrier(); // all have read the code weights
    for (uint at = lane; at < COUNT; at += 64u) move_weights(at);
    if (lane < CODE4) move_code(state.view, lane, next_visit(moments[state.view].visits), d_code);
    memoryBarrierBuffer();
    barrier(); // all have read the visits
    if (lane == 0u) moments[state.view].visits = next_visit(moments[state.view].visits);
}
