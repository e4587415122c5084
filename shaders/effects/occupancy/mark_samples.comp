// Marks a ray's samples in occupied cells as bits, and counts them; one ray per invocation. Only this pass decides: two
// passes that compute the same position need not round alike.
#include "rays/sampling.glsl"
#include "effects/occupancy/occupancy.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_RAYS) readonly buffer Rays { vw_ray rays[]; };
BUFFER(VW_SLOT_OCCUPANCY) readonly buffer Occupancy { float occupancy[]; };
BUFFER(VW_SLOT_KEPT_BITS) writeonly buffer KeptBits { uint kept_bits[]; };
BUFFER(VW_SLOT_KEPT_BEGINS) writeonly buffer KeptBegins { uint kept_begins[]; };
PUSH uniform Push { vw_push_samples push; };

void main() {
    uint index = invocation_index();
    if (index >= push.ray_count) return;
    bool warming_up = push.key.w == 0u && push.key.z <= VW_OCCUPANCY_WARM_UP;
    uint ray_index = push.first_ray + index;
    vw_ray ray = rays[ray_index];
    uint count = 0u;
    for (uint first = 0u; first < SAMPLES; first += 32u) {
        uint bits = 0u;
        for (uint i = 0u; i < min(32u, SAMPLES - first); i++) {
            vec3 position = position_at(ray, even_place(ray_index, first + i, push.key));
            bool keep = warming_up || occupied(occupancy[occupancy_cell(position)]);
            bits |= (keep ? 1u : 0u) << i;
        }
        kept_bits[index * VW_KEPT_WORDS(SAMPLES) + first / 32u] = bits;
        count += bitCount(bits);
    }
    kept_begins[index] = count;
}
