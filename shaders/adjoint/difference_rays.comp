// The curvature product at the colours of training rays: first the colours ahead along the direction, then those
// behind; their difference times the loss's curvature is the slope from which the gradient is taken back, and replaces
// the ray's target. One ray per invocation. Variant VW_RAY_EFFECTS: sky and visibility, as in backward_rays; how
// visible a ray is, is held fixed.
#include "effects/seen.glsl"
#include "rays/composite.glsl"
#include "rays/loss.glsl"
#include "rays/sample_places.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_RAYS) buffer Rays { vw_ray rays[]; };
BUFFER(VW_SLOT_FIELD) readonly buffer Field { vec4 field[]; };
BUFFER(VW_SLOT_SEEN_AHEAD) buffer SeenAhead { vec4 seen_ahead[]; };
BUFFER(VW_SLOT_ADJOINT_STATE) readonly buffer AdjointState { vw_adjoint_state adjoint; };
PUSH uniform Push { vw_push_difference push; };

#ifdef VW_RAY_EFFECTS
BUFFER(VW_SLOT_VISIBILITY) readonly buffer Visibility { vec2 visibility[]; };
#endif

vec3 seen_colour(vw_ray ray, uint index, uint ray_index) {
    uint first = index * SAMPLES;
    ray_march forward = ray_march(0.0, vec3(0.0));
    for (uint i = 0u; i < SAMPLES; i++) march(forward, field[first + i], sample_length(ray, first + i, i));
    vec3 backdrop = backdrop_colour(ray, ray_index, push.key);
    return forward.colour + transmittance(forward.tau) * backdrop;
}

void main() {
    uint index = invocation_index();
    if (index >= push.ray_count) return;
    uint ray_index = push.first_ray + index;
    vw_ray ray = rays[ray_index];
    vec3 seen = seen_colour(ray, index, ray_index);
    if (push.ahead != 0u) {
        seen_ahead[ray_index] = vec4(seen, 0.0);
        return;
    }
    vec3 ahead = seen_ahead[ray_index].rgb, error = 0.5 * (ahead + seen) - ray.target_weight.rgb;
    float inverse = adjoint.epsilon > 0.0 && ray.target_weight.w != 0.0 ? 0.5 / adjoint.epsilon : 0.0;
    vec3 curvature = vec3(loss_curvature(error.r), loss_curvature(error.g), loss_curvature(error.b));
#ifdef VW_RAY_EFFECTS
    if (EFFECT_VISIBILITY != 0u) curvature *= visibility[ray_index].x;
#endif
    rays[ray_index].target_weight.rgb = curvature * (inverse * (ahead - seen));
}
