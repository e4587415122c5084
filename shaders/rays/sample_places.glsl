// The samples of a ray as passes over them find them: one in each stratum, or with importance samples where
// place_samples put them.
#ifndef SAMPLE_PLACES_GLSL
#define SAMPLE_PLACES_GLSL
#include "rays/sampling.glsl"

BUFFER(VW_SLOT_PLACES) readonly buffer Places { float places[]; };

float sample_place(uint sample_of_chunk, uint ray, uint sample_in_ray, uvec4 key) {
    if (IMPORTANCE != 0u) return places[sample_of_chunk];
    return even_place(ray, sample_in_ray, key);
}

// Returns the length of the ray that a sample represents, in box edges.
float sample_length(vw_ray ray, uint sample_of_chunk, uint sample_in_ray) {
    if (IMPORTANCE == 0u) return stratum_length(ray, sample_in_ray);
    bool first = sample_in_ray == 0u, last = sample_in_ray + 1u == SAMPLES;
    float place = places[sample_of_chunk], before = places[sample_of_chunk - (first ? 0u : 1u)],
          behind = places[sample_of_chunk + (last ? 0u : 1u)];
    return length_between(ray, first ? 0.0 : 0.5 * (before + place), last ? float(STRATA) : 0.5 * (place + behind));
}

#endif
