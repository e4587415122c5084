// Adds the partial sums of direct_adjoint or multiply_blocks in order: the step's credit and the size of its adjoint,
// to the host, and half the distance of the two states between which colours are differentiated.
#include "two_float.glsl"
layout(local_size_x = 1) in;

BUFFER(VW_SLOT_ADJOINT_SUMS) readonly buffer Sums { vec4 sums[]; };
BUFFER(VW_SLOT_STEP_STATE) readonly buffer State { vw_step_state state; };
BUFFER(VW_SLOT_ADJOINT_STATE) buffer AdjointState { vw_adjoint_state adjoint; };
BUFFER(VW_SLOT_SCALARS) writeonly buffer Scalars { vec4 scalars[]; };
PUSH uniform Push { vw_push_reduce push; };

// Relative to the params: colours are differentiated to 1e-4 or better for 1e-5 to 1e-2.
const float STRIDE = 1e-3;

void main() {
    vec2 credit = vec2(0.0);
    vec3 square = vec3(0.0);
    for (uint i = 0u; i < push.count; i++) {
        credit = two_add(credit, sums[2u * i].xy);
        square += sums[2u * i + 1u].xyz;
    }
    adjoint.epsilon = square.x > 0.0 ? STRIDE * sqrt(square.y / square.x) : 0.0;
    scalars[push.scalar_row] = vec4(credit, sqrt(square.z), state.skipped == 0u ? 0.0 : 1.0);
}
