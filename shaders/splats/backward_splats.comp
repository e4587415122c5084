// The gradient of every splat that is seen: the sum over its pairs in their order, then the way back through the
// projection and the harmonics. Its list of views is of one view.
#include "splats/harmonics.glsl"
#include "splats/projection.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_CAMERAS) readonly buffer Cameras { vw_gpu_camera cameras[]; };
BUFFER(VW_SLOT_SPLATS) readonly buffer Splats { vec4 splats[]; };
BUFFER(VW_SLOT_SPLAT_VIEWS) readonly buffer Views { vw_splat_view views[]; };
BUFFER(VW_SLOT_SPLATS_SEEN) readonly buffer Seen { vw_splat_seen splats_seen[]; };
BUFFER(VW_SLOT_SPLAT_STATE) readonly buffer SplatState { vw_splat_state splat_state; };
BUFFER(VW_SLOT_D_PAIRS) readonly buffer DPairs { vec4 d_pairs[]; };
BUFFER(VW_SLOT_D_SPLATS) writeonly buffer DSplats { vec4 d_splats[]; };
BUFFER(VW_SLOT_STEP_STATE) buffer State { vw_step_state state; };
PUSH uniform Push { vw_push_splats push; };

// Writes the gradient of the coefficients, and adds that of the direction to the mean's.
void colour_back(uint rank, uint splat, vec3 seen, vec3 d_colour, inout vec3 d_mean) {
    float inverse = inversesqrt(dot(seen, seen));
    vec3 direction = seen * inverse, colour = vec3(0.5), d_direction = vec3(0.0);
    uint count = (push.degree + 1u) * (push.degree + 1u);
    for (uint k = 0u; k < count; k++)
        colour += harmonic(k, direction).w * splats[(SPLAT_HARMONICS + k) * push.stride + splat].rgb;
    d_colour = mix(d_colour, vec3(0.0), lessThan(colour, vec3(0.0)));
    for (uint k = 0u; k < count; k++) {
        vec4 basis = harmonic(k, direction);
        d_direction += basis.xyz * dot(d_colour, splats[(SPLAT_HARMONICS + k) * push.stride + splat].rgb);
        d_splats[(SPLAT_HARMONICS + k) * push.stride + rank] = vec4(basis.w * d_colour, 0.0);
    }
    d_mean += inverse * (d_direction - direction * dot(direction, d_direction));
}

void main() {
    uint rank = invocation_index();
    if (rank >= splat_state.seen) return;
    vw_splat_seen own = splats_seen[rank];
    uint splat = own.sighting;
    vec4 one = vec4(0.0), two = vec4(0.0), three = vec4(0.0);
    for (uint i = 0u; i < own.pairs; i++) {
        uint at = (own.first_pair + i) * VW_SPLAT_PAIR4;
        one += d_pairs[at];
        two += d_pairs[at + 1u];
        three += d_pairs[at + 2u];
    }
    vec3 d_colour = vec3(two.zw, three.x);
    vec4 mean = splats[SPLAT_MEAN * push.stride + splat];
    vw_splat_view view = views[push.first_view];
    splat_projection p = project(cameras[view.camera], view, mean.xyz, splats[SPLAT_SCALE * push.stride + splat],
                                 splats[SPLAT_TURN * push.stride + splat]);
    vec3 conic = conic_of(p);
    vec2 d_centre = vec2(conic.x * one.y + conic.y * one.z, conic.y * one.y + conic.z * one.z);
    splat_gradient g = project_back(p, d_centre, vec3(one.w, two.xy));
    colour_back(rank, splat, p.seen, d_colour, g.mean);
    bool touched = one.x != 0.0 || any(notEqual(d_colour, vec3(0.0)));
    vec4 d_mean = vec4(g.mean, one.x * (1.0 - opacity_of(mean.w))), d_scale = vec4(g.scale, touched ? 1.0 : 0.0);
    if (!(finite(d_mean) && finite(d_scale) && finite(g.turn) && finite(vec4(d_colour, 0.0))))
        atomicOr(state.nonfinite, 1u); // the step is not taken
    d_splats[SPLAT_MEAN * push.stride + rank] = d_mean;
    d_splats[SPLAT_SCALE * push.stride + rank] = d_scale;
    d_splats[SPLAT_TURN * push.stride + rank] = g.turn;
}
