// One validation or rendering ray per invocation: its colour before the backdrop (sky or background), and the
// transmittance that remains. Variant `depth`: in place of the colour the sum of weights times distances, as t of
// vw_ray.
#define SEES_SKY
#include "effects/seen.glsl"
#include "rays/composite.glsl"
#include "rays/sample_places.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_RAYS) readonly buffer Rays { vw_ray rays[]; };
BUFFER(VW_SLOT_FIELD) readonly buffer Field { vec4 field[]; };
BUFFER(VW_SLOT_COLOURS) writeonly buffer Colours { vec4 colours[]; };
PUSH uniform Push { vw_push_samples push; };

void main() {
    uint index = invocation_index();
    if (index >= push.ray_count) return;
    uint ray_index = push.first_ray + index;
    vw_ray ray = rays[ray_index];
    ray_march forward = ray_march(0.0, vec3(0.0));
#ifdef VW_DEPTH
    for (uint i = 0u; i < SAMPLES; i++) {
        uint at = index * SAMPLES + i;
        vec3 seen = vec3(distance_at(ray, sample_place(at, ray_index, i, push.key)));
        march(forward, vec4(seen, field[at].w), sample_length(ray, at, i));
    }
    colours[ray_index] = vec4(forward.colour, transmittance(forward.tau));
#else
    for (uint i = 0u; i < SAMPLES; i++)
        march(forward, field[index * SAMPLES + i], sample_length(ray, index * SAMPLES + i, i));
    float left = transmittance(forward.tau);
    vec3 backdrop = backdrop_colour(ray, ray_index, push.key);
    colours[ray_index] = vec4(forward.colour + left * backdrop, left);
#endif
}
