// Rays with black targets whose colours are whole multiples of 2^-24: errors whose exact sum a host can form. Colour c
// of pixel i is (hash(3 i + c) & mask | constant) * 2^-24. An invocation makes pixels_each of them.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_RAYS) writeonly buffer Rays { vw_ray rays[]; };
BUFFER(VW_SLOT_COLOURS) writeonly buffer Colours { vec4 colours[]; };
PUSH uniform Push { uint first_pixel, pixel_count, mask, constant, pixels_each; };

uint hash(uint word) {
    word *= 2654435761u;
    word = (word ^ (word >> 15)) * 2246822519u;
    return word ^ (word >> 13);
}

float error(uint index) { return float(hash(index) & mask | constant) / 16777216.0; }

void main() {
    uint begin = invocation_index() * pixels_each;
    for (uint i = begin; i < min(begin + pixels_each, pixel_count); i++) {
        uint index = 3u * (first_pixel + i);
        colours[i] = vec4(error(index), error(index + 1u), error(index + 2u), 0.0);
        rays[i].target_weight = vec4(0.0, 0.0, 0.0, 1.0);
    }
}
