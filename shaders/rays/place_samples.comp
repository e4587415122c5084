// Places a ray's samples where the field has matter; one ray per invocation. The even samples were rendered without a
// backward pass; stratum i got the compositing weight w_i. The places follow the inverse of their distribution, which
// is constant within a stratum (Mildenhall et al., "NeRF", ECCV 2020, section 5.2, equation 5): one drawn from each of
// SAMPLES equal shares of the whole weight, or its middle in validation. So they ascend. They are held fixed: no
// gradient goes through them.
#include "rays/composite.glsl"
#include "rays/sampling.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_RAYS) readonly buffer Rays { vw_ray rays[]; };
BUFFER(VW_SLOT_FIELD) readonly buffer Field { vec4 field[]; }; // at the even samples
BUFFER(VW_SLOT_KEPT_SAMPLES) writeonly buffer Places { uint places[]; };
PUSH uniform Push { vw_push_samples push; };

const float LEAST_WEIGHT = 1e-5; // added to each stratum's weight, as in NeRF's code: empty space gets even places

// A stratum on the way along the ray.
struct stratum {
    uint index;
    float tau_before, weight_before; // sums over the strata before
    float tau, weight;
};

void look(vw_ray ray, uint first, inout stratum at) {
    at.tau = field[first + at.index].w * stratum_length(ray, at.index);
    at.weight = transmittance(at.tau_before) * opacity(at.tau) + LEAST_WEIGHT;
}

void advance(vw_ray ray, uint first, inout stratum at) {
    at.tau_before += at.tau;
    at.weight_before += at.weight;
    at.index++;
    look(ray, first, at);
}

// Makes the places even, thus finite, if the field is not finite; rendering it shows the fault.
void make_even(inout stratum at, bool known) {
    if (known) return;
    at.weight = 1.0;
    at.weight_before = float(at.index);
}

float share_offset(uint ray, uint index, uvec4 key) {
    if (TRAINING == 0u) return 0.5;
    uvec4 words = random_words(RANDOM_IMPORTANCE, key, ray, index >> 2);
    return random_unit(words[index & 3u]);
}

void main() {
    uint index = invocation_index();
    if (index >= push.ray_count) return;
    uint ray_index = push.first_ray + index, first = index * STRATA;
    vw_ray ray = rays[ray_index];
    stratum at = stratum(0u, 0.0, 0.0, 0.0, 0.0);
    look(ray, first, at);
    while (at.index + 1u < STRATA) advance(ray, first, at);
    float total = at.weight_before + at.weight;
    bool known = finite(total);
    if (!known) total = float(STRATA);

    at = stratum(0u, 0.0, 0.0, 0.0, 0.0);
    look(ray, first, at);
    make_even(at, known);
    for (uint i = 0u; i < SAMPLES; i++) {
        float target = (float(i) + share_offset(ray_index, i, push.key)) / float(SAMPLES) * total;
        while (at.weight_before + at.weight <= target && at.index + 1u < STRATA) {
            advance(ray, first, at);
            make_even(at, known);
        }
        float within = clamp((target - at.weight_before) / at.weight, 0.0, 1.0);
        places[index * SAMPLES + i] = floatBitsToUint(float(at.index) + within);
    }
}
