// The drawn form of every sighting that is seen: its shape, and its colour from the view's direction; variant `depth`:
// in place of the colour the depth along the view's axis, in box edges.
#include "splats/harmonics.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_CAMERAS) readonly buffer Cameras { vw_gpu_camera cameras[]; };
BUFFER(VW_SLOT_SPLATS) readonly buffer Splats { vec4 splats[]; };
BUFFER(VW_SLOT_SPLAT_VIEWS) readonly buffer Views { vw_splat_view views[]; };
BUFFER(VW_SLOT_SPLAT_SHAPES) readonly buffer Shapes { vw_splat_shape shapes[]; };
BUFFER(VW_SLOT_SPLATS_SEEN) readonly buffer Seen { vw_splat_seen splats_seen[]; };
BUFFER(VW_SLOT_SPLAT_STATE) readonly buffer State { vw_splat_state state; };
BUFFER(VW_SLOT_SPLATS_DRAWN) writeonly buffer Drawn { vec4 drawn[]; };
PUSH uniform Push { vw_push_splats push; };

void main() {
    uint rank = invocation_index();
    if (rank >= state.seen) return;
    uint sighting = splats_seen[rank].sighting, splat = sighting % push.count;
    vw_gpu_camera camera = cameras[views[push.first_view + sighting / push.count].camera];
    vec3 seen =
        splats[SPLAT_MEAN * push.stride + splat].xyz - camera.reference.xyz - camera.reference.w * camera.back.xyz;
    vec3 direction = normalize(seen), colour = vec3(0.5);
    for (uint degree = 0u, k = 0u; degree <= push.degree; degree++)
        for (uint end = (degree + 1u) * (degree + 1u); k < end; k++)
            colour += harmonic(k, direction).w * splats[(SPLAT_HARMONICS + k) * push.stride + splat].rgb;
    colour = mix(colour, vec3(0.0), lessThan(colour, vec3(0.0)));
#ifdef VW_DEPTH
    colour = vec3(-dot(seen, camera.back.xyz));
#endif
    vw_splat_shape shape = shapes[sighting];
    drawn[rank * VW_SPLAT_DRAWN4] = shape.centre_conic;
    drawn[rank * VW_SPLAT_DRAWN4 + 1u] = vec4(shape.conic_depth.xy, colour.rg);
    drawn[rank * VW_SPLAT_DRAWN4 + 2u] = vec4(colour.b, 0.0, 0.0, 0.0);
}
