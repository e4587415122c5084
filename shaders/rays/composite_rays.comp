// One validation or rendering ray per RAY_LANES invocations: its colour before the backdrop (sky or background), and
// the transmittance that remains. Variant `depth`: in place of the colour the sum of weights times distances, as t of
// vw_ray.
#define SEES_SKY
#include "effects/seen.glsl"
#include "rays/composite.glsl"
#include "rays/ray_lanes.glsl"
#include "rays/sample_places.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_RAYS) readonly buffer Rays { vw_ray rays[]; };
BUFFER(VW_SLOT_FIELD) readonly buffer Field { vec4 field[]; };
BUFFER(VW_SLOT_COLOURS) writeonly buffer Colours { vec4 colours[]; };
PUSH uniform Push { vw_push_samples push; };

#ifdef VW_DEPTH
vec4 sample_at(vw_ray ray, uint ray_index, uint at, uint i) {
    return vec4(vec3(distance_at(ray, sample_place(at, ray_index, i, push.key))), field[at].w);
}
#else
#define sample_at(ray, ray_index, at, i) field[at]
#endif

void main() {
    uint index = invocation_index() / RAY_LANES;
    bool beyond = index >= push.ray_count;
    if (RAY_LANES == 1u && beyond) return;
    if (beyond) index = push.ray_count - 1u; // such lanes meet the others at barriers
    uint ray_index = push.first_ray + index, first = index * SAMPLES, begin, end;
    vw_ray ray = rays[ray_index];
    lane_run(SAMPLES, begin, end);
    ray_march forward = ray_march(0.0, vec3(0.0));
    vec4 all;
    if (RAY_LANES > 1u) {
        float tau = 0.0;
        for (uint i = begin; i < end; i++) tau += field[first + i].w * sample_length(ray, first + i, i);
        forward.tau = sum_beside(vec4(tau), false, all).x;
    }
    for (uint i = begin; i < end; i++)
        march(forward, sample_at(ray, ray_index, first + i, i), sample_length(ray, first + i, i));
    if (RAY_LANES > 1u) {
        forward.tau = all.x;
        sum_beside(vec4(forward.colour, 0.0), false, all);
        forward.colour = all.rgb;
    }
    if (RAY_LANES > 1u && (beyond || ray_lane() > 0u)) return;
    float left = transmittance(forward.tau);
#ifdef VW_DEPTH
    colours[ray_index] = vec4(forward.colour, left);
#else
    vec3 backdrop = backdrop_colour(ray, ray_index, push.key);
    colours[ray_index] = vec4(forward.colour + left * backdrop, left);
#endif
}
