// The gradient by the code weights and by the code of the step's photo (the backward pass of mix_code, as in
// update_code): of the mean loss, and 0 for the codes of other photos; or added to the adjoint by that of lasting
// credit, there without the ridge. One workgroup.
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_CODE_WEIGHTS) readonly buffer CodeWeights { vec4 code_weights[]; };
BUFFER(VW_SLOT_CODES) readonly buffer Codes { vec4 codes[]; };
BUFFER(VW_SLOT_D_WEIGHTS) readonly buffer DWeights { vec4 d_weights[]; };
BUFFER(VW_SLOT_GATHERED) buffer Gathered { vec4 gathered[]; };
BUFFER(VW_SLOT_GATHERED_CODES) buffer GatheredCodes { vec4 gathered_codes[]; };
BUFFER(VW_SLOT_STEP_STATE) readonly buffer State { vw_step_state state; };
BUFFER(VW_SLOT_ADJOINT_STATE) readonly buffer AdjointState { vw_adjoint_state adjoint; };
PUSH uniform Push { vw_push_gather push; };

const uint UNITS = 4u * WIDTH4, COUNT = UNITS * CODE4;

float d_shift(uint unit) { return d_weights[SHIFT_COLUMN + SHIFT_STRIDE * (unit / 4u)][unit % 4u] * INVERSE_RAYS; }

void main() {
    uint lane = gl_LocalInvocationID.x, first = CODE4 * state.view;
    bool adds = push.adds != 0u, skipped = !adds && state.nonfinite != 0u;
    for (uint at = lane; at < COUNT; at += 64u) {
        vec4 gradient = skipped ? vec4(0.0) : d_shift(at / CODE4) * codes[first + at % CODE4];
        if (adds) gathered[at] += adjoint.unscale * gradient;
        else gathered[at] = gradient;
    }
    if (!adds)
        for (uint at = lane; at < gathered_codes.length(); at += 64u)
            if (at / CODE4 != state.view) gathered_codes[at] = vec4(0.0);
    if (lane >= CODE4) return;
    vec4 sum = vec4(0.0);
    for (uint unit = 0u; unit < UNITS; unit++) sum += d_shift(unit) * code_weights[CODE4 * unit + lane];
    if (adds) gathered_codes[first + lane] += adjoint.unscale * sum;
    else gathered_codes[first + lane] = skipped ? vec4(0.0) : sum + PHOTO_RIDGE * codes[first + lane];
}
