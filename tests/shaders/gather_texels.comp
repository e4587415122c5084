// values[i] = texel i where the view reaches, else MISSING; the same buffer may be bound as storage in another pass.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;
#include "invocation.glsl"

layout(constant_id = 0) const uint MISSING = 7;
layout(set = 0, binding = 1) uniform usamplerBuffer texels;
layout(set = 0, binding = 2) writeonly buffer Values { uint values[]; };

void main() {
    uint i = invocation_index();
    if (i >= values.length()) return;
    values[i] = i < textureSize(texels) ? texelFetch(texels, int(i)).x : MISSING;
}
