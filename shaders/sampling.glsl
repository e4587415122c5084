// Where the samples of a ray lie: one in each of SAMPLES equal strata between the box's faces.
#ifndef SAMPLING_GLSL
#define SAMPLING_GLSL
#include "random.glsl"

// Position within the stratum: drawn for training, the centre for validation (decision 1).
float stratum_offset(uint ray, uint sample_in_ray, uint step_low, uint step_high) {
    if (TRAINING == 0u) return 0.5;
    uvec4 words = random_words(RANDOM_JITTER, step_low, step_high, ray, sample_in_ray >> 2);
    return random_unit(words[sample_in_ray & 3u]);
}

// In box coordinates; the clamp only meets rounding at the faces, and rays that miss.
vec3 sample_position(vw_ray ray, uint sample_in_ray, float offset) {
    float t = ray.origin_near.w + (float(sample_in_ray) + offset) * ray.direction_stride.w;
    return clamp(ray.origin_near.xyz + t * ray.direction_stride.xyz, 0.0, 1.0);
}

#endif
