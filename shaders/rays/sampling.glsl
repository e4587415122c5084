// The places of a ray's samples, counted in strata from 0 to STRATA. Strata are equally long and lie between the box's
// faces; with the effect unbounded they are equal parts of the disparity between a near and a far distance from the
// camera:
//   u(s) = 1 / ((1 - s) / near + s / far) = near / w(s), w(s) = 1 - s + s near / far, for s = 0 at the near distance to
//   1 at the far one
// This form never subtracts nearly equal numbers, however distant the far end is.
// Every stratum has one even sample. place_samples lists the places of importance samples. Each represents the ray
// between the middles towards its neighbours, the first and the last one up to the ray's ends. Values that several
// passes compute from one ray are precise, so that they agree whatever a compiler fuses in each.
#ifndef SAMPLING_GLSL
#define SAMPLING_GLSL
#include "effects/contraction.glsl"
#include "random.glsl"

// Returns the position within the stratum: drawn for training, the centre for validation (decision 1).
float stratum_offset(uint ray, uint sample_in_ray, uvec4 key) {
    if (TRAINING == 0u) return 0.5;
    uvec4 words = random_words(RANDOM_JITTER, key, ray, sample_in_ray >> 2);
    return random_unit(words[sample_in_ray & 3u]);
}

// Returns the place of the even sample of a stratum.
float even_place(uint ray, uint stratum, uvec4 key) {
    precise float place = float(stratum) + stratum_offset(ray, stratum, key);
    return place;
}

// Returns w at a place.
float disparity_share(vw_ray ray, float place) {
    precise float share =
        (float(STRATA) - place + place * (ray.origin_near.w / ray.direction_stride.w)) / float(STRATA);
    return share;
}

// Returns 1 - near / far, exact to the last digits.
float disparity_gap(vw_ray ray) {
    precise float gap = (ray.direction_stride.w - ray.origin_near.w) / ray.direction_stride.w;
    return gap;
}

// Returns u(s) - near, the distance beyond the near distance, at which the ray's origin lies.
float disparity_parameter(vw_ray ray, float place) {
    precise float behind =
        ray.origin_near.w * disparity_gap(ray) * place / (float(STRATA) * disparity_share(ray, place));
    return behind;
}

// Returns the length of one stratum, in box edges.
float stratum_length(vw_ray ray, uint stratum) {
    precise float extent = ray.direction_stride.w;
    if (EFFECT_UNBOUNDED != 0u) {
        precise float place = float(stratum), shares = disparity_share(ray, place) * disparity_share(ray, place + 1.0);
        extent = ray.origin_near.w * disparity_gap(ray) / (float(STRATA) * shares);
    }
    return extent;
}

// Returns the length between two places, in box edges.
float length_between(vw_ray ray, float from, float to) {
    precise float extent = (to - from) * ray.direction_stride.w;
    if (EFFECT_UNBOUNDED != 0u)
        extent = ray.origin_near.w * disparity_gap(ray) * (to - from) /
                 (float(STRATA) * (disparity_share(ray, from) * disparity_share(ray, to)));
    return extent;
}

// Returns the distance that a ray of the box has from its origin at a place, and an unbounded one from the camera.
float distance_at(vw_ray ray, float place) {
    if (EFFECT_UNBOUNDED != 0u) return ray.origin_near.w + disparity_parameter(ray, place);
    return ray.origin_near.w + place * ray.direction_stride.w;
}

// Returns the position in the field's unit cube; the clamp affects only rounding at the faces and rays that miss.
vec3 position_at(vw_ray ray, float place) {
    if (EFFECT_UNBOUNDED != 0u) {
        float behind = disparity_parameter(ray, place);
        precise vec3 position = ray.origin_near.xyz + behind * ray.direction_stride.xyz;
        return clamp(contract(position), 0.0, 1.0);
    }
    precise float t = ray.origin_near.w + place * ray.direction_stride.w;
    precise vec3 position = ray.origin_near.xyz + t * ray.direction_stride.xyz;
    return clamp(position, 0.0, 1.0);
}

#endif
