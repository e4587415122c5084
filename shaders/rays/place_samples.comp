// Places a ray's samples where the field has matter; one ray per RAY_LANES invocations. The even samples were rendered
// without a backward pass; stratum i got the compositing weight w_i. The places follow the inverse of their
// distribution, which is constant within a stratum (Mildenhall et al., "NeRF", ECCV 2020, section 5.2, equation 5): one
// drawn from each of SAMPLES equal shares of the whole weight, or its middle in validation. So they ascend. They are
// held fixed: no gradient goes through them.
#include "rays/composite.glsl"
#include "rays/ray_lanes.glsl"
#include "rays/sampling.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_RAYS) readonly buffer Rays { vw_ray rays[]; };
BUFFER(VW_SLOT_FIELD) readonly buffer Field { vec4 field[]; }; // at the even samples
BUFFER(VW_SLOT_PLACES) writeonly buffer Places { float places[]; };
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

const uint RUN = (STRATA + RAY_LANES - 1u) / RAY_LANES; // strata of a lane
const float NOWHERE = 3e38;

// Returns the last lane whose strata begin at or below the target: in of_lanes are the sums before each lane's strata.
uint find_lane(float target) {
    uint begin = gl_LocalInvocationID.x - ray_lane(), found = 0u;
    for (uint distance = RAY_LANES / 2u; distance > 0u; distance /= 2u)
        found += of_lanes[begin + found + distance].y <= target ? distance : 0u;
    return found;
}

stratum first_of(vw_ray ray, uint first, uint lane, bool known) {
    vec4 before = vec4(0.0);
    if (RAY_LANES > 1u) before = of_lanes[gl_LocalInvocationID.x - ray_lane() + lane];
    stratum at = stratum(lane * RUN, before.x, before.y, 0.0, 0.0);
    look(ray, first, at);
    make_even(at, known);
    return at;
}

void main() {
    uint index = invocation_index() / RAY_LANES;
    bool beyond = index >= push.ray_count;
    if (RAY_LANES == 1u && beyond) return;
    if (beyond) index = push.ray_count - 1u; // such lanes meet the others at barriers
    uint ray_index = push.first_ray + index, first = index * STRATA, begin, end;
    vw_ray ray = rays[ray_index];
    lane_run(STRATA, begin, end);
    stratum at = stratum(begin, 0.0, 0.0, 0.0, 0.0);
    vec4 all;
    if (RAY_LANES > 1u) {
        float tau = 0.0;
        for (uint i = begin; i < end; i++) tau += field[first + i].w * stratum_length(ray, i);
        at.tau_before = sum_beside(vec4(tau), false, all).x;
    }
    float tau_before = at.tau_before, weight = 0.0;
    for (; at.index < end; at.index++) {
        look(ray, first, at);
        weight += at.weight;
        at.tau_before += at.tau;
    }
    float weight_before = sum_beside(vec4(weight), false, all).x, total = all.x;
    bool known = finite(total);
    if (!known) {
        total = float(STRATA);
        weight_before = float(begin);
    }
    if (RAY_LANES > 1u) {
        of_lanes[gl_LocalInvocationID.x] = vec4(tau_before, begin < end ? weight_before : NOWHERE, 0.0, 0.0);
        barrier();
        if (beyond) return;
    }

    uint lane = 0u;
    at = first_of(ray, first, lane, known);
    lane_run(SAMPLES, begin, end);
    for (uint i = begin; i < end; i++) {
        float target = (float(i) + share_offset(ray_index, i, push.key)) / float(SAMPLES) * total;
        if (RAY_LANES > 1u) {
            uint found = find_lane(target);
            if (found != lane) at = first_of(ray, first, found, known);
            lane = found;
        }
        // No lane goes beyond the strata of one, whose sums agree for all: so the places ascend.
        uint last = min((lane + 1u) * RUN, STRATA) - 1u;
        while (at.weight_before + at.weight <= target && at.index < last) {
            advance(ray, first, at);
            make_even(at, known);
        }
        float within = clamp((target - at.weight_before) / at.weight, 0.0, 1.0);
        places[index * SAMPLES + i] = float(at.index) + within;
    }
}
