// The samples of a training ray: all of its strata, or those that are kept, which stand in slots without gaps.
#ifndef RAY_SAMPLES_GLSL
#define RAY_SAMPLES_GLSL
#include "rays/sample_places.glsl"

BUFFER(VW_SLOT_KEPT_BEGINS) readonly buffer KeptBegins { uint kept_begins[]; };

// Finds the slots of a chunk's ray. Skipped samples have no density: they change neither colour nor gradient.
void ray_slots(uint index, out uint first, out uint count) {
    first = index * SAMPLES;
    count = SAMPLES;
    if (EFFECT_OCCUPANCY != 0u) {
        first = kept_begins[index];
        count = kept_begins[index + 1u] - first;
    }
}

// Returns the length that a ray's i-th sample, or its i-th kept one, represents.
float length_of(vw_ray ray, uint slot, uint i) {
    if (EFFECT_OCCUPANCY != 0u && EFFECT_UNBOUNDED != 0u) i = kept_samples[slot] % SAMPLES;
    return sample_length(ray, slot, i);
}

#endif
