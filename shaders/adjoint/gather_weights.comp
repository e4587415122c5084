// The gradient of MLP weights and sky: of the mean loss, or added to the adjoint by the backward pass. One vec4 column
// per invocation.
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_D_WEIGHTS) readonly buffer DWeights { vec4 d_weights[]; };
BUFFER(VW_SLOT_GATHERED) buffer Gathered { vec4 gathered[]; };
BUFFER(VW_SLOT_STEP_STATE) readonly buffer State { vw_step_state state; };
BUFFER(VW_SLOT_ADJOINT_STATE) readonly buffer AdjointState { vw_adjoint_state adjoint; };
PUSH uniform Push { vw_push_gather push; };

void main() {
    uint column = invocation_index();
    if (column >= push.count) return;
    vec4 gradient = d_weights[column] * INVERSE_RAYS;
    if (push.adds != 0u) gathered[column] += adjoint.unscale * gradient;
    else gathered[column] = state.nonfinite != 0u ? vec4(0.0) : gradient;
}
