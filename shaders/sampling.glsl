// Where the samples of a ray lie: one in each of SAMPLES strata. They are equally long and lie between the box's faces; with the effect
// unbounded they are equal parts of the disparity between a near and a far distance from the camera:
//   u(s) = 1 / ((1 - s) / near + s / far) = near / w(s), w(s) = 1 - s + s near / far, for s = 0 at the near distance to 1 at the far one
// This form subtracts nothing from its like, however far far is.
// What several passes compute from one ray is precise, so that they agree whatever a compiler fuses in each.
#ifndef SAMPLING_GLSL
#define SAMPLING_GLSL
#include "contraction.glsl"
#include "random.glsl"

// Position within the stratum: drawn for training, the centre for validation (decision 1).
float stratum_offset(uint ray, uint sample_in_ray, uvec4 key) {
    if (TRAINING == 0u) return 0.5;
    uvec4 words = random_words(RANDOM_JITTER, key, ray, sample_in_ray >> 2);
    return random_unit(words[sample_in_ray & 3u]);
}

// w at stratum `place`, which may be a fraction.
float disparity_share(vw_ray ray, float place) {
    precise float share = (float(SAMPLES) - place + place * (ray.origin_near.w / ray.direction_stride.w)) / float(SAMPLES);
    return share;
}

// 1 - near / far, good to its last digits.
float disparity_gap(vw_ray ray) {
    precise float gap = (ray.direction_stride.w - ray.origin_near.w) / ray.direction_stride.w;
    return gap;
}

// u(s) - near: how far behind the near distance, where the ray's origin is.
float disparity_parameter(vw_ray ray, float place) {
    precise float behind = ray.origin_near.w * disparity_gap(ray) * place / (float(SAMPLES) * disparity_share(ray, place));
    return behind;
}

// Of one stratum, in box edges.
float stratum_length(vw_ray ray, uint sample_in_ray) {
    precise float extent = ray.direction_stride.w;
    if (EFFECT_UNBOUNDED != 0u) {
        precise float place = float(sample_in_ray), shares = disparity_share(ray, place) * disparity_share(ray, place + 1.0);
        extent = ray.origin_near.w * disparity_gap(ray) / (float(SAMPLES) * shares);
    }
    return extent;
}

// In the field's unit cube; the clamp only meets rounding at the faces, and rays that miss.
vec3 sample_position(vw_ray ray, uint sample_in_ray, float offset) {
    if (EFFECT_UNBOUNDED != 0u) {
        float behind = disparity_parameter(ray, float(sample_in_ray) + offset);
        precise vec3 place = ray.origin_near.xyz + behind * ray.direction_stride.xyz;
        return clamp(contract(place), 0.0, 1.0);
    }
    precise float t = ray.origin_near.w + (float(sample_in_ray) + offset) * ray.direction_stride.w;
    precise vec3 place = ray.origin_near.xyz + t * ray.direction_stride.xyz;
    return clamp(place, 0.0, 1.0);
}

#endif
