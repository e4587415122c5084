// The sky's gradient, one workgroup per coefficient: d_sky_k = sum over rays of basis_k(direction) d_logit, in a fixed
// order: each invocation sums every 64th ray, then the first adds the 64 sums. It follows the gradient of the networks'
// weights, and update_weights moves both. A non-finite value marks the step.
#include "effects/sky/sky.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_RAYS) readonly buffer Rays { vw_ray rays[]; };
BUFFER(VW_SLOT_D_SKY) readonly buffer DSky { vec4 d_logits[]; };
BUFFER(VW_SLOT_D_WEIGHTS) writeonly buffer DWeights { vec4 d_weights[]; };
BUFFER(VW_SLOT_STEP_STATE) buffer State { vw_step_state state; };
PUSH uniform Push { vw_push_reduce push; };

shared vec4 sums[64];

void main() {
    uint k = workgroup_index();
    uint lane = gl_LocalInvocationID.x;
    vec4 sum = vec4(0.0);
    for (uint i = lane; i < push.count; i += 64u) sum += sky_basis(rays[i].direction_stride.xyz, k) * d_logits[i];
    sums[lane] = sum;
    barrier();
    if (lane != 0u) return;
    for (uint i = 1u; i < 64u; i++) sum += sums[i];
    d_weights[FIELD_COLUMNS + k] = sum;
    if (!finite(sum)) atomicOr(state.nonfinite, 1u);
}
