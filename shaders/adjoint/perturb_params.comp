// The params a little ahead along the direction, or behind. One vec4 of the block per invocation.
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_PARAMS_BEFORE) readonly buffer Before { vec4 before[]; };
BUFFER(VW_SLOT_DIRECTION) readonly buffer Direction { vec4 direction[]; };
BUFFER(VW_SLOT_ADJOINT_STATE) readonly buffer AdjointState { vw_adjoint_state adjoint; };
BUFFER(VW_SLOT_PARAMS) writeonly buffer Params { vec4 params[]; };
PUSH uniform Push { vw_push_block push; };

void main() {
    uint i = invocation_index();
    if (i < push.count) params[i] = before[i] + push.sign * adjoint.epsilon * direction[i];
}
