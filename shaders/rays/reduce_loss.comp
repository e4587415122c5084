// Computes the report of a step: its training loss, summed over rays by one workgroup in a fixed order, and the flags
// of all its passes, which it clears: so the next step may begin beside this one's validation.
#include "two_float.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_RAY_LOSS) readonly buffer RayLoss { float ray_loss[]; };
BUFFER(VW_SLOT_STEP_STATE) buffer State { vw_step_state state; };
BUFFER(VW_SLOT_OVERFLOW) buffer Overflow { uint overflow[]; };
BUFFER(VW_SLOT_SCALARS) writeonly buffer Scalars { vec4 scalars[]; };
PUSH uniform Push { vw_push_reduce push; };

shared vec2 sums[64];

void main() {
    uint lane = gl_LocalInvocationID.x;
    vec2 sum = vec2(0.0);
    for (uint i = lane; i < push.count; i += 64u) sum = two_add(sum, vec2(ray_loss[i], 0.0));
    sums[lane] = sum;
    barrier();
    if (lane != 0u) return;
    for (uint i = 1u; i < 64u; i++) sum = two_add(sum, sums[i]);
    bool sound = finite(sum.x) && state.nonfinite == 0u;
    for (uint i = 0u; i < overflow.length(); i += VW_OVERFLOW_STRIDE) {
        sound = sound && overflow[i] == 0u;
        overflow[i] = 0u;
    }
    // Counts are written as floats, since small integers' bits would be denormal ones.
    bool reports = push.scalar_row != VW_NO_ROW;
    if (reports) scalars[push.scalar_row] = vec4(sum, sound ? 0.0 : 1.0, float(state.clamped));
    state.skipped = state.nonfinite | (reports ? 0u : state.skipped);
    state.nonfinite = 0u;
    state.clamped = 0u;
}
