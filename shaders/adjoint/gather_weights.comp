#version 460
#extension GL_GOOGLE_include_directive : require
// The gradient of MLP weights and sky: of the mean loss, or added to the adjoint by the backward sweep. One vec4 column
// per invocation.
#include "common.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_D_WEIGHTS) readonly buffer DWeights { vec4 d_weights[]; };
BUFFER(VW_SLOT_GATHERED) buffer Gathered { vec4 gathered[]; };
BUFFER(VW_SLOT_STEP_STATE) readonly buffer State { vw_step_state state; };
BUFFER(VW_SLOT_SWEEP_STATE) readonly buffer Sweep { vw_sweep_state sweep; };
PUSH uniform Push { vw_push_gather push; };

void main() {
    uint column = invocation_index();
    if (column >= push.count) return;
    vec4 gradient = d_weights[column] * INVERSE_RAYS;
    if (push.adds != 0u) gathered[column] += sweep.unscale * gradient;
    else gathered[column] = state.nonfinite != 0u ? vec4(0.0) : gradient;
}
