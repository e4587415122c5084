// target[i] = factor * source[i] + OFFSET: read-only beside write-only.
#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;
#include "invocation.glsl"

layout(constant_id = 2) const uint OFFSET = 0;
layout(set = 1, binding = 0, scalar) uniform Push {
    uint count;
    uint factor;
};
layout(set = 0, binding = 0, scalar) readonly buffer Source { uint source[]; };
layout(set = 0, binding = 3, scalar) writeonly buffer Target { uint target[]; };

void main() {
    uint i = invocation_index();
    if (i < count) target[i] = factor * source[i] + OFFSET;
}
