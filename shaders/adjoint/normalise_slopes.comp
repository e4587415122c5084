// Brings the largest slope of the rays to 1, for which the fixed-point range of gradients is made, and keeps by how
// much. One workgroup.
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_RAYS) buffer Rays { vw_ray rays[]; };
BUFFER(VW_SLOT_STEP_STATE) buffer State { vw_step_state state; };
BUFFER(VW_SLOT_ADJOINT_STATE) buffer AdjointState { vw_adjoint_state adjoint; };
PUSH uniform Push { vw_push_slopes push; };

shared float largest[64];

void main() {
    uint lane = gl_LocalInvocationID.x;
    float most = 0.0;
    bool known = true;
    for (uint i = lane; i < push.count; i += 64u) {
        vec3 size = abs(rays[i].target_weight.rgb);
        known = known && finite(vec4(size, 0.0));
        most = max(most, max(size.r, max(size.g, size.b)));
    }
    if (!known) atomicOr(state.nonfinite, 1u);
    largest[lane] = most;
    barrier();
    for (uint i = 0u; i < 64u; i++) most = max(most, largest[i]);
    float scale = most > 0.0 ? 1.0 / most : 0.0;
    for (uint i = lane; i < push.count; i += 64u) rays[i].target_weight.rgb *= scale;
    if (lane == 0u) adjoint.unscale = push.unscale * most;
}
