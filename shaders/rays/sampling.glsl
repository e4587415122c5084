// Where the samples of a ray lie. A place is counted in strata, from 0 to STRATA. They are equally long and lie between
// the box's faces; with the effect unbounded they are equal parts of the disparity between a near and a far distance
// from the camera:
//   u(s) = 1 / ((1 - s) / near + s / far) = near / w(s), w(s) = 1 - s + s near / far, for s = 0 at the near distance to
//   1 at the far one
// This form subtracts nothing from its like, however far far is.
// Every stratum has one even sample. The places of importance samples are listed by place_samples, and each stands for
// what lies between the middles towards its neighbours, the first and the last one as far as the ray reaches. What
// several passes compute from one ray is precise, so that they agree whatever a compiler fuses in each.
#ifndef SAMPLING_GLSL
#define SAMPLING_GLSL
#include "effects/contraction.glsl"
#include "random.glsl"

// Position within the stratum: drawn for training, the centre for validation (decision 1).
float stratum_offset(uint ray, uint sample_in_ray, uvec4 key) {
    if (TRAINING == 0u) return 0.5;
    uvec4 words = random_words(RANDOM_JITTER, key, ray, sample_in_ray >> 2);
    return random_unit(words[sample_in_ray & 3u]);
}

// Of the even sample of a stratum.
float even_place(uint ray, uint stratum, uvec4 key) {
    precise float place = float(stratum) + stratum_offset(ray, stratum, key);
    return place;
}

// w at a place.
float disparity_share(vw_ray ray, float place) {
    precise float share =
        (float(STRATA) - place + place * (ray.origin_near.w / ray.direction_stride.w)) / float(STRATA);
    return share;
}

// 1 - near / far, good to its last digits.
float disparity_gap(vw_ray ray) {
    precise float gap = (ray.direction_stride.w - ray.origin_near.w) / ray.direction_stride.w;
    return gap;
}

// u(s) - near: how far behind the near distance, where the ray's origin is.
float disparity_parameter(vw_ray ray, float place) {
    precise float behind =
        ray.origin_near.w * disparity_gap(ray) * place / (float(STRATA) * disparity_share(ray, place));
    return behind;
}

// Of one stratum, in box edges.
float stratum_length(vw_ray ray, uint stratum) {
    precise float extent = ray.direction_stride.w;
    if (EFFECT_UNBOUNDED != 0u) {
        precise float place = float(stratum), shares = disparity_share(ray, place) * disparity_share(ray, place + 1.0);
        extent = ray.origin_near.w * disparity_gap(ray) / (float(STRATA) * shares);
    }
    return extent;
}

// Between two places, in box edges.
float length_between(vw_ray ray, float from, float to) {
    precise float extent = (to - from) * ray.direction_stride.w;
    if (EFFECT_UNBOUNDED != 0u)
        extent = ray.origin_near.w * disparity_gap(ray) * (to - from) /
                 (float(STRATA) * (disparity_share(ray, from) * disparity_share(ray, to)));
    return extent;
}

// In the field's unit cube; the clamp only meets rounding at the faces, and rays that miss.
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
