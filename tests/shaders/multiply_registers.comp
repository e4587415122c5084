// Keeps a device busy: multiply-adds in registers, in eight independent chains of vec4. What comes out does not matter,
// but has to go somewhere, or the compiler would drop it all.
#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;
#include "invocation.glsl"

const uint TRIPS = 128, REPEATS = 16;
layout(set = 1, binding = 0, scalar) uniform Push { float start, factor; };
layout(set = 0, binding = 0, scalar) writeonly buffer To { vec4 to[]; };

void main() {
    vec4 chain[8];
    [[unroll]] for (uint i = 0u; i < 8u; i++) chain[i] = vec4(float(i) + start);
    for (uint trip = 0u; trip < TRIPS; trip++) {
        [[unroll]] for (uint turn = 0u; turn < REPEATS; turn++) {
            [[unroll]] for (uint i = 0u; i < 8u; i++) chain[i] = chain[i] * factor + start;
        }
    }
    vec4 sum = vec4(0.0);
    [[unroll]] for (uint i = 0u; i < 8u; i++) sum += chain[i];
    to[invocation_index() % uint(to.length())] = sum; // there is no room for all
}
